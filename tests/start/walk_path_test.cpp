// The start posture is the end of a way that begins at the drawing: the drawing is closed with the drivers held, then
// all drivers move together to the values of their laws.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "equations/lowering.hpp"
#include "equations/system.hpp"
#include "index.hpp"
#include "start/walk_path.hpp"
#include "structure/look.hpp"

namespace assur {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr Formulation groups = Formulation::groups, irreducible = Formulation::irreducible;

GroupedSystem start_of(const std::string& text) { return look::structure(parse_scene(text), irreducible); }

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

void expect_at(const GroupedSystem& s, const std::string& point, double x, double y, double within) {
  ASSERT_EQ(s.cannot_assemble, "");
  EXPECT_NEAR(look::start(s, point + ".x"), x, within) << point;
  EXPECT_NEAR(look::start(s, point + ".y"), y, within) << point;
}

// The crank P of a slotted lever turns by more than a right angle before the lever does. The right values are the ends
// of the same ways as motions.
TEST(WalkPath, EndsWhereTheSameMotionEnds) {
  const auto slotted_lever = [](const std::string& law) {
    return start_of(R"({"assur": 1, "dimension": 2, "bodies": {"lever": {}, "block": {}, "crank": {}},
      "joints": {"O": {"revolute": ["ground", "lever"], "at": [0, 0]},
                 "S": {"prismatic": ["lever", "block"], "axis": [0.5, 0.8660254037844386]},
                 "Q": {"revolute": ["block", "crank"], "at": [0.5, 0.8660254037844386]},
                 "P": {"revolute": ["ground", "crank"], "at": [0.4, 0.1]}},
      "drivers": {"turn": {"coordinate": "O.angle", "law": )" +
                    law + R"(}}, "outputs": ["Q", "O.angle"], "time": {"start": 0, "end": 1, "step": 0.01}})");
  };
  for (const char* law : {R"({"constant": -1.2})", R"({"polynomial": [-1.2, 1.2]})"}) {
    expect_at(slotted_lever(law), "Q", 1.122716825, -0.172901649, 1e-9);
  }
  const GroupedSystem bar = start_of(R"({"assur": 1, "dimension": 2,
    "bodies": {"b0": {}, "b1": {}, "b2": {}},
    "joints": {"J0": {"revolute": ["ground", "b0"], "at": [-0.61, -0.28]},
               "J1": {"revolute": ["b0", "b1"], "at": [-0.44, 0.08]},
               "J2": {"revolute": ["b1", "b2"], "at": [-0.59, -0.5]},
               "J3": {"revolute": ["ground", "b2"], "at": [-0.41, 0.83]}},
    "drivers": {"m": {"coordinate": "J3.angle", "law": {"polynomial": [-0.73, 0.1]}}},
    "outputs": ["J1", "J2"], "time": {"start": 0, "end": 1, "step": 0.5}})");
  expect_at(bar, "J1", -0.977693938, -0.432647200, 1e-9);
  expect_at(bar, "J2", -1.431068007, -0.041045421, 1e-9);
}

// Q of a rod about P would fall onto the pivot O if the rod were assembled directly.
TEST(WalkPath, DirectionsDoNotVanish) {
  const GroupedSystem s = start_of(R"({"assur": 1, "dimension": 2,
    "points": {"O": {"at": [0, 0], "fixed": true}, "P": {"at": [1, 0], "fixed": true},
               "Q": {"at": [0.5, 0.8660254037844386]}},
    "vectors": {"x": {"at": [1, 0], "fixed": true}},
    "constraints": {"rod": {"distance": ["P", "Q"], "value": 1}},
    "drivers": {"turn": {"angle": ["x", ["O", "Q"]], "law": {"constant": 0.5}}}, "outputs": ["Q"]})");
  expect_at(s, "Q", 2 * std::cos(0.5) * std::cos(0.5), 2 * std::cos(0.5) * std::sin(0.5), 1e-13);
}

// Points of later groups are written for another angle of the crank; lengths are given, and the drawing is open.
std::string four_bar(const std::string& law, const std::string& more = "") {
  return R"({"assur": 1, "dimension": 2,
    "points": {"A": {"at": [0, 0], "fixed": true}, "D": {"at": [1.5, 0], "fixed": true},
               "B": {"at": [0.816, 1.604]}, "C": {"at": [1.816, 1.569]}},
    "constraints": {"l": {"distance": ["B", "C"], "value": 1.0}, "r": {"distance": ["D", "C"], "value": 1.6},
                    "k": {"distance": ["A", "B"], "value": 1.8}},
    "drivers": {"m": {"angle": ["A", "B"], "law": )" +
         law + "}}, \"outputs\": [\"C\"]" + more + "}";
}

TEST(WalkPath, LaterGroupsFollowTheirInputs) {
  const GroupedSystem s = start_of(four_bar(R"({"polynomial": [0.4, 1]})"));
  expect_at(s, "B", 1.8 * std::cos(0.4), 1.8 * std::sin(0.4), 1e-14);
  expect_at(s, "C", 2.488, 1.258, 1e-3);
  // Angles between points turn the shorter way.
  const GroupedSystem turned = start_of(four_bar(R"({"polynomial": [6.683185307179586, 1]})"));
  EXPECT_NEAR(look::start(turned, "C.y"), look::start(s, "C.y"), 1e-12);
}

// A rocker swings over half a turn, but not over the direction of its ground.
TEST(WalkPath, AFoldIsRefusedWithItsPlaceAndAnotherPosture) {
  const auto rocker = [](double angle) {
    return start_of(R"({"assur": 1, "dimension": 2,
      "points": {"A": {"at": [0, 0], "fixed": true}, "D": {"at": [2, 0], "fixed": true},
                 "B": {"at": [-0.8011436155469337, 0.5984721441039565]}, "C": {"at": [1.05, 0.31]}},
      "constraints": {"coupler": {"distance": ["B", "C"], "value": 1.96}, "rocker": {"distance": ["D", "C"], "value": 1}},
      "drivers": {"m": {"angle": ["A", "B"], "law": {"constant": )" +
                    std::to_string(angle) + "}}}, \"outputs\": [\"C\"]}");
  };
  EXPECT_EQ(rocker(-0.5).cannot_assemble, "");
  const GroupedSystem refused = rocker(-2.5);
  const std::string& why = refused.cannot_assemble;
  // The fold is where the coupler and the rocker lie in one line, 2.96 m long.
  const double fold = std::acos((5 - 2.96 * 2.96) / 4), share = 100 * (fold - 2.5) / (2 * kPi - 5);
  EXPECT_TRUE(has(why, "the start posture cannot be reached: at ")) << why;
  EXPECT_NEAR(std::stod(why.substr(why.find(": at ") + 5)), share, 0.1) << why;
  EXPECT_NEAR(std::stod(why.substr(why.find("m = ") + 4)), fold, 1e-5) << why;
  EXPECT_TRUE(has(why, "group C ")) << why;
  EXPECT_TRUE(has(why, "another posture has the values of the laws; to start there, write C at (")) << why;
}

// The way passes the flat posture, where the rods could also cross.
TEST(WalkPath, AChangePointIsPassedByTheSmoothContinuation) {
  const GroupedSystem s = start_of(R"({"assur": 1, "dimension": 2,
    "points": {"A": {"at": [0, 0], "fixed": true}, "D": {"at": [2, 0], "fixed": true},
               "B": {"at": [0.8775825618903728, 0.479425538604203]}, "C": {"at": [2.8775825618903728, 0.479425538604203]}},
    "constraints": {"coupler": {"distance": ["B", "C"], "value": 2}, "rocker": {"distance": ["D", "C"], "value": 1}},
    "drivers": {"m": {"angle": ["A", "B"], "law": {"constant": -0.4}}}, "outputs": ["C"]})");
  expect_at(s, "C", 2 + std::cos(0.4), -std::sin(0.4), 1e-10);
  EXPECT_TRUE(has(look::notes(s), "group C passes a change point at 55.6 % of the way")) << look::notes(s);
}

// A crank without a length has no angle as written.
TEST(WalkPath, ADriverWithoutAValueTakesThatOfItsLaw) {
  const GroupedSystem s = start_of(R"({"assur": 1, "dimension": 2,
    "points": {"A": {"at": [0, 0], "fixed": true}, "B": {"at": [0, 0]}},
    "constraints": {"k": {"distance": ["A", "B"], "value": 1.5}},
    "drivers": {"m": {"angle": ["A", "B"], "law": {"constant": 0.7}}}, "outputs": ["B"]})");
  expect_at(s, "B", 1.5 * std::cos(0.7), 1.5 * std::sin(0.7), 1e-14);
  EXPECT_TRUE(has(look::notes(s), "no value in the posture as written")) << look::notes(s);
}

// A planar loop of hinges in space has three equations too many. It is drawn closed and starts elsewhere.
TEST(WalkPath, RedundantLoopsFollowAsInThePlane) {
  const Triple a = {0, 0, 0}, b = {0.3, 0.4, 0}, c = {1.4, 1.1, 0}, d = {1.6, 0, 0};
  const auto loop = [&](int dimension) {
    SceneBuilder s("loop", dimension);
    for (const char* name : {"crank", "coupler", "rocker"}) s.add(Body{.name = name});
    const auto hinge = [&](const char* name, const char* one, const char* two, const Triple& at) {
      s.joint(name, dimension == 2 ? Revolute{one, two, at} : Revolute{one, two, at, Triple{0, 0, 1}});
    };
    hinge("A", "ground", "crank", a), hinge("B", "crank", "coupler", b), hinge("C", "coupler", "rocker", c);
    hinge("D", "rocker", "ground", d);
    s.drive("m", DrivenCoordinate{"A.angle", Law::polynomial({5 * kPi + 0.3, 1})});
    return s.output("C").time(0, 1, 0.01).build();
  };
  const GroupedSystem flat = look::structure(loop(2), groups), in_space = look::structure(loop(3), groups);
  ASSERT_EQ(flat.cannot_assemble, "");
  expect_at(in_space, "C", look::start(flat, "C.x"), look::start(flat, "C.y"), 1e-12);
  // The same as half a turn and 0.3 rad: a crank that turns fully counts its turns without an effect.
  EXPECT_NEAR(std::hypot(look::start(flat, "B.x"), look::start(flat, "B.y")), 0.5, 1e-14);
  EXPECT_NEAR(look::start(flat, "B.x"), 0.5 * std::cos(std::atan2(0.4, 0.3) + kPi + 0.3), 1e-13);
}

// Bennett's linkage, drawn far off: on the way its redundant equations contradict each other, and hold as well as they
// can. Newton's method needs the curvature of what they leave, else it takes steps of 1e-6 of the way.
TEST(WalkPath, RedundantEquationsThatContradictEachOtherCloseInFewSteps) {
  const System s = lower(std::make_shared<const Scene>(parse_scene(R"({"assur": 1, "dimension": 3,
    "points": {"A": {"at": [0, 0, 0], "fixed": true}, "B": {"at": [1, 0, 0], "fixed": true},
               "C": {"at": [0.502, -0.179, -0.425]}, "D": {"at": [0.164, 0.718, -0.005]}},
    "vectors": {"z0": {"at": [0, 0, 1], "fixed": true}, "x0": {"at": [1, 0, 0], "fixed": true},
                "z1": {"at": [0, -0.91834320782906991, 0.39578498283059427], "fixed": true},
                "z2": {"at": [0.447, -0.558, 0.7]}, "z3": {"at": [0.175, -0.499, 0.849]}},
    "constraints": {
      "BC": {"distance": ["B", "C"], "value": 0.6750439579678705}, "BC1": {"dot": [["B", "C"], "z1"], "value": 0},
      "BC2": {"dot": [["B", "C"], "z2"], "value": 0}, "z12": {"dot": ["z1", "z2"], "value": 0.7846634132077399},
      "CD": {"distance": ["C", "D"], "value": 1}, "CD2": {"dot": [["C", "D"], "z2"], "value": 0},
      "CD3": {"dot": [["C", "D"], "z3"], "value": 0}, "z23": {"dot": ["z2", "z3"], "value": 0.3957849828305943},
      "AD": {"distance": ["A", "D"], "value": 0.6750439579678703}, "AD0": {"dot": [["A", "D"], "z0"], "value": 0},
      "AD3": {"dot": [["A", "D"], "z3"], "value": 0}, "z03": {"dot": ["z0", "z3"], "value": 0.7846634132077398}},
    "drivers": {"m": {"angle": ["x0", ["A", "D"]], "axis": "z0", "law": {"constant": 1.339}}},
    "time": {"start": 0, "end": 1, "step": 0.1}})")));
  std::vector<double> q = s.guess;
  WalkedPart all;
  WalkPath way;  // the driver is held at its law
  way.from = {{1.339}};
  way.change = {{0}};
  for (std::size_t e = 0; e < s.equations.size(); ++e) {
    all.equations.push_back(static_cast<Index>(e));
    way.open.push_back(residual<double>(s, static_cast<Index>(e), q));
  }
  for (std::size_t c = 0; c < s.coordinates.size(); ++c) {
    if (s.coordinates[c].role == Role::unknown) all.unknowns.push_back(static_cast<Index>(c));
  }
  const Walked closed = walk(s, {all}, way, q);
  EXPECT_EQ(closed.end, Walked::End::arrived) << closed.share;
  EXPECT_LE(closed.steps, 200);
  for (const Index e : all.equations) EXPECT_NEAR(residual<double>(s, e, q), 0, 1e-12);
}

// Parts that no output needs do not hold the others back.
TEST(WalkPath, PartsWithoutOutputsAreLeftBehind) {
  const auto guided = [](const std::string& outputs) {
    return start_of(R"({"assur": 1, "dimension": 2,
      "points": {"A": {"at": [0, 0], "fixed": true}, "E": {"at": [1.5, 0], "fixed": true}, "B": {"at": [1, 0]},
                 "F": {"at": [1.3, 0.3]}},
      "constraints": {"one": {"distance": ["B", "F"]}, "two": {"distance": ["E", "F"]}},
      "drivers": {"m": {"angle": ["A", "B"], "law": {"constant": 2}}}, "outputs": )" +
                    outputs + "}");
  };
  const GroupedSystem all = guided(R"(["B", "F"])"), some = guided(R"(["B"])");
  EXPECT_TRUE(has(all.cannot_assemble, "group F meets a fold")) << all.cannot_assemble;
  expect_at(some, "B", std::cos(2), std::sin(2), 1e-15);
  EXPECT_TRUE(has(look::notes(some), "group F cannot follow the drivers")) << look::notes(some);
}

}  // namespace
}  // namespace assur
