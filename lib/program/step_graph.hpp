// Builds a phase of a step program: a graph of values, in which equal operations are one value.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "program/step_program.hpp"

namespace assur {

class Graph;

// A number that is not known yet: a value of a graph. Or a constant, which has no graph. It has the functions of Lanes
// (evaluation/lane_vector-inl.hpp), so that the same text computes numbers or writes their program.
struct Value {
  Graph* graph = nullptr;
  std::uint32_t id = 0;
  double number = 0;  // of a constant

  [[nodiscard]] static Value set(double number) { return {nullptr, 0, number}; }
  [[nodiscard]] bool is_constant() const { return graph == nullptr; }
  void add_product(const Value& a, const Value& b);       // fused
  void subtract_product(const Value& a, const Value& b);  // fused

  // Numbers that a phase computes and reads again; first 0.
  template <std::size_t n>
  class Fixed {
   public:
    [[nodiscard]] const Value& operator[](std::size_t i) const { return values_[i]; }
    void set(std::size_t i, const Value& v) { values_[i] = v; }

   private:
    std::array<Value, n> values_;
  };
  class Array {
   public:
    explicit Array(std::size_t size) : values_(size) {}
    [[nodiscard]] const Value& operator[](std::size_t i) const { return values_[i]; }
    void set(std::size_t i, const Value& v) { values_[i] = v; }

   private:
    std::vector<Value> values_;
  };
};

// The result of an operation, folded if its operands are constants. It is left out if it adds 0 or multiplies by 0 or
// 1: such a constant stands for what the structure lacks. Only the sign of a zero may differ.
[[nodiscard]] Value make(Op op, Value a, Value b = {}, Value c = {}, Value d = {});

class Graph {
 public:
  [[nodiscard]] Value load(Slot slot);
  [[nodiscard]] Value pick(Slot first, const Value& index);
  void store(Slot to, const Value& value) { stores_.push_back({to, node_of(value)}); }

  // The phase of all stores so far.
  [[nodiscard]] Phase phase() const;
  // The same; the graph is empty then, for the next phase.
  [[nodiscard]] Phase take_phase();

 private:
  friend Value make(Op op, Value a, Value b, Value c, Value d);
  struct Node {
    Op op;
    std::array<std::uint32_t, 4> operand;
    Slot slot;
    double number;
  };

  [[nodiscard]] static std::optional<Value> negated(const Value& v);
  [[nodiscard]] static std::optional<Value> simplified(Op op, const Value& a, const Value& b, const Value& c,
                                                       const Value& d);
  Value add(const Node& node);
  [[nodiscard]] std::size_t place_of(const Node& node) const;  // in the table
  [[nodiscard]] std::uint32_t node_of(const Value& value);

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> table_;  // of nodes by their hash, counted from 1; 0: free. At most half of it is used
  std::vector<Phase::Store> stores_;
};

[[nodiscard]] inline Value operator+(const Value& a, const Value& b) { return make(Op::add, a, b); }
[[nodiscard]] inline Value operator-(const Value& a, const Value& b) { return make(Op::subtract, a, b); }
[[nodiscard]] inline Value operator*(const Value& a, const Value& b) { return make(Op::multiply, a, b); }
[[nodiscard]] inline Value operator/(const Value& a, const Value& b) { return make(Op::divide, a, b); }
[[nodiscard]] inline Value operator-(const Value& a) { return Value::set(-1) * a; }
[[nodiscard]] inline Value operator*(double a, const Value& b) { return Value::set(a) * b; }
[[nodiscard]] inline Value sqrt(const Value& a) { return make(Op::square_root, a); }
[[nodiscard]] inline Value abs(const Value& a) { return make(Op::absolute, a); }
[[nodiscard]] inline Value copy_sign(const Value& a, const Value& b) { return make(Op::copy_sign, a, b); }
[[nodiscard]] inline Value round(const Value& a) { return make(Op::round, a); }
[[nodiscard]] inline Value max(const Value& a, const Value& b) { return make(Op::larger, a, b); }
// a <= b ? yes : no
[[nodiscard]] inline Value if_at_most(const Value& a, const Value& b, const Value& yes, const Value& no) {
  return make(Op::select, a, b, yes, no);
}
// False: only a run knows.
[[nodiscard]] inline bool all_at_most(const Value&, const Value&) { return false; }
inline void Value::add_product(const Value& a, const Value& b) { *this = make(Op::fma, a, b, *this); }
inline void Value::subtract_product(const Value& a, const Value& b) { *this = make(Op::fnma, a, b, *this); }

}  // namespace assur
