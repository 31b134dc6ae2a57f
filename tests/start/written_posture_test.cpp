// The written posture of a scene: laws relative to it, points of bodies in ground coordinates, and files in degrees.
#include <gtest/gtest.h>

#include <numbers>

#include "plan/preparation.hpp"
#include "simulation/run.hpp"

namespace assur {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180;

std::string refusal(const std::string& text) {
  try {
    (void)prepare(parse_scene(text));
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

// A cylinder of length 5 at the angle atan2(4, 3). Its length grows by 0.2 m/s, and it turns by 0.1 rad/s.
TEST(RelativeLaws, CountFromTheWrittenPosture) {
  const Scene scene = SceneBuilder("crane", 2)
                          .fixed_point("A", {0, 0})
                          .fixed_point("X", {1, 0})
                          .point("B", {3, 4})
                          .drive("boom", RelativeAngle{{"A", "X"}, {"A", "B"}, "", Law::polynomial({0, 0.1})}, true)
                          .drive("cylinder", DrivenDistance{"A", "B", Law::polynomial({0, 0.2})}, true)
                          .time(0, 1, 0.25)
                          .build();
  const test::Result r = test::run(scene);
  EXPECT_TRUE(preparation(r.simulator.prepared()).structure->notes.empty());
  for (std::size_t k = 0; k < r.trajectory.rows(); ++k) {
    const double t = r.trajectory.times()[k], length = 5 + 0.2 * t, angle = std::atan2(4, 3) + 0.1 * t;
    const auto at = [&](const char* column) { return r.trajectory(k, r.trajectory.index(column)); };
    EXPECT_NEAR(at("B.x"), length * std::cos(angle), 64 * kEps * length);
    EXPECT_NEAR(at("B.y"), length * std::sin(angle), 64 * kEps * length);
    EXPECT_NEAR(at("B.vx"), 0.2 * std::cos(angle) - 0.1 * length * std::sin(angle), 1e-13);
  }
}

TEST(RelativeLaws, WorkForEveryOtherDriver) {
  const Scene scene = parse_scene(R"({"assur": 1, "dimension": 2,
      "points": {"A": {"at": [0, 0], "fixed": true}, "B": {"at": [0, 2]}, "C": {"at": [1, 5]}, "D": {"at": [3, 5]},
                 "S": {"at": [7, 1]}},
      "bodies": {"plate": {"base": ["C", "D"]}},
      "constraints": {"rail": {"coordinate": "S.y", "value": 1}},
      "drivers": {"crank": {"angle": ["A", "B"], "law": {"polynomial": [0, 1]}, "relative": true},
                  "slide": {"coordinate": "S.x", "law": {"polynomial": [0, -2]}, "relative": true},
                  "hand": {"pose": "plate", "translation": [{"polynomial": [0, 1]}, {"constant": 0}],
                           "rotation": {"angle": {"polynomial": [0, 0.5]}}, "relative": true}},
      "time": {"start": 0, "end": 1, "step": 0.5}})");
  const test::Result r = test::run(scene);
  const Trajectory& motion = r.trajectory;
  EXPECT_NEAR(motion.last("B.x"), 2 * std::cos(kPi / 2 + 1), 1e-14);
  EXPECT_NEAR(motion.last("S.x"), 5, 1e-14);
  EXPECT_NEAR(motion.last("C.x"), 2, 1e-14);
  EXPECT_NEAR(motion.last("D.y"), 5 + 2 * std::sin(0.5), 1e-14);
}

TEST(RelativeLaws, AreRefusedWithoutAStartValue) {
  const std::string front = R"({"assur": 1, "dimension": 2,
      "points": {"A": {"at": [0, 0], "fixed": true}, "X": {"at": [1, 0], "fixed": true}, "B": {"at": )";
  const std::string behind = R"(, "time": {"start": 0, "end": 1, "step": 0.5}})";
  EXPECT_EQ(refusal(front + R"([0, 0]}}, "constraints": {"l": {"distance": ["A", "B"], "value": 1}},
      "drivers": {"m": {"angle": [["A", "X"], ["A", "B"]], "law": {"constant": 0}, "relative": true}})" +
                    behind),
            "/drivers/m: the law is relative to an undefined angle: in the posture as written its second direction has "
            "no length");
  EXPECT_EQ(refusal(front + R"([1, 0]}}, "constraints": {"y": {"coordinate": "B.y", "value": 0}},
      "drivers": {"m": {"distance": ["A", "B"], "law": {"constant": -2}, "relative": true}})" +
                    behind),
            "/drivers/m/law: the distance at the start is -1 m; a driven distance must stay > 0");
}

// ---- members in ground coordinates

TEST(GroundMembers, KeepTheirWrittenPositions) {
  const Scene scene = parse_scene(R"({"assur": 1, "dimension": 2,
      "points": {"B": {"at": [1, 1]}, "C": {"at": [2, 2]}},
      "bodies": {"plate": {"base": ["B", "C"], "points": {"P": {"at": [1, 2]}, "Q": [1, 0]},
                           "vectors": {"e": {"at": [0, 3]}}}},
      "drivers": {"hand": {"pose": "plate", "translation": [{"constant": 0}, {"constant": 0}],
                           "rotation": {"angle": {"polynomial": [0, 1.5707963267948966]}}, "relative": true}},
      "time": {"start": 0, "end": 1, "step": 0.5}})");
  const Body& plate = scene.bodies()[0];
  EXPECT_NEAR(plate.points[0].local[0], std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(plate.points[0].local[1], std::sqrt(0.5), 1e-15);
  EXPECT_FALSE(plate.points[0].in_ground);
  EXPECT_EQ(plate.points[1].local[0], 1);
  const test::Result r = test::run(scene);
  const auto at = [&](std::size_t k, const char* column) { return r.trajectory(k, r.trajectory.index(column)); };
  EXPECT_NEAR(at(0, "P.x"), 1, 1e-14);
  EXPECT_NEAR(at(0, "P.y"), 2, 1e-14);
  EXPECT_NEAR(at(0, "e.y"), 1, 1e-14);
  EXPECT_NEAR(at(2, "P.x"), 0, 1e-14);  // a quarter turn about B
  EXPECT_NEAR(at(2, "P.y"), 1, 1e-14);
  EXPECT_NEAR(at(2, "e.x"), -1, 1e-14);
}

// A frame in space that is not parallel to the axes, and a base of three points.
TEST(GroundMembers, KeepTheirPositionsInSpace) {
  SceneBuilder b("space", 3);
  b.point("O", {1, 2, 3}).vector("u", {0, 1, 0}).vector("v", {0, 0, 1}).vector("w", {1, 0, 0});
  b.point("K", {0, 0, 0}).point("L", {2, 0, 0}).point("M", {1, 1, 0});
  b.add(Body{"frame", "O", {"u", "v", "w"}, {}, {{"P", {1.5, 2, 3}, true}}, {{"d", {0, 1, 1}, true}}});
  b.add(Body{"base", "", {}, {"K", "L", "M"}, {{"N", {0.5, 0.25, 3}, true}}, {}});
  const Scene scene = b.time(0, 1, 1).build();
  for (const Body& body : scene.bodies()) {
    const Triple& local = body.points[0].local;
    const Triple expected = body.name == "frame" ? Triple{0, 0, 0.5} : Triple{0.5, 0.25, 3};
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(local[k], expected[k], 1e-15) << body.name;
  }
}

TEST(GroundMembers, AreRefusedInABodyWithoutAxes) {
  const std::string front = R"({"assur": 1, "dimension": 3, "points": {"O": {"at": [0, 0, 0]}},
      "vectors": {"u": {"at": [1, 0, 0]}, "v": {"at": [0, 1, 0]}, "w": {"at": )";
  const std::string behind = R"(}}, "bodies": {"b": {"origin": "O", "frame": ["u", "v", "w"],
      "points": {"P": {"at": [1, 2, 3]}}}}, "time": {"start": 0, "end": 1, "step": 0.5}})";
  EXPECT_EQ(refusal(front + "[1, 1, 0]" + behind),
            "scene: /bodies/b/points/P: the axes of its body lie in a plane as written, so that ground coordinates do "
            "not define the member; write w = u x v");
}

// ---- degrees

TEST(Degrees, ApplyToAllAnglesAndNoLengths) {
  const std::string laws = R"("points": {"A": {"at": [0, 0], "fixed": true}, "B": {"at": [0, 1]}, "C": {"at": [0, 3]},
                                         "D": {"at": [5, 0]}, "E": {"at": [6, 0]}},
      "bodies": {"plate": {"base": ["D", "E"]}},
      "constraints": {"x": {"coordinate": "C.x", "value": 0}},
      "drivers": {"crank": {"angle": ["A", "B"], "law": [{"polynomial": [90, 180]},
                     {"harmonics": [{"amplitude": 30, "frequency": 1, "phase": 90}], "offset": -30}]},
                  "rod": {"distance": ["A", "C"],
                          "law": {"harmonics": [{"amplitude": 0.5, "frequency": 1, "phase": 90}], "offset": 2.5}},
                  "hand": {"pose": "plate", "translation": [{"constant": 5}, {"constant": 0}],
                           "rotation": {"angle": {"constant": 60}}}},
      "measures": {"a": {"angle": ["A", "B"]}, "rest": {"sum": [["a", -1]], "constant": 90},
                   "d": {"distance": ["A", "C"]}, "far": {"sum": [["d", 2]], "constant": 90}},
      "time": {"start": 0, "end": 1, "step": 0.5}})";
  const Scene scene = parse_scene(R"({"assur": 1, "dimension": 2, "angles": "deg", )" + laws);
  const Law& crank = std::get<PointAngle>(scene.drivers()[0].kind).law;
  EXPECT_NEAR(crank(0).value, 90 * kDegree, 1e-15);  // 90 + 30 sin(90) - 30
  EXPECT_NEAR(crank(0).rate, 180 * kDegree, 1e-14);
  EXPECT_NEAR(crank(0.25).value, 105 * kDegree, 1e-14);
  const Law& rod = std::get<DrivenDistance>(scene.drivers()[1].kind).law;
  EXPECT_NEAR(rod(0).value, 3, 1e-15);
  EXPECT_NEAR(rod(0.5).value, 2, 1e-15);
  const Pose& hand = std::get<Pose>(scene.drivers()[2].kind);
  EXPECT_NEAR(hand.rotation[0](0).value, 60 * kDegree, 1e-15);
  EXPECT_EQ(hand.translation[0](0).value, 5);
  EXPECT_NEAR(std::get<Combination>(scene.measures()[1].kind).constant, 90 * kDegree, 1e-15);
  EXPECT_EQ(std::get<Combination>(scene.measures()[3].kind).constant, 90);
  const test::Result r = test::run(scene);
  EXPECT_NEAR(r.trajectory.last("a"), 270 * kDegree, 1e-13);  // outputs are in rad
  EXPECT_NEAR(r.trajectory.last("rest"), -180 * kDegree, 1e-13);

  const Scene radians = parse_scene(R"({"assur": 1, "dimension": 2, "angles": "rad", )" + laws);
  EXPECT_EQ(std::get<Combination>(radians.measures()[1].kind).constant, 90);
  EXPECT_EQ(refusal(R"({"assur": 1, "dimension": 2, "angles": "grad", )" + laws),
            "scene: /angles: the unit of all angles of the file, \"rad\" or \"deg\", is wanted here");
}

}  // namespace
}  // namespace assur
