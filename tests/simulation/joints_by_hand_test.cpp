// The same mechanism written with joints, and by hand with points, vectors and constraints, has the same motion.
#include <gtest/gtest.h>

#include <map>
#include <numbers>
#include <string>
#include <utility>

#include "assur/structure.hpp"
#include "index.hpp"
#include "run.hpp"
#include "scene/triple.hpp"
#include "simulation/by_hand.hpp"

namespace assur {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

void expect_same(const Scene& joints, const Scene& by_hand) {
  const test::Result a = test::run(joints), b = test::run(by_hand);
  ASSERT_EQ(a.report().status.code, Code::ok);
  ASSERT_EQ(b.report().status.code, Code::ok);
  ASSERT_EQ(a.trajectory.rows(), b.trajectory.rows());
  ASSERT_GT(a.trajectory.rows(), 100u);
  // One of them may have further columns: the terms of a sum.
  const bool a_has_more = a.trajectory.columns().size() > b.trajectory.columns().size();
  EXPECT_LE(a_has_more ? test::difference(b.trajectory, a.trajectory) : test::difference(a.trajectory, b.trajectory),
            1e-13);
}

// Unknowns that a step solves.
Index solved(const Scene& scene) {
  const Structure s = analyze(scene, {Formulation::irreducible, 2, {}, {}});
  Index sum = 0;
  for (const Group& g : s.groups) sum += static_cast<Index>(g.unknowns.size());
  return sum;
}

// The counts of docs/joints.md: with joints, and by hand with the fewest unknowns.
const std::map<std::string, std::pair<Index, Index>> kSolved = {{"four_bar", {2, 2}},     {"slider_crank", {3, 3}},
                                                                {"watt", {4, 4}},         {"stephenson", {4, 4}},
                                                                {"quick_return", {5, 5}}, {"excavator", {8, 8}},
                                                                {"chain", {40, 40}},      {"rssr", {3, 3}},
                                                                {"rscr", {10, 10}},       {"rssp", {4, 4}},
                                                                {"hexapod", {9, 9}},      {"hexapod_inverse", {6, 0}},
                                                                {"delta", {9, 3}},        {"delta_translating", {3, 3}},
                                                                {"wishbone", {12, 12}},   {"spherical", {3, 3}}};

TEST(JointsByHand, SameMotionAndUnknownsInThePlane) {
  for (const test::WrittenTwice& m : test::plane_mechanisms_by_hand()) {
    SCOPED_TRACE(m.name);
    expect_same(m.joints, m.by_hand);
    EXPECT_EQ(std::pair(solved(m.joints), solved(m.by_hand)), kSolved.at(m.name));
  }
}

TEST(JointsByHand, SameMotionAndUnknownsInSpace) {
  for (const test::WrittenTwice& m : test::space_mechanisms_by_hand()) {
    SCOPED_TRACE(m.name);
    expect_same(m.joints, m.by_hand);
    EXPECT_EQ(std::pair(solved(m.joints), solved(m.by_hand)), kSolved.at(m.name));
  }
}

// A leg of a Stewart platform on a crank: universal, prismatic and spherical joint, and the distance of its ends.
TEST(JointsByHand, LegOfAStewartPlatform) {
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
                           .output("S")
                           .output("length")
                           .time(0, 1, 1.0 / 128)
                           .build();
  const Scene by_hand = SceneBuilder("by_hand", 3)
                            .fixed_point("A", {0, 0, 0})
                            .fixed_point("U", foot)
                            .fixed_vector("z", {0, 0, 1})
                            .point("S", hand)
                            .drive("motor", PointAngle{"A", "S", "z", Law::polynomial({0, kTurn})})
                            .measure("length", MeasuredDistance{"U", "S"})
                            .output("S")
                            .output("length")
                            .time(0, 1, 1.0 / 128)
                            .build();
  expect_same(joints, by_hand);
}

}  // namespace
}  // namespace assur
