// Builds a phase of a step program: a graph of values, in which equal operations are one value.
#pragma once

#include <bit>
#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

#include "program/step_program.hpp"

namespace assur {

class Graph;

// A value of a graph.
struct Value {
  Graph* graph = nullptr;
  std::uint32_t id = 0;
};

// Constants are folded, and so is what adds 0, multiplies by 0 or 1, or divides by 1: a constant 0 or 1 stands for what
// the structure lacks. A product that is only added to another value, or subtracted, is fused with it.
class Graph {
 public:
  [[nodiscard]] Value load(Slot slot);
  [[nodiscard]] Value constant(double number);
  [[nodiscard]] Value make(Op op, Value a, Value b = {}, Value c = {}, Value d = {});
  void store(Slot to, Value value) { stores_.push_back({to, value.id}); }

  // The phase of all stores so far.
  [[nodiscard]] Phase phase() const;

 private:
  struct Node {
    Op op;
    std::array<std::uint32_t, 4> operand;
    Slot slot;
    double number;
  };
  using Key = std::tuple<Op, std::array<std::uint32_t, 4>, Memory, std::uint32_t, std::uint64_t>;

  Value add(const Node& node);
  [[nodiscard]] bool is(Value v, double number) const;

  std::vector<Node> nodes_;
  std::map<Key, std::uint32_t> known_;
  std::vector<Phase::Store> stores_;
};

[[nodiscard]] inline Value operator+(Value a, Value b) { return a.graph->make(Op::add, a, b); }
[[nodiscard]] inline Value operator-(Value a, Value b) { return a.graph->make(Op::subtract, a, b); }
[[nodiscard]] inline Value operator*(Value a, Value b) { return a.graph->make(Op::multiply, a, b); }
[[nodiscard]] inline Value operator/(Value a, Value b) { return a.graph->make(Op::divide, a, b); }
[[nodiscard]] inline Value square_root(Value a) { return a.graph->make(Op::square_root, a); }
[[nodiscard]] inline Value absolute(Value a) { return a.graph->make(Op::absolute, a); }
[[nodiscard]] inline Value copy_sign(Value a, Value sign) { return a.graph->make(Op::copy_sign, a, sign); }
[[nodiscard]] inline Value round(Value a) { return a.graph->make(Op::round, a); }
[[nodiscard]] inline Value larger(Value a, Value b) { return a.graph->make(Op::larger, a, b); }
// a <= b ? yes : no
[[nodiscard]] inline Value if_at_most(Value a, Value b, Value yes, Value no) {
  return a.graph->make(Op::select, a, b, yes, no);
}

}  // namespace assur
