// Computes the numbers of a tape for other values of its parameters, for several members side by side.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "scene/expression.hpp"
#include "scene/tape.hpp"

namespace assur {

// An operation of a replay on numbers of earlier steps.
struct ReplayStep {
  Tape::Kind kind;
  std::uint32_t a, b, c;  // steps; parameter: a, formula: b is the index
};

// Computes steps `from` to `to`, which are neither literals nor formulas. numbers: steps x lanes.
using ComputeSteps = void (*)(std::span<const ReplayStep> steps, std::size_t from, std::size_t to,
                              std::span<const double* const> parameters, double* numbers);

// off: lanes; receives 0 if all guards have their outcomes and all numbers that are compared or wanted are finite, else
// another number or NaN.
using CheckSteps = void (*)(std::span<const Tape::Guard> guards, std::span<const std::uint32_t> wanted,
                            const double* numbers, double* off);

// For one number of lanes: 4, 8 or 16.
struct ReplayKernels {
  ComputeSteps compute;
  CheckSteps check;
};

class Replay {
 public:
  // lanes: largest number of members at once; wanted: nodes whose values are asked for.
  Replay(const Tape& tape, std::span<const Tape::Node> wanted, std::size_t lanes);

  // Computes the wanted numbers of the members; parameters[l]: those of lane l.
  void run(std::span<const double* const> parameters);
  // The wanted number i of each lane.
  [[nodiscard]] const double* wanted(std::size_t i) const { return &numbers_[wanted_[i] * lanes_]; }
  // False if the recorded computation would have gone another way for the member, or if a number is not finite.
  [[nodiscard]] bool holds(std::size_t lane) const { return off_[lane] == 0; }

 private:
  void evaluate_formula(const ReplayStep& step, double* out, std::size_t used);
  std::size_t lanes_;
  ReplayKernels kernels_;
  std::vector<ReplayStep> steps_;
  std::vector<std::size_t> formula_steps_;  // ascending
  std::vector<double> numbers_;             // steps x lanes
  std::vector<std::uint32_t> wanted_;       // steps
  std::vector<Tape::Guard> guards_;         // of steps
  std::vector<Formula> formulas_;
  std::vector<std::vector<std::uint32_t>> arguments_;  // of the formulas: steps
  std::vector<double> arguments_at_hand_;
  std::vector<const double*> parameters_;  // lanes
  std::vector<double> off_;                // lanes, see CheckSteps
};

}  // namespace assur
