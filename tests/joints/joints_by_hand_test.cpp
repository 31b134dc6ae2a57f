// The same mechanism written with joints, and by hand with points, vectors and constraints, has the same motion.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <map>
#include <numbers>
#include <string>
#include <utility>

#include "index.hpp"
#include "joints/by_hand.hpp"
#include "scene/triple.hpp"
#include "simulation/run.hpp"
#include "structure/grouped_system.hpp"

namespace assur {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

// Returns how many balls of uniqueness each of both measures.
std::pair<std::int64_t, std::int64_t> run_same(const Scene& joints, const Scene& by_hand) {
  const test::Result a = test::run(joints), b = test::run(by_hand);
  EXPECT_EQ(a.report().status.code, Code::ok);
  EXPECT_EQ(b.report().status.code, Code::ok);
  EXPECT_EQ(a.trajectory.rows(), b.trajectory.rows());
  EXPECT_GT(a.trajectory.rows(), 100u);
  if (a.trajectory.rows() != b.trajectory.rows()) return {};
  // One of them may have further columns: the terms of a sum.
  const bool a_has_more = a.trajectory.columns().size() > b.trajectory.columns().size();
  EXPECT_LE(a_has_more ? test::difference(b.trajectory, a.trajectory) : test::difference(a.trajectory, b.trajectory),
            1e-13);
  return {a.counters().branch_checks, b.counters().branch_checks};
}

// Unknowns that a step solves.
Index solved(const Scene& scene) {
  const GroupedSystem s = group_equations(scene, {Formulation::irreducible, 2, {}});
  Index sum = 0;
  for (const SolvedGroup& g : s.groups) sum += static_cast<Index>(g.unknowns.size());
  return sum;
}

// The counts of docs/joints.md: with joints, and by hand with the fewest unknowns.
const std::map<std::string, std::pair<Index, Index>> kSolved = {{"four_bar", {2, 2}},
                                                                {"slider_crank", {3, 3}},
                                                                {"slider_crank_end", {3, 1}},
                                                                {"watt", {4, 4}},
                                                                {"stephenson", {4, 4}},
                                                                {"quick_return", {5, 5}},
                                                                {"excavator", {8, 8}},
                                                                {"chain", {40, 40}},
                                                                {"rssr", {3, 3}},
                                                                {"rscr", {10, 10}},
                                                                {"rssp", {4, 4}},
                                                                {"hexapod", {9, 9}},
                                                                {"hexapod_inverse", {6, 0}},
                                                                {"delta", {9, 3}},
                                                                {"delta_translating", {3, 3}},
                                                                {"wishbone", {12, 12}},
                                                                {"spherical", {3, 3}}};

// If both writings solve equally many unknowns, the chosen bases are about as well conditioned as those by hand, and a
// ball lasts about as many steps. (The spherical linkage by hand knows that all axes meet in one point.)
void compare(const test::WrittenTwice& m) {
  SCOPED_TRACE(m.name);
  const auto [with_joints, by_hand] = run_same(m.joints, m.by_hand);
  const std::pair unknowns(solved(m.joints), solved(m.by_hand));
  EXPECT_EQ(unknowns, kSolved.at(m.name));
  EXPECT_TRUE(unknowns.first != unknowns.second || with_joints <= 2 * by_hand) << with_joints << " and " << by_hand;
}

TEST(JointsByHand, SameMotionAndUnknownsInThePlane) {
  for (const test::WrittenTwice& m : test::plane_mechanisms_by_hand()) compare(m);
}

TEST(JointsByHand, SameMotionAndUnknownsInSpace) {
  for (const test::WrittenTwice& m : test::space_mechanisms_by_hand()) compare(m);
}

// Distances of the hinges from the centre change the base of the coupler and the redundant equations, not the motion.
TEST(JointsByHand, SphericalLinkagesOfAnySize) {
  for (const std::array<double, 4>& away :
       {std::array{0.5, 1.0, 1.0, 1.0}, {0.5, 1.3, 0.7, 1.6}, {1.0, 0.8, 1.5, 0.6}, {2.0, 0.6, 0.6, 1.2}}) {
    SCOPED_TRACE(away[1]);
    const test::WrittenTwice m = test::spherical_four_bar(away);
    run_same(m.joints, m.by_hand);
  }
}

// A group of three unknowns solves the displacement as well if no output needs it, so that predictions can use its
// acceleration.
TEST(JointsByHand, FewerOutputsKeepThePredictor) {
  const Prepared p = prepare(sample("slider_crank").with_outputs({"C"}));
  EXPECT_EQ(p.plan().run.predictor, (Predictor{Predictor::Kind::hermite, 5}));
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
  run_same(joints, by_hand);
}

}  // namespace
}  // namespace assur
