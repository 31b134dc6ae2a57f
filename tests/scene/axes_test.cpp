// Axes of angles that are written as coordinates.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "assur/scene.hpp"
#include "assur/simulator.hpp"
#include "refusal.hpp"
#include "scene/same_scene.hpp"
#include "simulation/same_run.hpp"

namespace assur {
namespace {

const Triple kAxis{1, 2, -0.5};  // of any length

// An arm that turns about an axis through the origin, and a second one that turns by as much again.
Scene arms(const Anchor& axis) {
  SceneBuilder b("arms", 3);
  const Number length = std::hypot(1, 2, 0.5);
  b.fixed_point("O", {0, 0, 0}).fixed_vector("u", {1 / length, 2 / length, -0.5 / length}).fixed_vector("e", {0, 0, 1});
  b.point("A", {0.3, 0.1, 0.8}).point("B", {-0.4, 0.5, 0.6});
  b.drive("first", PointAngle{"O", "A", axis, Law::polynomial({0, 1})});
  b.constrain("reach", Distance{"O", "B"}).constrain("height", Dot{"u", {"O", "B"}});
  b.drive("second", RelativeAngle{{"O", "A"}, {"O", "B"}, axis, Law::polynomial({0, 1})}, true);
  b.measure("turn", AngleBetween{"e", {"O", "B"}, axis});
  b.output("A").output("B").output("turn").time(0, 2, 0.1);
  return std::move(b).build();
}

TEST(Axes, CoordinatesMoveAsTheVectorOfThatDirection) {
  const test::Result by_name = test::run(arms("u")), by_numbers = test::run(arms(kAxis));
  ASSERT_TRUE(by_name.report().status.ok());
  EXPECT_EQ(by_name.trajectory.rows(), 21U);
  test::expect_same_rows(by_name.trajectory, by_numbers.trajectory);
}

TEST(Axes, CoordinatesAreWrittenAndReadBack) {
  const Scene scene = arms(kAxis);
  EXPECT_NE(write_scene(scene).find("[1, 2, -0.5]"), std::string::npos);
  EXPECT_EQ(write_scene(scene).find("first.axis"), std::string::npos);
  test::expect_same_rows(test::run(scene).trajectory, test::run(test::written_and_read(scene)).trajectory);
  const Scene other = scene.with_outputs({"A"}).with_time({0, 1, 0.5});
  EXPECT_TRUE(test::run(other).report().status.ok());
}

TEST(Axes, WhatHasNoDirectionIsRefusedWithItsPlace) {
  const std::string none = test::refusal([] { (void)arms(Triple{0, 0, 0}); });
  EXPECT_NE(none.find("/drivers/first/axis"), std::string::npos) << none;
  EXPECT_NE(none.find("/measures/turn/axis"), std::string::npos) << none;
  const std::string infinite = test::refusal([] { (void)arms(Triple{0, HUGE_VAL, 0}); });
  EXPECT_NE(infinite.find("/drivers/second/axis"), std::string::npos) << infinite;
  const std::string plane = test::refusal([] {
    SceneBuilder b("crank", 2);
    b.fixed_point("O", {0, 0}).point("A", {1, 0}).drive("motor", PointAngle{"O", "A", Triple{0, 0, 1}, Law()});
    (void)b.build();
  });
  EXPECT_NE(plane.find("leave \"axis\" out"), std::string::npos) << plane;
}

TEST(Axes, FilesTakeCoordinates) {
  const Scene scene = parse_scene(R"({"assur": 1, "dimension": 3,
    "points": {"O": {"at": [0, 0, 0], "fixed": true}, "A": {"at": [1, 0, 0]}},
    "drivers": {"motor": {"angle": ["O", "A"], "axis": [0, 0, 2], "law": {"polynomial": [0, 1]}}},
    "time": {"start": 0, "end": 1, "step": 0.5}})");
  const Trajectory t = test::run(scene).trajectory;
  EXPECT_NEAR(t.last("A.x"), std::cos(1.0), 1e-14);
  EXPECT_NEAR(t.last("A.y"), std::sin(1.0), 1e-14);
}

}  // namespace
}  // namespace assur
