#include "program/graph.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace assur {
namespace {

constexpr Slot kA{Memory::work, 0}, kB{Memory::work, 1}, kC{Memory::work, 2};

std::vector<Op> ops_of(const Phase& phase) {
  std::vector<Op> ops;
  for (const Instruction& n : phase.code) ops.push_back(n.op);
  return ops;
}

TEST(Graph, EqualOperationsAreOneValue) {
  Graph g;
  const Value a = g.load(kA), b = g.load(kB);
  EXPECT_EQ((a + b).id, (b + a).id);
  EXPECT_EQ((a * b).id, (b * a).id);
  EXPECT_NE((a - b).id, (b - a).id);
  EXPECT_NE(larger(a, b).id, larger(b, a).id);  // which of them differs for NaN
  EXPECT_EQ(g.load(kA).id, a.id);
  EXPECT_NE(g.constant(0.0).id, g.constant(-0.0).id);
}

TEST(Graph, LeavesOutWhatTheStructureLacks) {
  Graph g;
  const Value a = g.load(kA), zero = g.constant(0), one = g.constant(1);
  for (const Value v : {a + zero, zero + a, a - zero, a * one, one * a, a / one}) EXPECT_EQ(v.id, a.id);
  for (const Value v : {a * zero, zero * a, zero / a, one - one}) EXPECT_EQ(v.id, zero.id);
  EXPECT_EQ((g.constant(2) * g.constant(3)).id, g.constant(6).id);
  EXPECT_NE((a - a).id, zero.id);  // NaN, if a is not finite
  EXPECT_EQ(if_at_most(a, one, zero, zero).id, zero.id);
}

TEST(Graph, FusesProductsWithOneUse) {
  Graph g;
  const Value a = g.load(kA), b = g.load(kB), c = g.load(kC);
  g.store(kA, c + a * b);
  EXPECT_EQ(ops_of(g.phase()), (std::vector{Op::load, Op::load, Op::load, Op::fma}));
  g.store(kB, a * b);  // a second use
  EXPECT_EQ(ops_of(g.phase()).back(), Op::add);

  Graph other;
  const Value x = other.load(kA), y = other.load(kB), z = other.load(kC);
  other.store(kA, z - x * y);
  other.store(kB, y * z - x);
  const std::vector<Op> ops = ops_of(other.phase());
  EXPECT_EQ(std::count(ops.begin(), ops.end(), Op::fnma), 1);
  EXPECT_EQ(std::count(ops.begin(), ops.end(), Op::fms), 1);
  EXPECT_EQ(std::count(ops.begin(), ops.end(), Op::multiply), 0);
}

TEST(Graph, WritesOnlyWhatIsStored) {
  Graph g;
  const Value a = g.load(kA);
  (void)square_root(a);
  g.store(kB, absolute(a));
  const Phase phase = g.phase();
  EXPECT_EQ(ops_of(phase), (std::vector{Op::load, Op::absolute}));
  ASSERT_EQ(phase.stores.size(), 1U);
  EXPECT_EQ(phase.stores[0].to, kB);
  EXPECT_EQ(phase.stores[0].value, 1U);
}

}  // namespace
}  // namespace assur
