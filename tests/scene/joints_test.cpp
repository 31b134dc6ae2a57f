// Misuse of joints is refused with place, problem and remedy, and without further findings.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "assur/plan.hpp"
#include "assur/scene.hpp"
#include "assur/simulator.hpp"
#include "assur/status.hpp"
#include "structure/grouped_system.hpp"

namespace assur {
namespace {

std::string refusal(int dimension, const std::string& rest) {
  try {
    (void)parse_scene("{\"assur\": 1, \"dimension\": " + std::to_string(dimension) + ", " + rest + "}");
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

// The refusal of a scene with two bodies and these joints.
std::string with(int dimension, const std::string& joints, const std::string& more = "") {
  return refusal(dimension, R"("bodies": {"a": {}, "b": {}}, "joints": {)" + joints + "}" + more);
}

TEST(JointFiles, NameWrongBodies) {
  EXPECT_EQ(with(2, R"("J": {"revolute": ["a", "c"], "at": [0, 0]})"),
            "scene: /joints/J/revolute/1: there is no body 'c'; there are: a, b, ground");
  EXPECT_EQ(with(2, R"("J": {"revolute": ["a", "a"], "at": [0, 0]})"),
            "scene: /joints/J: both bodies are 'a'; a joint connects two different bodies");
  EXPECT_EQ(
      refusal(2, R"("bodies": {"a": {}, "b": {}, "c": {}}, "joints": {"J": {"revolute": ["a", "b"], "at": [0, 0]}})"),
      "scene: /bodies/c: no joint places this body; a body needs a base, joints, or \"rigid\" points");
}

// One mistake has one finding, with the place in the file.
TEST(JointFiles, NameWrongShapes) {
  EXPECT_EQ(with(2, R"("J": {"revolute": ["a"], "at": [0, 0]})"),
            "scene: /joints/J/revolute: 2 items are wanted here, e.g. [\"frame\", \"crank\"], not 1");
  EXPECT_EQ(with(2, R"("J": {"revolute": ["a", "b", "ground"], "at": [0, 0]})"),
            "scene: /joints/J/revolute: 2 items are wanted here, e.g. [\"frame\", \"crank\"], not 3");
  EXPECT_EQ(with(2, R"("J": {"hinge": ["a", "b"], "at": [0, 0]})"),
            "scene: /joints/J: the kind is missing; expected one of revolute, prismatic, cylindrical, spherical, "
            "universal, planar or fixed");
  EXPECT_EQ(with(2, R"("J": {"revolut": ["a", "b"], "at": [0, 0]})"),
            "scene: /joints/J/revolut: unknown key 'revolut'; did you mean 'revolute'?");
  EXPECT_EQ(with(2, R"("J": {"revolute": ["a", "b"], "fixed": ["a", "b"], "at": [0, 0]})"),
            "scene: /joints/J/fixed: both 'revolute' and 'fixed' are given; an item has exactly one kind");
  EXPECT_EQ(with(2, R"("J": {"revolute": ["a", "b"]})"),
            "scene: /joints/J/at: this is missing: a place on the axis, [x, y] in the ground as written or the name of "
            "a point");
  EXPECT_EQ(with(2, R"("J": {"revolute": ["a", "b"], "at": [0, 0, 0]})"),
            "scene: /joints/J/at: 2 numbers [x, y] are wanted in a scene of dimension 2, not 3");
  EXPECT_EQ(with(3, R"("J": {"spherical": ["a", "b"], "at": [0, 0]})"),
            "scene: /joints/J/at: 3 numbers [x, y, z] are wanted in a scene of dimension 3, not 2");
  EXPECT_EQ(with(2, R"("J": {"revolute": ["a", "b"], "at": ["=1/0", 0]})"),
            "scene: /joints/J/at/0: '=1/0' is inf; a finite number is wanted");
}

TEST(JointFiles, NameWrongPlaces) {
  const std::string items = R"(, "points": {"P": {"at": [0, 0, 0]}}, "vectors": {"u": {"at": [1, 0, 0]},
                               "long": {"at": [2, 0, 0], "unit": false}})";
  EXPECT_EQ(with(3, R"("J": {"spherical": ["a", "b"], "at": "Q"})", items),
            "scene: /joints/J/at: there is no point 'Q'; there are: P");
  EXPECT_EQ(with(3, R"("J": {"spherical": ["a", "b"], "at": "u"})", items),
            "scene: /joints/J/at: 'u' is a vector; a point is wanted here");
  EXPECT_EQ(with(3, R"("J": {"prismatic": ["a", "b"], "axis": "P"})", items),
            "scene: /joints/J/axis: 'P' is a point; a unit vector is wanted here");
  EXPECT_EQ(with(3, R"("J": {"prismatic": ["a", "b"], "axis": "long"})", items),
            "scene: /joints/J/axis: there is no unit vector 'long'; there are: u");
  EXPECT_EQ(with(3, R"("J": {"revolute": ["ground", "b"], "at": [0, 0, 0], "axis": "u"})", items),
            "scene: /joints/J/axis: 'u' is not fixed, but joint 'J' connects it to the ground");
}

TEST(JointFiles, NameWrongAxes) {
  const std::string at = R"("at": [0, 0, 0], )";
  EXPECT_EQ(with(3, R"("J": {"revolute": ["a", "b"], )" + at + R"("axis": [0, 0, 0]})"),
            "scene: /joints/J/axis: the axis is zero or missing; give a direction, e.g. [0, 0, 1]");
  EXPECT_EQ(with(3, R"("J": {"revolute": ["a", "b"], "at": [0, 0, 0]})"),
            "scene: /joints/J/axis: the axis is zero or missing; give a direction, e.g. [0, 0, 1]");
  EXPECT_EQ(with(3, R"("J": {"prismatic": ["a", "b"], "axis": "u"})"),
            "scene: /joints/J/axis: there is no unit vector 'u'");
  EXPECT_EQ(with(3, R"("J": {"universal": ["a", "b"], )" + at + R"("axes": [[1, 0, 0], [1, 1, 0]]})"),
            "scene: /joints/J/axes: the axes have the dot product 0.707107; those of a universal joint are at right "
            "angles");
  EXPECT_EQ(with(3, R"("J": {"universal": ["a", "b"], )" + at + R"("axes": [[1, 0, 0], [-2, 0, 0]]})"),
            "scene: /joints/J/axes: the axes are parallel; those of a universal joint are at right angles");
  EXPECT_EQ(with(3, R"("J": {"universal": ["a", "b"], )" + at + R"("axes": [[0, 0, 0], [1, 0, 0]]})"),
            "scene: /joints/J/axes/0: the axis is zero or missing; give a direction, e.g. [0, 0, 1]");
  EXPECT_EQ(with(3, R"("J": {"universal": ["a", "b"], )" + at + R"("axes": [[1, 0, 0]]})"),
            "scene: /joints/J/axes: 2 items are wanted here, e.g. [\"u\", \"v\"], not 1");
  EXPECT_EQ(with(3, R"("J": {"cylindrical": ["a", "b"], )" + at + R"("axis": [0, 0, 0]})"),
            "scene: /joints/J/axis: the axis is zero or missing; give a direction, e.g. [0, 0, 1]");
  EXPECT_EQ(with(2, R"("J": {"prismatic": ["a", "b"], "axis": [0, 0]})"),
            "scene: /joints/J/axis: the axis is zero or missing; give a direction, e.g. [0, 0, 1]");
  EXPECT_EQ(with(3, R"("J": {"planar": ["a", "b"], "normal": [0, 0, 0]})"),
            "scene: /joints/J/normal: the normal is zero or missing; give a direction, e.g. [0, 0, 1]");
  EXPECT_EQ(with(3, R"("J": {"revolute": ["a", "b"], )" + at + R"("axis": [0, 1]})"),
            "scene: /joints/J/axis: 3 numbers [x, y, z] are wanted in a scene of dimension 3, not 2");
  EXPECT_EQ(with(2, R"("J": {"prismatic": ["a", "b"], "axis": [0, 0, 1]})"),
            "scene: /joints/J/axis: 2 numbers [x, y] are wanted in a scene of dimension 2, not 3");
  EXPECT_EQ(with(2, R"("J": {"revolute": ["a", "b"], "at": [0, 0], "axis": [0, 1]})"),
            "scene: /joints/J/axis: in the plane every axis is the normal; leave \"axis\" out");
  for (const std::string kind : {"spherical", "cylindrical", "universal", "planar"}) {
    const std::string rest = kind == "planar"      ? R"("normal": [0, 1]})"
                             : kind == "spherical" ? R"("at": [0, 0]})"
                             : kind == "universal" ? R"("at": [0, 0], "axes": [[1, 0], [0, 1]]})"
                                                   : R"("at": [0, 0], "axis": [1, 0]})";
    EXPECT_EQ(with(2, "\"J\": {\"" + kind + R"(": ["a", "b"], )" + rest),
              "scene: /joints/J/" + kind + ": " + kind +
                  " joints are for 3D; in the plane there are revolute, prismatic and fixed");
  }
}

TEST(JointFiles, NameWrongCoordinates) {
  const std::string joint = R"("J": {"revolute": ["ground", "a"], "at": [0, 0]})";
  const auto driven = [](const std::string& coordinate) {
    return R"(, "drivers": {"m": {"coordinate": ")" + coordinate + R"(", "law": {"polynomial": [0, 1]}}})";
  };
  const std::string two = joint + R"(, "K": {"revolute": ["a", "b"], "at": [1, 0]})";
  EXPECT_EQ(with(2, two, driven("J.displacement")),
            "scene: /drivers/m/coordinate: joint 'J' is revolute and has no displacement; it has: angle");
  EXPECT_EQ(with(2, two, driven("J.angel")),
            "scene: /drivers/m/coordinate: joint 'J' is revolute and has no angel; did you mean 'J.angle'?");
  EXPECT_EQ(with(2, two, driven("J.angle.rate")),
            "scene: /drivers/m/coordinate: joint 'J' is revolute and has no angle.rate; it has: angle");
  EXPECT_EQ(with(2, two, driven("J")),
            "scene: /drivers/m/coordinate: 'J' is a joint; write one of its coordinates, such as 'J.angle'");
  EXPECT_EQ(with(2, two, driven("L.angle")),
            "scene: /drivers/m/coordinate: there is no point, vector or constraint 'L'");
  EXPECT_EQ(with(2, two, driven("J.angle")), "accepted");
  EXPECT_EQ(with(2, two, R"(, "measures": {"m": {"coordinate": "K.displacement"}})"),
            "scene: /measures/m/coordinate: joint 'K' is revolute and has no displacement; it has: angle");
  EXPECT_EQ(with(2, two, R"(, "outputs": ["J", "K.displacement"])"),
            "scene: /outputs/1: joint 'K' is revolute and has no displacement; it has: angle");
  EXPECT_EQ(with(2, two, R"(, "constraints": {"g": {"gear": ["J.angle", "K.displacement"], "ratio": 2}})"),
            "scene: /constraints/g/gear/1: joint 'K' is revolute and has no displacement; it has: angle");
  EXPECT_EQ(with(2, two, R"(, "constraints": {"g": {"gear": ["J.angle", "b"], "ratio": 2}})"),
            "scene: /constraints/g/gear/1: 'b' is no coordinate of a joint; write JOINT.angle or JOINT.displacement");
  EXPECT_EQ(with(2, two, R"(, "constraints": {"g": {"gear": ["J.angle", "J.angle"], "ratio": 2}})"),
            "scene: /constraints/g/gear: both coordinates are 'J.angle'");
  EXPECT_EQ(with(2, two, R"(, "drivers": {"m": {"coordinate": "K.angle", "law": {"constant": 0}},
                             "n": {"coordinate": "K.angle", "law": {"constant": 1}}})"),
            "scene: /drivers/n/coordinate: 'm' drives 'K.angle' already; use one driver for each motion");
  const auto only = [&](const std::string& kind, const std::string& rest, const std::string& part) {
    return with(3, "\"J\": {\"" + kind + R"(": ["ground", "a"], )" + rest + R"(, "K": {"fixed": ["a", "b"]})",
                driven("J." + part));
  };
  const std::string at = R"("at": [0, 0, 0])", axis = R"("axis": [0, 0, 1]})";
  EXPECT_EQ(only("prismatic", axis, "angle"),
            "scene: /drivers/m/coordinate: joint 'J' is prismatic and has no angle; it has: displacement");
  EXPECT_EQ(only("cylindrical", at + ", " + axis, "displacment"),
            "scene: /drivers/m/coordinate: joint 'J' is cylindrical and has no displacment; did you mean "
            "'J.displacement'?");
  EXPECT_EQ(only("spherical", at + "}", "angle"),
            "scene: /drivers/m/coordinate: joint 'J' is spherical; only revolute, prismatic and cylindrical joints "
            "have coordinates");
}

// Outputs that misspell a coordinate, or name a joint that has no point; places count the outputs as written.
TEST(JointFiles, NameWrongOutputs) {
  const std::string slides = R"("bodies": {"a": {}, "b": {}, "c": {}}, "joints": {
      "J": {"revolute": ["ground", "a"], "at": [0, 0]}, "S": {"prismatic": ["a", "b"], "axis": [1, 0]},
      "M": {"revolute": ["b", "c"], "at": "Q"}}, "points": {"Q": {"at": [2, 1]}}, "outputs": [)";
  EXPECT_EQ(refusal(2, slides + R"("a", "J", "S.displacment"])"),
            "scene: /outputs/2: joint 'S' is prismatic and has no displacment; did you mean 'S.displacement'?");
  EXPECT_EQ(refusal(2, slides + R"("S.displacment.rate"])"),
            "scene: /outputs/0: joint 'S' is prismatic and has no displacment; did you mean 'S.displacement'?");
  EXPECT_EQ(refusal(2, slides + R"("J.angel"])"),
            "scene: /outputs/0: joint 'J' is revolute and has no angel; did you mean 'J.angle'?");
  EXPECT_EQ(refusal(2, slides + R"("a", "S"])"),
            "scene: /outputs/1: 'S' is a joint without a point of its own; its outputs are: 'S.displacement'");
  EXPECT_EQ(refusal(2, slides + R"("M"])"),
            "scene: /outputs/0: 'M' is a joint without a point of its own; its outputs are: 'M.angle', 'Q'");
  EXPECT_EQ(refusal(2, slides + R"("a", "b", "nobody"])"),
            "scene: /outputs/2: there is no point, vector or measure 'nobody'; there are: Q, a.origin, J, S.axis, "
            "S.origin, b.origin, a.angle, b.angle");
}

// The name is the fault, and not the lack of a joint.
TEST(JointFiles, NameABodyWithABadName) {
  EXPECT_EQ(refusal(2, R"("bodies": {"a": {}, "my rod": {}}, "joints": {"J": {"revolute": ["ground", "a"],
                          "at": [0, 0]}})"),
            "scene: /bodies/my rod: 'my rod' is not a name; use letters, digits and _, and no digit first");
}

// Two joints of one pair of bodies may lock them.
TEST(JointFiles, NameCoordinatesThatOtherJointsLock) {
  const std::string locked = R"("J": {"prismatic": ["ground", "a"], "axis": [1, 0]},
                                "K": {"revolute": ["ground", "a"], "at": [0, 0]}, "L": {"fixed": ["a", "b"]})";
  const std::string why = "joint 'J' cannot slide, because other joints hold both of its bodies";
  EXPECT_EQ(with(2, locked), "accepted");
  EXPECT_EQ(with(2, locked, R"(, "drivers": {"m": {"coordinate": "J.displacement", "law": {"polynomial": [0, 1]}}})"),
            "scene: /drivers/m/coordinate: " + why);
  // its displacement is the constant 0
  EXPECT_EQ(with(2, locked, R"(, "measures": {"m": {"coordinate": "J.displacement"}})"), "accepted");
  EXPECT_EQ(with(2, locked, R"(, "outputs": ["K", "J.displacement"])"), "accepted");
  // A door with two hinges on one axis, of which the second one may slide.
  EXPECT_EQ(with(3, R"("J": {"cylindrical": ["ground", "a"], "at": [0, 0, 1], "axis": [0, 0, 1]},
                       "K": {"revolute": ["ground", "a"], "at": [0, 0, 0], "axis": [0, 0, 1]}, "L": {"fixed": ["a", "b"]})",
                 R"(, "drivers": {"m": {"coordinate": "K.angle", "law": {"polynomial": [0, 1]}}})"),
            "accepted");
}

// A joint parallel to a fixed one cannot move. Its coordinates are the constant 0.
TEST(JointFiles, AJointParallelToAFixedOneCannotMove) {
  const std::string held = R"("K": {"revolute": ["ground", "a"], "at": [0, 0, 0], "axis": [0, 0, 1]},
                              "F": {"fixed": ["a", "b"]},
                              "J": {"cylindrical": ["a", "b"], "at": [1, 0, 0], "axis": [0, 1, 0]})";
  const std::string driven = R"(, "drivers": {"m": {"coordinate": "J.angle", "law": {"polynomial": [0, 1]}}})";
  EXPECT_EQ(with(3, held, driven),
            "scene: /drivers/m/coordinate: joint 'J' cannot move, because fixed joints connect its bodies");
  const Scene scene = parse_scene(
      R"({"assur": 1, "name": "held", "dimension": 3, "bodies": {"a": {}, "b": {}}, "joints": {)" + held + R"(},
          "drivers": {"m": {"coordinate": "K.angle", "law": {"polynomial": [0, 1]}}},
          "measures": {"angle": {"coordinate": "J.angle"}, "way": {"coordinate": "J.displacement"}},
          "outputs": ["J", "angle", "way"], "time": {"start": 0, "end": 1, "step": 0.5}})");
  ASSERT_EQ(scene.warnings().size(), 1u);
  EXPECT_EQ(scene.warnings()[0].where, "/joints/J");
  EXPECT_EQ(scene.warnings()[0].what, "the joint cannot move, because fixed joints connect its bodies");
  const GroupedSystem structure = group_equations(scene);
  EXPECT_EQ(structure.mobility, 1);
  EXPECT_EQ(structure.redundant.size(), 4u);
  Simulator simulator(prepare(scene));
  const Trajectory motion = simulator.run();
  ASSERT_TRUE(simulator.report().status.ok());
  EXPECT_NEAR(motion.last("J.x"), std::cos(1), 1e-15);
  EXPECT_EQ(motion.last("angle"), 0);
  EXPECT_EQ(motion.last("way"), 0);
}

// Many wrong joints cost time in proportion to their number: only the first messages have a suggestion.
TEST(JointFiles, ManyMistakesAreFoundInTime) {
  std::string bodies, joints;
  for (int i = 0; i < 20'000; ++i) {
    const std::string k = std::to_string(i);
    bodies += (i == 0 ? "\"b" : ", \"b") + k + "\": {}";
    joints += (i == 0 ? "\"J" : ", \"J") + k + R"(": {"revolute": ["b)" + k + R"(", "c)" + k + R"("], "at": [0, 0]})";
  }
  const std::string refused = refusal(2, "\"bodies\": {" + bodies + "}, \"joints\": {" + joints + "}");
  EXPECT_TRUE(refused.starts_with("scene: /joints/J0/revolute/1: there is no body 'c0'; did you mean 'b0'?"))
      << refused.substr(0, 200);
  EXPECT_TRUE(refused.ends_with("and 19000 more findings")) << refused.substr(refused.size() - 200);
}

TEST(JointFiles, ShareNamesWithAllKinds) {
  EXPECT_EQ(with(2, R"("a": {"revolute": ["a", "b"], "at": [0, 0]})"),
            "scene: /joints/a: 'a' is the name of something else already; all kinds share one set of names");
  EXPECT_EQ(with(2, R"("J": {"revolute": ["ground", "a"], "at": [0, 0]})", R"(, "points": {"J": {"at": [0, 0]}})"),
            "scene: /joints/J: 'J' is the name of something else already; all kinds share one set of names");
  EXPECT_EQ(refusal(2, R"("constraints": {"J": {"revolute": ["a", "b"], "at": [0, 0]}})"),
            "scene: /constraints/J/revolute: this is a joint; joints have a section of their own, \"joints\"");
}

TEST(JointFiles, BodiesWithoutBaseHaveMembersInTheGround) {
  EXPECT_EQ(refusal(2, R"("bodies": {"a": {"points": {"P": [1, 0]}}}, "joints": {"J": {"revolute": ["ground", "a"],
                         "at": [0, 0]}})"),
            "scene: /bodies/a/points/P: the body has no frame of its own; give ground coordinates of the posture as "
            "written, {\"at\": [...]}");
}

// A rod may turn about the line through its joints; members on this line are determined nevertheless.
TEST(JointFiles, RodsHaveMembersOnTheirLine) {
  const Scene scene = parse_scene(R"({"assur": 1, "dimension": 3,
      "bodies": {"rod": {"points": {"M": {"at": [0.5, 0, 0]}}}, "arm": {}},
      "joints": {"S": {"spherical": ["ground", "rod"], "at": [0, 0, 0]},
                 "T": {"spherical": ["rod", "arm"], "at": [1, 0, 0]},
                 "R": {"revolute": ["arm", "ground"], "at": [2, 1, 0], "axis": [0, 0, 1]}}})");
  ASSERT_EQ(scene.bodies().size(), 2u);
  EXPECT_EQ(scene.bodies()[0].base, (std::vector<std::string>{"S", "T"}));
  ASSERT_EQ(scene.bodies()[0].points.size(), 1u);
  EXPECT_EQ(scene.bodies()[0].points[0].local, (Triple{0.5, 0, 0}));
  ASSERT_EQ(scene.warnings().size(), 1u);
  EXPECT_EQ(scene.warnings()[0].where, "/bodies/rod");
}

// A point of a rod between two balls: rounding away from the end of the rod it is on the line, farther it is not.
TEST(JointMembers, NearTheEndOfARodAreOnItsLine) {
  const auto rod = [](double y) {
    SceneBuilder b("rod", 3);
    b.add(Body{.name = "a"}).add(Body{.name = "b"});
    b.add(Body{.name = "c", .points = {{.name = "M", .local = {0.4, y, 0.05}, .in_ground = true}}});
    b.joint("A", Revolute{"ground", "a", Triple{0, 0, 0}, Triple{0, 0, 1}});
    b.joint("P", Spherical{"a", "c", Triple{0.4, 0.1, 0.05}}).joint("Q", Spherical{"c", "b", Triple{0.9, 1.6, 0.5}});
    b.joint("B", Revolute{"ground", "b", Triple{1.5, 0.6, 0.4}, Triple{0.3, 0.1, 1}});
    b.drive("m", DrivenCoordinate{"A.angle", Law::polynomial({0, 6})}).output("M");
    return b.time(0, 1, 0.01).build();
  };
  for (const double y : {0.1, std::nextafter(0.1, 1), 0.1 + 2e-16}) EXPECT_NO_THROW((void)rod(y)) << y - 0.1;
  EXPECT_THROW((void)prepare(rod(0.1 + 1e-6)), Error);  // beside the line, and the rod spins
}

}  // namespace
}  // namespace assur
