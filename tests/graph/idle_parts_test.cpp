// Parts that may move on their own are left out with a note if nothing depends on them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "simulation/run.hpp"
#include "structure/grouped_system.hpp"

namespace assur {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
const Triple kZ = {0, 0, 1};

// A four-bar with a driven crank; the outputs are the joint C and the angle of the rocker.
SceneBuilder four_bar(int dimension) {
  const Anchor axis = dimension == 3 ? Anchor(kZ) : Anchor();
  SceneBuilder b("four_bar", dimension);
  for (const char* name : {"crank", "coupler", "rocker"}) b.add(Body{.name = name});
  b.joint("A", Revolute{"ground", "crank", Triple{0, 0, 0}, axis})
      .joint("B", Revolute{"crank", "coupler", Triple{0.5, 0, 0}, axis})
      .joint("C", Revolute{"coupler", "rocker", Triple{1.6, 1.2, 0}, axis})
      .joint("D", Revolute{"ground", "rocker", Triple{2, 0, 0}, axis})
      .drive("motor", DrivenCoordinate{"A.angle", Law::polynomial({0, kTurn})})
      .output("C")
      .output("D.angle")
      .time(0, 1, 1.0 / 64);
  return b;
}

Member marker(std::string name, const Triple& at) { return {std::move(name), at, true}; }

void expect_left_out(int dimension, const SceneBuilder& with, const std::string& body, const std::string& output) {
  const Scene scene = with.build();
  const GroupedSystem s = group_equations(scene);
  EXPECT_TRUE(s.undetermined.empty());
  const auto names = [&](const Diagnostic& note) {
    if (note.where == "/bodies/" + body) return note.what.starts_with("the body may turn about the line through");
    return note.what.starts_with("nothing determines the position of") &&
           note.what.find("'" + body + "'") != std::string::npos;
  };
  EXPECT_EQ(std::count_if(s.notes.begin(), s.notes.end(), names), 1);
  const GroupedSystem without = group_equations(four_bar(dimension).build());
  EXPECT_EQ(s.mobility, without.mobility);
  // in space the coupler carries members beside its plane, with a normal
  if (dimension == 2) {
    EXPECT_EQ(s.groups.size(), without.groups.size());
  }
  const test::Result motion = test::run(scene);
  EXPECT_EQ(motion.report().status.code, Code::ok);
  EXPECT_LE(test::difference(test::run(four_bar(dimension).build()).trajectory, motion.trajectory), 1e-13);
  EXPECT_FALSE(group_equations(SceneBuilder(with).output(output).build()).undetermined.empty());
  EXPECT_THROW((void)prepare(SceneBuilder(with).output(output).build()), Error);
}

TEST(IdleParts, WheelOnAPassiveAxle) {
  for (const int dimension : {2, 3}) {
    const Anchor axis = dimension == 3 ? Anchor(kZ) : Anchor();
    SceneBuilder b = four_bar(dimension);
    b.add(Body{.name = "wheel", .points = {marker("rim", {1, 1, 0})}})
        .joint("W", Revolute{"coupler", "wheel", Triple{1, 0.7, 0}, axis});
    expect_left_out(dimension, b, "wheel", "rim");
    expect_left_out(dimension, b, "wheel", "W.angle");
  }
}

TEST(IdleParts, BlockThatSlides) {
  for (const int dimension : {2, 3}) {
    SceneBuilder b = four_bar(dimension);
    b.add(Body{.name = "block", .points = {marker("mark", {1.2, 0.9, 0})}})
        .joint("S", Prismatic{"coupler", "block", Triple{1, 1, 0}});
    expect_left_out(dimension, b, "block", "S.displacement");
  }
}

TEST(IdleParts, BodiesThatHangOnJointsInSpace) {
  SceneBuilder sleeve = four_bar(3);
  sleeve.add(Body{.name = "sleeve", .points = {marker("mark", {1, 0.7, 0.3})}})
      .joint("S", Cylindrical{"rocker", "sleeve", Triple{1.8, 0.6, 0}, Triple{1, 0, 2}});
  expect_left_out(3, sleeve, "sleeve", "mark");
  expect_left_out(3, sleeve, "sleeve", "S.displacement");
  SceneBuilder pendulum = four_bar(3);
  pendulum.add(Body{.name = "pendulum", .points = {marker("bob", {1, 0.7, -0.5}), marker("mark", {1.1, 0.7, -0.5})}})
      .joint("S", Spherical{"coupler", "pendulum", Triple{1, 0.7, 0}});
  expect_left_out(3, pendulum, "pendulum", "bob");
  SceneBuilder plate = four_bar(3);
  plate.add(Body{.name = "plate", .points = {marker("mark", {1.1, 0.7, 0.2})}})
      .joint("E", Planar{"coupler", "plate", kZ});
  expect_left_out(3, plate, "plate", "mark");
  SceneBuilder cross = four_bar(3);
  cross.add(Body{.name = "shaft", .points = {marker("end", {1, 0.7, 1})}})
      .joint("U", Universal{"coupler", "shaft", Triple{1, 0.7, 0}, Triple{1, 0, 0}, Triple{0, 1, 0}});
  expect_left_out(3, cross, "shaft", "end");
  // a rod with two ball joints and a point beside its line
  SceneBuilder rod = four_bar(3);
  rod.add(Body{.name = "rod", .points = {marker("side", {1, 1, 0.5})}})
      .add(Body{.name = "lever"})
      .joint("P", Spherical{"coupler", "rod", Triple{1, 0.7, 0.2}})
      .joint("Q", Spherical{"rod", "lever", Triple{1.5, 1.5, 1}})
      .joint("R", Revolute{"ground", "lever", Triple{2.5, 1.5, 1}, Triple{0, 1, 0.2}});
  const Scene scene = rod.output("Q").time(0, 1.0 / 16, 1.0 / 64).build();
  const GroupedSystem s = group_equations(scene);
  EXPECT_TRUE(s.undetermined.empty());
  EXPECT_EQ(test::run(scene).report().status.code, Code::ok);
  const auto is_note = [](const Diagnostic& note) {
    return note.where == "/bodies/rod" &&
           note.what ==
               "the body may turn about the line through 'P' and 'Q'; no output and no driver depends on "
               "this turn, so its points beside the line, 'side', are not computed";
  };
  EXPECT_EQ(std::count_if(s.notes.begin(), s.notes.end(), is_note), 1);
  try {
    (void)prepare(SceneBuilder(rod).output("side").build());
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()),
              "/bodies/rod: undetermined: the body may turn about the line through 'P' and 'Q', and an output or a "
              "driver depends on this turn; ask only for points on the line, or hold the body");
  }
}

// A point beside the axis of a driven strut turns with the strut, which nothing else does. An output is held by the
// struts, of which each has such a point on its lower or upper part, or on both.
TEST(IdleParts, StrutsWithMarksBesideTheirAxes) {
  const auto tripod = [](bool lower, bool upper) {
    SceneBuilder b("tripod", 3);
    b.add(Body{.name = "plate"});
    const double turn[] = {0, kTurn / 3, 2 * kTurn / 3};
    for (int i = 0; i < 3; ++i) {
      const std::string n = std::to_string(i);
      const double c = std::cos(turn[i]), s = std::sin(turn[i]);
      const Triple foot = {c, s, 0.1 * i}, head = {0.5 * c - 0.2 * s, 0.5 * s + 0.2 * c, 1.1};
      const Triple axis = {head[0] - foot[0], head[1] - foot[1], head[2] - foot[2]};
      Body l{.name = "l" + n}, u{.name = "u" + n};
      if (lower) l.points = {marker("low" + n, {1.3 * c, 1.2 * s, 0.3})};
      if (upper) u.points = {marker("high" + n, {0.9 * c, 0.7 * s, 0.8})};
      b.add(l).add(u);
      b.joint("A" + n, Spherical{"ground", "l" + n, foot})
          .joint("P" + n, Prismatic{"l" + n, "u" + n, axis})
          .joint("C" + n, Spherical{"u" + n, "plate", head})
          .drive("m" + n, DrivenCoordinate{"P" + n + ".displacement", Law::harmonics({{0.02, 1.0, 0.7 * i}})});
    }
    // the plate turns about a point of the ground
    b.joint("O", Spherical{"ground", "plate", Triple{0.1, 0, 0.9}}).output("plate").time(0, 1, 1.0 / 32);
    return b;
  };
  const Trajectory without = test::run(tripod(false, false).build()).trajectory;
  for (const auto& [lower, upper] : {std::pair(true, false), std::pair(false, true), std::pair(true, true)}) {
    SCOPED_TRACE(testing::Message() << lower << upper);
    const SceneBuilder marked = tripod(lower, upper);
    const Scene scene = marked.build();
    const GroupedSystem s = group_equations(scene);
    EXPECT_TRUE(s.undetermined.empty());
    const auto is_spin = [](const Diagnostic& note) {
      return note.what.starts_with("the body may turn about the line through ") &&
             note.what.find(" are not computed") != std::string::npos;
    };
    EXPECT_EQ(std::count_if(s.notes.begin(), s.notes.end(), is_spin), lower && upper ? 6 : 3);
    const test::Result motion = test::run(scene);
    EXPECT_EQ(motion.report().status.code, Code::ok);
    EXPECT_LE(test::difference(without, motion.trajectory), 1e-12);
    EXPECT_THROW((void)prepare(SceneBuilder(marked).output(lower ? "low0" : "high0").build()), Error);
  }
}

// A chain of two bodies without a driver.
TEST(IdleParts, ChainOfBodies) {
  SceneBuilder b = four_bar(2);
  b.add(Body{.name = "upper"})
      .add(Body{.name = "lower", .points = {marker("end", {1, -1, 0})}})
      .joint("U", Revolute{"coupler", "upper", Triple{1, 0.7, 0}})
      .joint("L", Revolute{"upper", "lower", Triple{1, -0.2, 0}});
  expect_left_out(2, b, "upper", "L");
  expect_left_out(2, b, "lower", "end");
}

// A driver of an idle part is not left out silently.
TEST(IdleParts, APartWithADriverIsRefused) {
  SceneBuilder b = four_bar(2);
  b.fixed_point("G", {0, 3})
      .add(Body{.name = "upper"})
      .add(Body{.name = "lower", .points = {marker("end", {1, -1, 0})}})
      .joint("U", Revolute{"coupler", "upper", Triple{1, 0.7, 0}})
      .joint("L", Revolute{"upper", "lower", Triple{1, -0.2, 0}})
      .drive("rope", DrivenDistance{"G", "end", Law::constant(4.1)});
  EXPECT_THROW((void)prepare(b.build()), Error);
}

// Without outputs everything is computed.
TEST(IdleParts, AllOutputsNeedTheWheel) {
  SceneBuilder b = four_bar(2);
  b.add(Body{.name = "wheel", .points = {marker("rim", {1, 1, 0})}})
      .joint("W", Revolute{"coupler", "wheel", Triple{1, 0.7, 0}});
  EXPECT_THROW((void)prepare(b.build().with_outputs({"all"})), Error);
}

}  // namespace
}  // namespace assur
