// The step of a group as data: phases of operations on values in single assignment, without control flow, pointers or
// widths. Every lane computes and decides for itself, so its bits depend neither on the executor nor on its neighbours.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace assur {

// a, b, c, d: operands, in this order.
enum class Op : std::uint8_t {
  load,         // number in a slot
  constant,     // the same number in all lanes
  add,          // a + b
  subtract,     // a - b
  multiply,     // a b
  divide,       // a / b
  fma,          // a b + c, rounded once
  fnma,         // c - a b, rounded once
  fms,          // a b - c, rounded once
  square_root,  // of a
  absolute,     // |a|
  copy_sign,    // |a| with the sign of b
  round,        // a to the nearest integer, halves to even
  larger,       // a > b ? a : b; the second if one is NaN
  select,       // a <= b ? c : d; d if a or b is NaN
};

// Number of operands that are values.
[[nodiscard]] constexpr int operands_of(Op op) {
  switch (op) {
    case Op::load:
    case Op::constant:
      return 0;
    case Op::square_root:
    case Op::absolute:
    case Op::round:
      return 1;
    case Op::fma:
    case Op::fnma:
    case Op::fms:
      return 3;
    case Op::select:
      return 4;
    default:
      return 2;
  }
}

// Memory of a step. Each slot holds one number for each lane.
enum class Memory : std::uint8_t {
  coefficients,  // of the equations
  inputs,
  input_rates,
  input_accelerations,
  unknowns,  // predicted, and at the end solved
  rates,
  accelerations,
  pivots,    // order of rows
  anchor,    // coordinates at the centre of the ball
  omega,     // of the ball
  settings,  // bounds
  work,      // from phase to phase
  figures,   // what the step tells about itself
};
inline constexpr std::size_t kMemories = 13;

struct Slot {
  Memory memory = Memory::work;
  std::uint32_t index = 0;

  friend bool operator==(const Slot&, const Slot&) = default;
};

struct Instruction {
  Op op = Op::constant;
  std::array<std::uint32_t, 4> operand = {};  // instructions before it in the phase; of a constant its index
  Slot slot;                                  // of a load
};

// Instructions in order, then stores. Loads see the memory before the stores of their phase.
struct Phase {
  struct Store {
    Slot to;
    std::uint32_t value;
  };

  std::vector<Instruction> code;
  std::vector<double> constants;
  std::vector<Store> stores;
  // The phase is repeated as long as this slot is positive in a lane; without one, it runs once.
  std::optional<Slot> repeat_while;
};

struct StepProgram {
  std::vector<Phase> phases;
};

}  // namespace assur
