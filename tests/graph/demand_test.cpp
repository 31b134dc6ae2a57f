// Parts that the outputs do not need are left out and listed.
#include <gtest/gtest.h>

#include "samples/samples.hpp"
#include "structure/look.hpp"

namespace assur {
namespace {

using enum Formulation;
using look::structure;

std::vector<std::string> handles(const std::string& part) {
  std::vector<std::string> out;
  for (int k = 1; k <= 6; ++k) out.push_back("handle" + std::to_string(k) + part);
  return out;
}

TEST(Demand, HandleAnglesNeedNineOfFifteen) {
  const GroupedSystem s = structure(sample("stewart").with_outputs(handles(".value")), groups);
  ASSERT_EQ(s.groups.size(), 7u);
  EXPECT_EQ(look::solved(s), 12 + 6 * 9);
  EXPECT_EQ(s.left_out.unknowns, 6 * 6);
  EXPECT_EQ(s.left_out.equations, 6 * 6);
  EXPECT_TRUE(s.left_out.groups.empty());
  for (int leg = 1; leg <= 6; ++leg) {
    const std::string k = std::to_string(leg);
    const SolvedGroup& g = look::group(s, "SG_HS" + k);
    EXPECT_EQ(g.of, 15);
    for (const std::string& u : look::unknowns(s, g)) {
      EXPECT_TRUE(u[0] == 'B' || u[0] == 'e' || u[0] == 'r') << u;
    }
  }
  ASSERT_EQ(s.left_out.levels.size(), 7u);
  for (const SolvedGroup& g : s.groups) {
    EXPECT_EQ(g.derivatives, 0) << g.name;
    EXPECT_EQ(g.wanted_derivatives, 0) << g.name;
    EXPECT_EQ(s.shape(g).rhs, 1);
  }
  for (const LeftOut::Level& level : s.left_out.levels) {
    EXPECT_EQ(level.derivatives, 0) << level.group;
    EXPECT_FALSE(level.for_predictor) << level.group;
  }
}

TEST(Demand, HandleAnglesNeedThreeAfterPresolve) {
  const GroupedSystem s = structure(sample("stewart").with_outputs(handles(".value")), irreducible);
  EXPECT_EQ(s.groups.size(), 6u);
  EXPECT_EQ(look::solved(s), 6 * 3);
  EXPECT_EQ(s.levels, 1);
  EXPECT_EQ(s.classes.size(), 1u);
  EXPECT_EQ(s.left_out.unknowns, 6 * 6);
  ASSERT_EQ(s.left_out.groups.size(), 12u);
  EXPECT_EQ(s.left_out.groups.front(), "c1");
  EXPECT_EQ(s.left_out.groups.back(), "d6");
}

TEST(Demand, DerivativesForThePredictorAreListed) {
  const GroupedSystem s = structure(sample("stewart").with_outputs(handles(".value")), groups, 2);
  for (const SolvedGroup& g : s.groups) {
    EXPECT_EQ(g.derivatives, 2) << g.name;
    EXPECT_EQ(g.wanted_derivatives, 0) << g.name;
    EXPECT_EQ(look::class_of(s, g).first_wanted, 0) << g.name;  // the predictor reads all unknowns
  }
  ASSERT_EQ(s.left_out.levels.size(), 7u);
  for (const LeftOut::Level& level : s.left_out.levels) {
    EXPECT_EQ(level.derivatives, 2) << level.group;
    EXPECT_TRUE(level.for_predictor) << level.group;
  }
}

TEST(Demand, NeedsOneDerivativeForRates) {
  const GroupedSystem s = structure(sample("stewart").with_outputs(handles(".rate")), groups);
  for (const SolvedGroup& g : s.groups) {
    EXPECT_EQ(g.derivatives, 1) << g.name;
    EXPECT_EQ(g.wanted_derivatives, 1) << g.name;
  }
  EXPECT_EQ(s.left_out.levels.size(), 7u);
}

TEST(Demand, KeepComputesAllUnknowns) {
  SceneBuilder b("kept", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("B", {2, 0, 0}).point("C", {1, 0, 0});
  b.drive("crank", PointAngle{"A", "C", "", Law::polynomial({0, 1})});
  b.point("P", {1.5, 1, 0}).constrain("PC", Distance{"P", "C", {}}).constrain("PB", Distance{"P", "B", {}});
  b.point("Q", {2.5, 1, 0}).constrain("QP", Distance{"Q", "P", {}}).constrain("QB", Distance{"Q", "B", {}});
  b.output("P.position").time(0, 1, 0.01);
  SceneBuilder kept = b, shrunk = b;
  const GroupedSystem k = structure(kept.add(DeclaredGroup{"PQ", {"P", "Q"}, true}).build(), groups);
  const GroupedSystem s = structure(shrunk.add(DeclaredGroup{"PQ", {"P", "Q"}, false}).build(), groups);
  EXPECT_EQ(look::group(k, "PQ").unknowns.size(), 4u);
  EXPECT_EQ(k.left_out.unknowns, 0);
  EXPECT_EQ(look::group(s, "PQ").unknowns.size(), 2u);
  EXPECT_EQ(look::group(s, "PQ").of, 4);
  EXPECT_EQ(s.left_out.unknowns, 2);
}

TEST(Demand, KeepsAWholeLeg) {
  const Scene scene = sample("stewart").with_outputs(handles(".value"));
  SceneBuilder b("stewart", 3);
  for (const Point& x : scene.points()) b.add(x);
  for (const Vector& x : scene.vectors()) b.add(x);
  for (const Body& x : scene.bodies()) b.add(x);
  for (const Constraint& x : scene.constraints()) b.add(x);
  for (const Driver& x : scene.drivers()) b.add(x);
  for (const Measure& x : scene.measures()) b.add(x);
  for (DeclaredGroup x : scene.groups()) {
    x.keep = x.name == "SG_HS2";
    b.add(x);
  }
  for (const std::string& x : scene.outputs()) b.output(x);
  b.time(0, 1, 0.01);
  const GroupedSystem s = structure(b.build(), groups);
  EXPECT_EQ(look::group(s, "SG_HS1").unknowns.size(), 9u);
  EXPECT_EQ(look::group(s, "SG_HS2").unknowns.size(), 15u);
  EXPECT_EQ(s.left_out.unknowns, 5 * 6);
}

// Unneeded groups are left out; needed ones are computed up to the needed derivative.
TEST(Demand, NeedsOneDyadOfAndrews) {
  const GroupedSystem s = structure(sample("andrews").with_outputs({"G.velocity"}), groups);
  ASSERT_EQ(s.groups.size(), 2u);
  EXPECT_EQ(s.left_out.groups, std::vector<std::string>{"H"});
  EXPECT_EQ(look::group(s, "G").derivatives, 1);
  EXPECT_EQ(look::group(s, "E").derivatives, 1);
  EXPECT_EQ(s.levels, 2);
  const GroupedSystem e = structure(sample("andrews").with_outputs({"E.position"}), groups);
  EXPECT_EQ(e.left_out.groups, (std::vector<std::string>{"G", "H"}));
  EXPECT_EQ(e.left_out.unknowns, 4);
  EXPECT_EQ(e.levels, 1);
}

// Each group computes only the derivatives that are needed: G accelerations, H positions, and E those that G needs.
TEST(Demand, DerivativesDifferByGroup) {
  const GroupedSystem s = structure(sample("andrews").with_outputs({"G.acceleration", "H.position"}), groups);
  EXPECT_EQ(look::group(s, "E").derivatives, 2);
  EXPECT_EQ(look::group(s, "G").derivatives, 2);
  EXPECT_EQ(look::group(s, "H").derivatives, 0);
  EXPECT_NE(look::group(s, "G").group_class, look::group(s, "H").group_class);
  ASSERT_EQ(s.left_out.levels.size(), 1u);
  EXPECT_EQ(s.left_out.levels[0].group, "H");
}

// Only the acceleration of e1 is an output. All other unknowns of the block need position and velocity only, and come
// before first_wanted.
TEST(Demand, LastBackSubstitutionStopsAtWantedUnknowns) {
  const GroupedSystem s = structure(sample("stewart").with_outputs({"e1.acceleration"}), groups);
  const SolvedGroup& leg = look::group(s, "SG_HS1");
  const GroupClass& c = look::class_of(s, leg);
  EXPECT_EQ(c.n, 9);
  EXPECT_EQ(c.derivatives, 2);
  ASSERT_EQ(c.first_wanted, 6);
  for (int i = 0; i < 9; ++i) {
    const std::string name = s.system->coordinate_name(leg.unknowns[static_cast<std::size_t>(i)]);
    EXPECT_EQ(name[0] == 'e', i >= 6) << name;
  }
  EXPECT_EQ(look::class_of(s, look::group(s, "SG_T")).first_wanted, 0);  // the leg reads all unknowns of the terminal
  EXPECT_EQ(s.left_out.groups.size(), 5u);
}

// A group of up to three unknowns is solved in registers, with all derivatives.
TEST(Demand, SmallGroupsComputeAllDerivatives) {
  const GroupedSystem s = structure(sample("slider_crank").with_outputs({"C"}), irreducible);
  ASSERT_EQ(s.groups.size(), 1u);
  const GroupClass& c = look::class_of(s, s.groups[0]);
  EXPECT_EQ(c.n, 3);
  EXPECT_EQ(c.derivatives, 2);
  EXPECT_EQ(c.first_wanted, 0);
}

TEST(Demand, NothingIsLeftOutWithoutOutputs) {
  for (const char* name : {"stewart", "andrews", "four_bar:3", "slider_crank"}) {
    const GroupedSystem s = structure(sample(name), groups);
    EXPECT_EQ(s.left_out.unknowns, 0);
    EXPECT_EQ(s.left_out.equations, 0);
    EXPECT_TRUE(s.left_out.groups.empty());
    EXPECT_TRUE(s.left_out.levels.empty());
    EXPECT_EQ(s.left_out.static_groups, 0);
    EXPECT_EQ(look::solved(s), s.unknowns);
  }
}

// One of two dyads stands on fixed points and never moves.
TEST(Demand, StaticGroupsAreSolvedOnce) {
  SceneBuilder b("half", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("B", {2, 0, 0}).point("C", {1, 0, 0});
  b.drive("crank", PointAngle{"A", "C", "", Law::polynomial({0, 1})});
  b.point("F", {1, 0.9, 0}).constrain("FA", Distance{"F", "A", 1.25}).constrain("FB", Distance{"F", "B", 1.25});
  b.point("P", {1.5, 1, 0}).constrain("PC", Distance{"P", "C", 1.0}).constrain("PF", Distance{"P", "F", {}});
  b.time(0, 1, 0.01);
  const GroupedSystem s = structure(b.build(), groups);
  ASSERT_EQ(s.groups.size(), 1u);
  EXPECT_EQ(s.groups[0].name, "P");
  EXPECT_EQ(s.groups[0].level, 0);
  EXPECT_EQ(s.levels, 1);
  EXPECT_EQ(s.left_out.static_groups, 1);
  ASSERT_EQ(s.static_coordinates.size(), 2u);
  EXPECT_NEAR(look::start(s, "F.x"), 1, 1e-15);
  EXPECT_NEAR(look::start(s, "F.y"), 0.75, 1e-15);  // height of a right triangle with sides 3 : 4 : 5
}

}  // namespace
}  // namespace assur
