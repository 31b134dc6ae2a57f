#include "program/step_graph.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace assur {
namespace {

constexpr Slot kA{Memory::work, 0}, kB{Memory::work, 1}, kC{Memory::work, 2};

std::vector<Op> ops_of(const Phase& phase) {
  std::vector<Op> ops;
  for (const Instruction& n : phase.code) ops.push_back(n.op);
  return ops;
}

bool is_constant(const Value& v, double number) { return v.is_constant() && v.number == number; }

Value fused(const Value& a, const Value& b, Value c) {
  c.add_product(a, b);
  return c;
}

TEST(Graph, EqualOperationsAreOneValue) {
  Graph g;
  const Value a = g.load(kA), b = g.load(kB);
  EXPECT_EQ((a + b).id, (b + a).id);
  EXPECT_EQ((a * b).id, (b * a).id);
  EXPECT_EQ(fused(a, b, a).id, fused(b, a, a).id);
  EXPECT_NE((a - b).id, (b - a).id);
  EXPECT_NE(max(a, b).id, max(b, a).id);  // which of them differs for NaN
  EXPECT_EQ(g.load(kA).id, a.id);
  EXPECT_NE((a + Value::set(2)).id, (a + Value::set(3)).id);
}

TEST(Graph, LeavesOutWhatTheStructureLacks) {
  Graph g;
  const Value a = g.load(kA), b = g.load(kB), zero = Value::set(0), one = Value::set(1), minus = Value::set(-1);
  for (const Value& v : {a + zero, zero + a, a - zero, a * one, one * a, a / one, fused(zero, b, a)}) {
    EXPECT_EQ(v.id, a.id);
  }
  for (const Value& v : {a * zero, zero * a, zero / a, one - one}) EXPECT_TRUE(is_constant(v, 0));
  EXPECT_TRUE(is_constant(Value::set(2) * Value::set(3), 6));
  EXPECT_FALSE((a - a).is_constant());  // NaN, if a is not finite
  EXPECT_TRUE(is_constant(if_at_most(a, one, zero, zero), 0));
  EXPECT_EQ(fused(one, b, a).id, (a + b).id);
  for (const Value& v : {fused(minus, b, a), a + minus * b, minus * b + a}) EXPECT_EQ(v.id, (a - b).id);
  EXPECT_EQ((a - minus * b).id, (a + b).id);
  EXPECT_EQ(abs(minus * a).id, abs(a).id);
}

// What is fused is said where it is computed.
TEST(Graph, FusesWhatItIsTold) {
  Graph g;
  const Value a = g.load(kA), b = g.load(kB), c = g.load(kC);
  g.store(kA, fused(a, b, c));
  EXPECT_EQ(ops_of(g.phase()), (std::vector{Op::load, Op::load, Op::load, Op::fma}));
  g.store(kB, c - a * b);
  EXPECT_EQ(ops_of(g.phase()), (std::vector{Op::load, Op::load, Op::load, Op::fma, Op::multiply, Op::subtract}));
}

TEST(Graph, WritesOnlyWhatIsStored) {
  Graph g;
  const Value a = g.load(kA);
  (void)sqrt(a);
  g.store(kB, abs(a));
  const Phase phase = g.phase();
  EXPECT_EQ(ops_of(phase), (std::vector{Op::load, Op::absolute}));
  ASSERT_EQ(phase.stores.size(), 1U);
  EXPECT_EQ(phase.stores[0].to, kB);
  EXPECT_EQ(phase.stores[0].value, 1U);
}

}  // namespace
}  // namespace assur
