// The same mechanism written with joints, and by hand with points, vectors and constraints, has the same motion.
#include <gtest/gtest.h>

#include <numbers>
#include <string>
#include <vector>

#include "run.hpp"
#include "scene/triple.hpp"

namespace assur {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

void expect_same(const Scene& joints, const Scene& by_hand, const std::vector<std::string>& columns) {
  const test::Result a = test::run(joints), b = test::run(by_hand);
  ASSERT_EQ(a.report().status.code, Code::ok);
  ASSERT_EQ(b.report().status.code, Code::ok);
  ASSERT_EQ(a.trajectory.rows(), b.trajectory.rows());
  ASSERT_GT(a.trajectory.rows(), 100u);
  for (const std::string& column : columns) {
    const std::size_t i = a.trajectory.index(column), k = b.trajectory.index(column);
    double largest = 1;
    for (std::size_t row = 0; row < b.trajectory.rows(); ++row) {
      largest = std::max(largest, std::abs(b.trajectory(row, k)));
    }
    for (std::size_t row = 0; row < a.trajectory.rows(); ++row) {
      EXPECT_NEAR(a.trajectory(row, i), b.trajectory(row, k), 1e-13 * largest) << column << " row " << row;
    }
  }
}

std::vector<std::string> columns_of(const std::vector<std::string>& points, bool in_space) {
  std::vector<std::string> all;
  for (const std::string& p : points) {
    for (const std::string part : {".", ".v", ".a"}) {
      for (const char* axis : {"x", "y", "z"}) {
        if (in_space || *axis != 'z') all.push_back(p + part + axis);
      }
    }
  }
  return all;
}

TEST(JointsByHand, SliderCrankMovesAlike) {
  const Scene joints = SceneBuilder("joints", 2)
                           .add(Body{.name = "crank"})
                           .add(Body{.name = "rod", .points = {{"M", {0.25, 0.02, 0}, true}}})
                           .add(Body{.name = "piston"})
                           .joint("O", Revolute{"crank", "ground", Triple{0, 0, 0}})
                           .joint("B", Revolute{"crank", "rod", Triple{0.1, 0, 0}})
                           .joint("C", Revolute{"rod", "piston", Triple{0.4, 0.03, 0}})
                           .joint("S", Prismatic{"piston", "ground", Triple{1, 0, 0}})
                           .drive("motor", DrivenCoordinate{"O.angle", Law::polynomial({0, -kTurn})})
                           .time(0, 1, 1.0 / 128)
                           .build();
  const Scene by_hand = SceneBuilder("by_hand", 2)
                            .fixed_point("O", {0, 0})
                            .fixed_point("A", {0, 0.03})
                            .point("B", {0.1, 0})
                            .point("C", {0.4, 0.03})
                            .fixed_vector("rail", {1, 0})
                            .add(Body{.name = "rod", .base = {"B", "C"}, .points = {{"M", {0.25, 0.02, 0}, true}}})
                            .constrain("slide", OnLine{"C", "A", "rail"})
                            .drive("motor", PointAngle{"O", "B", "", Law::polynomial({0, kTurn})})
                            .time(0, 1, 1.0 / 128)
                            .build();
  expect_same(joints, by_hand, columns_of({"B", "C", "M"}, false));
}

// Crank and rocker about skew axes, with a rod with two spherical joints.
TEST(JointsByHand, SkewCrankAndRockerMoveAlike) {
  const Triple A = {0, 0, 0}, B = {0.2, 0, 0}, C = {0.9, 1.1, 0.5}, D = {1, 0.4, -0.1};
  const Triple z = {0, 0, 1}, hinge = triple::cross(triple::subtract(C, D), {0.2, 1, 0});
  const Scene joints = SceneBuilder("joints", 3)
                           .add(Body{.name = "crank"})
                           .add(Body{.name = "rod"})
                           .add(Body{.name = "rocker"})
                           .joint("A", Revolute{"ground", "crank", A, z})
                           .joint("B", Spherical{"rod", "crank", B})
                           .joint("C", Spherical{"rod", "rocker", C})
                           .joint("D", Revolute{"rocker", "ground", D, hinge})
                           .drive("motor", DrivenCoordinate{"A.angle", Law::polynomial({0, kTurn})})
                           .time(0, 1, 1.0 / 128)
                           .build();
  const Scene by_hand = SceneBuilder("by_hand", 3)
                            .fixed_point("A", A)
                            .fixed_point("D", D)
                            .fixed_vector("z", z)
                            .fixed_vector("hinge", triple::scale(1 / triple::norm(hinge), hinge))
                            .point("B", B)
                            .point("C", C)
                            .constrain("rod", Distance{"B", "C"})
                            .constrain("rocker", Distance{"D", "C"})
                            .constrain("swing", Dot{Direction("D", "C"), "hinge", 0.0})
                            .drive("motor", PointAngle{"A", "B", "z", Law::polynomial({0, kTurn})})
                            .time(0, 1, 1.0 / 128)
                            .build();
  expect_same(joints, by_hand, columns_of({"B", "C"}, true));
}

// A leg of a Stewart platform on a crank: universal, prismatic and spherical joint, and the distance of its ends.
TEST(JointsByHand, LegOfAStewartPlatformMovesAlike) {
  const Triple foot = {0.9, -0.4, -1}, hand = {0.5, 0.2, 0.3}, way = triple::subtract(hand, foot);
  const Triple side = triple::cross(way, {0, 0, 1});
  const double length = triple::norm(way);
  const Scene joints = SceneBuilder("joints", 3)
                           .add(Body{.name = "crank"})
                           .add(Body{.name = "cylinder"})
                           .add(Body{.name = "piston"})
                           .joint("A", Revolute{"ground", "crank", Triple{0, 0, 0}, Triple{0, 0, 1}})
                           .joint("U", Universal{"ground", "cylinder", foot, side, triple::cross(way, side)})
                           .joint("L", Prismatic{"cylinder", "piston", way})
                           .joint("S", Spherical{"piston", "crank", hand})
                           .drive("motor", DrivenCoordinate{"A.angle", Law::polynomial({0, kTurn})})
                           .measure("way", MeasuredCoordinate{"L.displacement"})
                           .measure("length", Combination{{{"way", 1}}, length})
                           .time(0, 1, 1.0 / 128)
                           .build();
  const Scene by_hand = SceneBuilder("by_hand", 3)
                            .fixed_point("A", {0, 0, 0})
                            .fixed_point("U", foot)
                            .fixed_vector("z", {0, 0, 1})
                            .point("S", hand)
                            .drive("motor", PointAngle{"A", "S", "z", Law::polynomial({0, kTurn})})
                            .measure("length", MeasuredDistance{"U", "S"})
                            .time(0, 1, 1.0 / 128)
                            .build();
  std::vector<std::string> columns = columns_of({"S"}, true);
  columns.insert(columns.end(), {"length", "length.rate", "length.acceleration"});
  expect_same(joints, by_hand, columns);
}

}  // namespace
}  // namespace assur
