// A step of a walk (start/walk.hpp) as a program: the unknowns of a class follow their equations while the inputs
// move, or while open residuals shrink in proportion. The proof of the step is part of it: for every share of the way
// there is exactly one posture in a ball around the chord, because the equations are quadratic (Newton-Kantorovich).
#pragma once

#include <cstddef>

#include "backends/lanes_elimination.hpp"
#include "evaluation/coefficients.hpp"
#include "program/step_program.hpp"

namespace assur {

// What a step of a walk reads and writes: rows of lanes, an array for each.
struct WalkSlots {
  static constexpr Memory from = Memory::unknowns;            // where the unknowns are; unchanged
  static constexpr Memory inputs = Memory::inputs;            // where the inputs will be
  static constexpr Memory from_inputs = Memory::input_rates;  // where they are
  // How far each of them may leave the chord between both.
  static constexpr Memory strays = Memory::input_accelerations;
  static constexpr Memory aims = Memory::own;    // residuals of the equations in the end; now they have any
  static constexpr Memory to = Memory::rates;    // receives the unknowns
  static constexpr Memory open = Memory::loads;  // receives the residuals of the equations where the step begins
  static constexpr Memory stray = Memory::accelerations;  // one row: how far each of them may leave its chord
  // One row: the used part of the bound of the proof. There is none above kSurest; then all else is unspecified.
  static constexpr Memory used = Memory::figures;
};

// Numbers in Memory::work.
[[nodiscard]] inline std::size_t work_of_walk_step(const GroupClass& group_class) {
  return static_cast<std::size_t>(group_class.n) + 4;
}

// For classes without functions and gears. elimination: with pivots that serve on the way; of more than three unknowns
[[nodiscard]] StepProgram walk_step(const GroupClass& group_class, const lanes::Elimination& elimination);

}  // namespace assur
