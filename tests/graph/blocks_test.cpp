// Matching and Dulmage-Mendelsohn decomposition of equations x unknowns.
#include "graph/blocks.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "equations/lowering.hpp"
#include "structure/look.hpp"

namespace assur {
namespace {

using Names = std::set<std::string>;

struct Decomposed {
  System system;
  Blocks blocks;

  explicit Decomposed(const Scene& scene) : system(lower(std::make_shared<const Scene>(scene))) {
    std::vector<Index> equations(system.equations.size()), unknowns;
    std::iota(equations.begin(), equations.end(), 0);
    for (std::size_t c = 0; c < system.coordinates.size(); ++c) {
      if (system.coordinates[c].role == Role::unknown) unknowns.push_back(static_cast<Index>(c));
    }
    blocks = decompose(system, equations, unknowns);
  }
  [[nodiscard]] Names unknowns(std::span<const Index> of) const {
    Names out;
    for (const Index u : of) out.insert(system.coordinate_name(u));
    return out;
  }
  [[nodiscard]] Names equations(std::span<const Index> of) const {
    Names out;
    for (const Index e : of) out.insert(system.equation_name(e));
    return out;
  }
};

// P with rods from A and B is well determined, Q has one redundant rod, R lacks one.
SceneBuilder three_parts() {
  SceneBuilder b("parts", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("B", {2, 0, 0}).fixed_point("C", {1, 2, 0});
  b.point("P", {1, 1, 0}).constrain("PA", Distance{"P", "A", {}}).constrain("PB", Distance{"P", "B", {}});
  b.point("Q", {1, -1, 0}).constrain("QA", Distance{"Q", "A", {}}).constrain("QB", Distance{"Q", "B", {}});
  b.constrain("QC", Distance{"Q", "C", {}});
  b.point("R", {3, 0, 0}).constrain("RB", Distance{"R", "B", {}});
  return b.time(0, 1, 0.1);
}

TEST(Blocks, NamesOverAndUnderdeterminedParts) {
  const Decomposed d(three_parts().build());
  EXPECT_FALSE(d.blocks.square());
  EXPECT_EQ(d.equations(d.blocks.surplus_equations), (Names{"QA", "QB", "QC"}));
  EXPECT_EQ(d.unknowns(d.blocks.over_unknowns), (Names{"Q.x", "Q.y"}));
  EXPECT_EQ(d.unknowns(d.blocks.surplus_unknowns), (Names{"R.x", "R.y"}));
  EXPECT_EQ(d.equations(d.blocks.under_equations), Names{"RB"});
  ASSERT_EQ(d.blocks.size(), 1);
  EXPECT_EQ(d.unknowns(d.blocks.unknowns_of(0)), (Names{"P.x", "P.y"}));
  EXPECT_EQ(d.equations(d.blocks.equations_of(0)), (Names{"PA", "PB"}));
}

// Parts connected to an undetermined part are undetermined, too. Parts connected to an overdetermined part are not.
TEST(Blocks, FollowersOfUndeterminedPartsAreUndetermined) {
  const Decomposed d(three_parts()
                         .point("S", {2, 1, 0})
                         .constrain("SR", Distance{"S", "R", {}})
                         .constrain("SA", Distance{"S", "A", {}})
                         .point("T", {0, -1, 0})
                         .constrain("TQ", Distance{"T", "Q", {}})
                         .constrain("TA", Distance{"T", "A", {}})
                         .build());
  EXPECT_EQ(d.unknowns(d.blocks.surplus_unknowns), (Names{"R.x", "R.y", "S.x", "S.y"}));
  EXPECT_EQ(d.unknowns(d.blocks.over_unknowns), (Names{"Q.x", "Q.y"}));
  ASSERT_EQ(d.blocks.size(), 2);
  EXPECT_EQ(d.unknowns(d.blocks.unknowns_of(1)), (Names{"T.x", "T.y"}));
}

TEST(Blocks, EveryBlockFollowsTheBlocksThatItNeeds) {
  for (const char* name : {"stewart", "andrews", "four_bar:20", "rings:legs=2,n=18,terminal=24"}) {
    const Decomposed d(sample(name));
    const Blocks& b = d.blocks;
    EXPECT_TRUE(b.square());
    std::size_t unknowns = 0;
    for (Index k = 0; k < b.size(); ++k) {
      EXPECT_EQ(b.equations_of(k).size(), b.unknowns_of(k).size());
      unknowns += b.unknowns_of(k).size();
      Index level = 0;
      for (const Index o : b.needs_of(k)) {
        EXPECT_LT(o, k);
        level = std::max(level, b.level[static_cast<std::size_t>(o)] + 1);
      }
      EXPECT_EQ(b.level[static_cast<std::size_t>(k)], level);
      EXPECT_LE(b.level[static_cast<std::size_t>(std::max(k - 1, Index{0}))], level);
      // The equations of a block contain only its own unknowns, those of the blocks that it needs, and known
      // coordinates.
      std::set<Index> allowed(b.unknowns_of(k).begin(), b.unknowns_of(k).end());
      for (const Index o : b.needs_of(k)) allowed.insert(b.unknowns_of(o).begin(), b.unknowns_of(o).end());
      std::vector<Index> mentioned;
      for (const Index e : b.equations_of(k)) {
        d.system.mentioned(e, mentioned);
        for (const Index c : mentioned) {
          const bool known = d.system.coordinates[static_cast<std::size_t>(c)].role != Role::unknown;
          EXPECT_TRUE(known || allowed.contains(c)) << d.system.coordinate_name(c);
        }
      }
    }
    EXPECT_EQ(unknowns, b.unknowns.size());
    EXPECT_EQ(std::set<Index>(b.unknowns.begin(), b.unknowns.end()).size(), unknowns);
    EXPECT_EQ(std::set<Index>(b.equations.begin(), b.equations.end()).size(), unknowns);
  }
}

TEST(Blocks, HandlesAnEmptySystem) {
  const Decomposed d(SceneBuilder("crank", 2)
                         .fixed_point("A", {0, 0, 0})
                         .point("C", {1, 0, 0})
                         .drive("crank", PointAngle{"A", "C", "", Law::polynomial({0, 1})})
                         .time(0, 1, 0.1)
                         .build());
  EXPECT_EQ(d.blocks.size(), 0);
  EXPECT_TRUE(d.blocks.square());
}

}  // namespace
}  // namespace assur
