// Groups, levels and classes of the samples; declared groups.
#include <gtest/gtest.h>

#include "samples/samples.hpp"
#include "structure/look.hpp"

namespace assur {
namespace {

using enum Formulation;
using look::structure;
using Sizes = std::vector<int>;

// ---- samples

TEST(Groups, StewartHasItsDeclaredGroups) {
  const GroupedSystem s = structure(sample("stewart"), groups);
  ASSERT_EQ(s.groups.size(), 7u);
  EXPECT_EQ(s.levels, 2);
  EXPECT_EQ(s.classes.size(), 2u);
  EXPECT_EQ(s.unknowns, 102);
  EXPECT_EQ(s.equations, 102);
  EXPECT_EQ(s.eliminated, 0);
  EXPECT_TRUE(s.checks.empty());
  EXPECT_EQ(s.derived, 6 * (3 + 3));

  const SolvedGroup& terminal = look::group(s, "SG_T");
  EXPECT_EQ(terminal.level, 0);
  EXPECT_EQ(s.shape(terminal), (Shape{12, 39, 1, 3}));
  for (int leg = 1; leg <= 6; ++leg) {
    const SolvedGroup& g = look::group(s, "SG_HS" + std::to_string(leg));
    EXPECT_EQ(g.level, 1);
    EXPECT_EQ(g.of, 15);
    EXPECT_EQ(s.shape(g), (Shape{15, 48, 6, 3}));
    EXPECT_EQ(look::block_sizes(look::class_of(s, g)), (Sizes{9, 3, 3}));
  }
}

TEST(Groups, BlocksOfALegFollowEachOther) {
  const GroupedSystem s = structure(sample("stewart"), groups);
  const SolvedGroup& leg = look::group(s, "SG_HS1");
  const GroupClass& c = look::class_of(s, leg);
  std::vector<std::set<std::string>> block(3);
  for (std::size_t i = 0; i < leg.unknowns.size(); ++i) {
    const std::string name = s.system->coordinate_name(leg.unknowns[i]);
    block[static_cast<std::size_t>(c.unknown_block[i])].insert(name.substr(0, 2));
  }
  EXPECT_EQ(block[0], (std::set<std::string>{"B1", "e1", "r1"}));
  EXPECT_EQ(block[1], std::set<std::string>{"c1"});
  EXPECT_EQ(block[2], std::set<std::string>{"d1"});
}

TEST(Groups, GlobalStewartIsOneGroup) {
  const GroupedSystem s = structure(sample("stewart"), global);
  ASSERT_EQ(s.groups.size(), 1u);
  EXPECT_EQ(s.levels, 1);
  EXPECT_EQ(s.shape(s.groups[0]), (Shape{102, 39 + 6 * (48 + 12 + 9), 1, 3}));  // P_k and t_k: rows of O, u, v, w
  EXPECT_EQ(look::class_of(s, s.groups[0]).blocks, 3 + 3 + 6 * 3);
}

// The irreducible formulation ignores declared groups, so the driven pose vanishes. B and r follow from linear rows.
TEST(Groups, IrreducibleStewartHasEighteenGroups) {
  const GroupedSystem s = structure(sample("stewart"), irreducible);
  EXPECT_EQ(s.unknowns, 6 * 15);
  EXPECT_EQ(s.eliminated, 6 * 6);
  ASSERT_EQ(s.groups.size(), 18u);
  EXPECT_EQ(s.levels, 3);
  EXPECT_EQ(s.classes.size(), 3u);
  for (const SolvedGroup& g : s.groups) {
    EXPECT_EQ(g.unknowns.size(), 3u) << g.name;
    EXPECT_EQ(look::class_of(s, g).blocks, 1);
  }
  for (int level = 0; level < 3; ++level) {
    EXPECT_EQ(std::count_if(s.groups.begin(), s.groups.end(), [&](const SolvedGroup& g) { return g.level == level; }),
              6);
  }
}

TEST(Groups, AndrewsIsThreeDyadsOnTwoLevels) {
  for (const Formulation f : {groups, irreducible}) {
    const GroupedSystem s = structure(sample("andrews"), f);
    ASSERT_EQ(s.groups.size(), 3u);
    EXPECT_EQ(s.levels, 2);
    const auto level = [&](const char* name) { return look::group(s, name).level; };
    EXPECT_EQ(level("E"), 0);
    EXPECT_EQ(level("G"), 1);
    EXPECT_EQ(level("H"), 1);
    EXPECT_EQ(look::group(s, "G").group_class, look::group(s, "H").group_class);
  }
}

TEST(Groups, LoopsInSeriesHaveALevelEach) {
  const GroupedSystem s = structure(sample("four_bar:64"), groups);
  EXPECT_EQ(s.groups.size(), 64u);
  EXPECT_EQ(s.levels, 64);
  EXPECT_EQ(s.classes.size(), 1u);
  for (std::size_t i = 0; i < s.groups.size(); ++i) {
    EXPECT_EQ(s.groups[i].name, "B" + std::to_string(i + 1));
    EXPECT_EQ(s.groups[i].level, static_cast<int>(i));
  }
}

TEST(Groups, RingsHaveThreeNonzerosInEachRow) {
  for (const int n : {12, 18, 60}) {
    const GroupedSystem s = structure(sample("rings:legs=3,terminal=24,n=" + std::to_string(n)), groups);
    ASSERT_EQ(s.groups.size(), 4u);
    EXPECT_EQ(s.levels, 2);
    EXPECT_EQ(s.shape(look::group(s, "SG_T")).nnz, 3 * 24);
    for (const char* leg : {"SG_L1", "SG_L2", "SG_L3"}) {
      EXPECT_EQ(s.shape(look::group(s, leg)), (Shape{n, 3 * n, 3, 3}));
      EXPECT_EQ(look::class_of(s, look::group(s, leg)).blocks, 1);
    }
  }
}

TEST(Groups, GoughIsAtRest) {
  const GroupedSystem s = structure(sample("gough"), groups);
  EXPECT_TRUE(s.groups.empty());
  EXPECT_EQ(s.levels, 0);
  EXPECT_EQ(s.left_out.static_groups, 1);
  EXPECT_EQ(s.static_coordinates.size(), 12u);
  EXPECT_EQ(s.left_out.unknowns, 0);
}

TEST(Groups, SamplesHaveTheirMobility) {
  const std::pair<const char*, int> expected[] = {
      {"four_bar", 1}, {"four_bar:64", 1},          {"stewart", 6},
      {"andrews", 1},  {"slider_crank", 1},         {"n_four_bar:40", 1},
      {"hexapod", 6},  {"stewart:platforms=3", 18}, {"almost_parallelogram", 1}};
  for (const auto& [name, mobility] : expected) {
    for (const Formulation f : {global, groups, irreducible}) {
      const GroupedSystem s = structure(sample(name), f);
      EXPECT_EQ(s.mobility, mobility) << name;
      EXPECT_TRUE(s.undetermined.empty()) << name;
      EXPECT_TRUE(s.redundant.empty()) << name;
    }
  }
}

TEST(Groups, FillCountsLAndU) {
  const GroupedSystem s = structure(sample("four_bar"), groups);
  EXPECT_EQ(s.fill(s.groups[0]), 4);  // a full 2 x 2 matrix
  const GroupedSystem stewart = structure(sample("stewart"), groups);
  const SolvedGroup& leg = look::group(stewart, "SG_HS1");
  EXPECT_GE(stewart.fill(leg), stewart.shape(leg).nnz);
  EXPECT_LE(stewart.fill(leg), 15 * 15);
}

// ---- classes

// Three points F_i of a driven body, and points Q_i at given distances from two of them.
SceneBuilder dyads() {
  SceneBuilder b("dyads", 2);
  b.fixed_point("A", {0, 0, 0})
      .fixed_point("B", {2, 0, 0})
      .point("C", {1, 0, 0})
      .drive("crank", PointAngle{"A", "C", "", Law::polynomial({0, 1})});
  return b.time(0, 1, 0.01);
}

TEST(Classes, IgnoreValues) {
  const Scene scene = dyads()
                          .point("P", {1.5, 1, 0})
                          .point("Q", {1.5, -1, 0})
                          .constrain("PC", Distance{"P", "C", {}})
                          .constrain("PB", Distance{"P", "B", {}})
                          .constrain("QC", Distance{"Q", "C", 1.25})
                          .constrain("QB", Distance{"Q", "B", 1.0})
                          .build();
  EXPECT_EQ(structure(scene, groups).classes.size(), 1u);
}

// A zero in a fixed direction, in a fixed point or on the right-hand side stays in the pattern.
TEST(Classes, KeepZeroComponents) {
  SceneBuilder b = dyads();
  b.fixed_vector("d", {1, 0, 0}).fixed_vector("e", {0.6, 0.8, 0});
  for (const std::string k : {"d", "e"}) {
    const double x = k == "d" ? 1 : 0.6, y = k == "d" ? 0 : 0.8;
    b.point("P" + k, {1 + x, y, 0}).constrain("line" + k, OnLine{"P" + k, "C", k});
    b.constrain("dot" + k, Dot{{"C", "P" + k}, k, 1.0});
    b.point("R" + k, {1 + x, y, 0}).constrain("sum" + k, Linear{{{"R" + k, 1}, {"C", -1}}, {x, y, 0}});
  }
  const GroupedSystem s = structure(b.build(), groups);
  const auto class_of = [&](const std::string& name) { return look::group(s, name).group_class; };
  EXPECT_EQ(class_of("Pd+lined.lambda"), class_of("Pe+linee.lambda"));
  EXPECT_EQ(class_of("Rd.x"), class_of("Re.x"));
  EXPECT_EQ(class_of("Rd.y"), class_of("Re.y"));
}

// Classes depend on roles: fixed or moving, input or constant.
TEST(Classes, DependOnRoles) {
  const Scene scene = dyads()
                          .point("S", {1, 1, 0})
                          .drive("sx", DrivenCoordinate{"S.x", Law::constant(1)})
                          .drive("sy", DrivenCoordinate{"S.y", Law::constant(1)})
                          .point("P", {1.5, 1, 0})
                          .constrain("PC", Distance{"P", "C", {}})
                          .constrain("PB", Distance{"P", "B", {}})
                          .point("Q", {1.5, 1, 0})
                          .constrain("QC", Distance{"Q", "C", {}})
                          .constrain("QS", Distance{"Q", "S", {}})
                          .point("R", {1.5, 2, 0})
                          .constrain("RC", Distance{"R", "C", {}})
                          .constrain("RP", Distance{"R", "P", {}})
                          .build();
  const GroupedSystem s = structure(scene, groups);
  const auto class_of = [&](const char* name) { return look::group(s, name).group_class; };
  EXPECT_NE(class_of("P"), class_of("Q"));
  EXPECT_NE(class_of("Q"), class_of("R"));
  EXPECT_NE(class_of("P"), class_of("R"));
  // If the program may set S, it can move, and Q has the same class as R.
  StructureOptions options;
  options.controlled = {"sx", "sy"};
  const GroupedSystem controlled = group_equations(scene, options);
  EXPECT_EQ(look::group(controlled, "Q").group_class, look::group(controlled, "R").group_class);
}

// ---- declared groups

SceneBuilder chain() {  // Q needs P, and R needs Q
  SceneBuilder b = dyads();
  b.point("P", {1.5, 1, 0}).constrain("PC", Distance{"P", "C", {}}).constrain("PB", Distance{"P", "B", {}});
  b.point("Q", {2.5, 1, 0}).constrain("QP", Distance{"Q", "P", {}}).constrain("QB", Distance{"Q", "B", {}});
  b.point("R", {3.5, 1, 0}).constrain("RQ", Distance{"R", "Q", {}}).constrain("RB", Distance{"R", "B", {}});
  return b;
}

TEST(DeclaredGroups, AUnionOfBlocksIsOneGroup) {
  const GroupedSystem s = structure(chain().add(DeclaredGroup{"PQ", {"P", "Q"}}).build(), groups);
  ASSERT_EQ(s.groups.size(), 2u);
  const SolvedGroup& pq = look::group(s, "PQ");
  EXPECT_EQ(look::unknowns(s, pq), (std::set<std::string>{"P.x", "P.y", "Q.x", "Q.y"}));
  EXPECT_EQ(look::block_sizes(look::class_of(s, pq)), (Sizes{2, 2}));
  EXPECT_EQ(look::group(s, "R").level, 1);
}

TEST(DeclaredGroups, AnOutsideBlockBetweenTwoBlocksIsNamed) {
  const Scene scene = chain().add(DeclaredGroup{"PR", {"P", "R"}}).build();
  EXPECT_EQ(
      look::error(Error::Kind::input, [&] { (void)structure(scene, groups); }),
      "/groups/PR: needs Q, which in turn needs this group: it lies between blocks of the group and must belong to "
      "it");
  EXPECT_EQ(structure(scene, irreducible).groups.size(), 3u);  // `irreducible` and `global` ignore declared groups
  EXPECT_EQ(structure(scene, global).groups.size(), 1u);
}

// R lies between Q and S and is named. T only follows S and is not named.
TEST(DeclaredGroups, NamesOnlyBlocksInBetween) {
  const Scene scene = chain()
                          .point("S", {4.5, 1, 0})
                          .constrain("SR", Distance{"S", "R", {}})
                          .constrain("SB", Distance{"S", "B", {}})
                          .point("T", {5.5, 1, 0})
                          .constrain("TS", Distance{"T", "S", {}})
                          .constrain("TB", Distance{"T", "B", {}})
                          .add(DeclaredGroup{"QS", {"Q", "S"}})
                          .build();
  EXPECT_EQ(
      look::error(Error::Kind::input, [&] { (void)structure(scene, groups); }),
      "/groups/QS: needs R, which in turn needs this group: it lies between blocks of the group and must belong to "
      "it");
}

TEST(DeclaredGroups, RefusesACutThroughABlock) {
  const Scene scene = dyads()
                          .point("P", {1.5, 1, 0})
                          .point("Q", {2.5, 1.4, 0})
                          .constrain("PC", Distance{"P", "C", {}})
                          .constrain("QP", Distance{"Q", "P", {}})
                          .constrain("QB", Distance{"Q", "B", {}})
                          .constrain("across", Dot{{"P", "Q"}, {"C", "B"}, {}})
                          .add(DeclaredGroup{"half", {"P"}})
                          .build();
  EXPECT_EQ(look::error(Error::Kind::input, [&] { (void)structure(scene, groups); }),
            "/groups/half: must be a union of irreducible groups, but cuts through P+Q; add all of it (P, Q) to the "
            "group, or nothing");
}

}  // namespace
}  // namespace assur
