// The step of a group, or of a mechanism, as data: phases of operations on values in single assignment, without control
// flow, pointers or widths. Every lane computes and decides for itself, so its bits depend neither on the executor nor
// on its neighbours.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace assur {

// a, b, c, d: operands, in this order. A new operation also needs operands_of() and kLastOp, its function in
// step_graph.hpp, its value for constants, fold(), and `commutes` if a and b may change places (step_graph.cpp), both
// executors (interpreter.cpp, machine_code.cpp), and apply() in executors_test.cpp.
enum class Op : std::uint8_t {
  load,         // number in a slot
  pick,         // number a places behind a slot, for a whole a, all lanes from the same memory (Reach::one); the phase
                // stores nothing there
  constant,     // the same number in all lanes
  add,          // a + b
  subtract,     // a - b
  multiply,     // a b
  divide,       // a / b
  fma,          // a b + c, rounded once
  fnma,         // c - a b, rounded once
  square_root,  // of a
  absolute,     // |a|
  copy_sign,    // |a| with the sign of b
  round,        // a to the nearest integer, halves to even
  larger,       // a > b ? a : b; the second if one is NaN
  select,       // a <= b ? c : d; d if a or b is NaN
};
inline constexpr Op kFirstArithmetic = Op::add, kLastOp = Op::select;

// Number of operands that are values.
[[nodiscard]] constexpr int operands_of(Op op) {
  switch (op) {
    case Op::load:
    case Op::constant:
      return 0;
    case Op::pick:
    case Op::square_root:
    case Op::absolute:
    case Op::round:
      return 1;
    case Op::fma:
    case Op::fnma:
      return 3;
    case Op::select:
      return 4;
    case Op::add:
    case Op::subtract:
    case Op::multiply:
    case Op::divide:
    case Op::copy_sign:
    case Op::larger:
      return 2;
  }
  return 0;
}

// Memory of a step.
enum class Memory : std::uint8_t {
  // of a group
  coefficients,  // of the equations
  inputs,
  input_rates,
  input_accelerations,
  unknowns,  // predicted, and at the end solved
  rates,
  accelerations,
  anchor,     // coordinates at the centre of the ball
  omega,      // of the ball
  ball_used,  // part of it, before the step
  lipschitz,  // of the equations
  anchor_rates,
  anchor_time,  // s; NaN: without rates
  settings,     // bounds
  work,         // from phase to phase
  figures,      // what the step tells about itself
  // of groups that are solved together with those of other levels (program/together_step.hpp)
  own,        // changes of the unknowns, alone
  couplings,  // of equations with inputs that other groups compute
  change,     // of the unknowns, with all loads
  sources,    // changes of inputs
  loads,      // of coupled rows
  // of a mechanism
  state,  // coordinates at the end of the step, by address
  state_rates,
  state_accelerations,
  laws,
  law_rates,
  law_accelerations,
  sines,  // of the laws that are angles
  cosines,
  factors,  // of sums
  weights,  // of the prediction
  undefined,
  outputs,  // by column
  past,     // what the weights multiply, in kMostPast memories
};
inline constexpr std::size_t kMostPast = 6;  // past:5, or two postures with two derivatives
// Changes of the unknowns for a load of 1, in a memory for each coupled row.
inline constexpr std::size_t kMostCoupledRows = 3;  // equations of a group
inline constexpr std::size_t kColumns = static_cast<std::size_t>(Memory::past) + kMostPast;
inline constexpr std::size_t kMemories = kColumns + kMostCoupledRows;

// Where the number of a lane lies in a memory, for an index i and W lanes.
enum class Reach : std::uint8_t {
  row,        // i W + lane
  from,       // i + lane
  one,        // i: the same for all lanes; the first lane stores its number
  scattered,  // StepProgram::addresses[i + lane]; for loads only
};

struct Slot {
  Memory memory = Memory::work;
  std::uint32_t index = 0;
  Reach reach = Reach::row;
  std::uint16_t group = 0;  // of a mechanism: each has its own memories

  friend auto operator<=>(const Slot&, const Slot&) = default;
};
// The place of a slot's memory among those of all groups.
[[nodiscard]] constexpr std::size_t memory_of(const Slot& s) {
  return s.group * kMemories + static_cast<std::size_t>(s.memory);
}

struct Instruction {
  Op op = Op::constant;
  std::array<std::uint32_t, 4> operand = {};  // instructions before it in the phase; of a constant its index
  Slot slot;                                  // of a load or a pick

  friend bool operator==(const Instruction&, const Instruction&) = default;
};

// Instructions in order, then stores. Loads see the memory before the stores of their phase, which must not store what
// it loads by another reach, nor a number by two slots.
struct Phase {
  struct Store {
    Slot to;
    std::uint32_t value;

    friend bool operator==(const Store&, const Store&) = default;
  };

  std::vector<Instruction> code;
  std::vector<double> constants;
  std::vector<Store> stores;
  // The phase is repeated as long as this slot is positive in a lane; without one, it runs once.
  std::optional<Slot> repeat_while;
  int lanes = 0;  // W of this phase: 1, 2, 4, or a multiple of 8; 0: that of the executor

  friend bool operator==(const Phase&, const Phase&) = default;
};

struct StepProgram {
  std::vector<Phase> phases;
  std::vector<std::int32_t> addresses = {};

  friend bool operator==(const StepProgram&, const StepProgram&) = default;
};

}  // namespace assur
