// Closing a drawing: the unknowns of a class go from values with which its equations are open to those to which the
// equations close if they all close in proportion (structure/walk.hpp), in one step of that walk. Its proof is part of
// the program: for every share of the way there is exactly one posture in a ball around the chord, because the
// equations are quadratic (Newton-Kantorovich).
#pragma once

#include <cstddef>

#include "backends/lanes_elimination.hpp"
#include "equations/program.hpp"
#include "program/step_program.hpp"

namespace assur {

// What the closing of a class reads and writes: rows of lanes, an array for each.
struct ClosingSlots {
  static constexpr Memory drawn = Memory::unknowns;            // the drawing; unchanged
  static constexpr Memory inputs = Memory::inputs;             // where they are when all is closed
  static constexpr Memory drawn_inputs = Memory::input_rates;  // in the drawing
  // How far each input may leave the chord between both.
  static constexpr Memory strays = Memory::input_accelerations;
  static constexpr Memory closed = Memory::rates;          // receives the unknowns
  static constexpr Memory stray = Memory::accelerations;   // one row: how far each of them may leave its chord
  static constexpr Memory open = Memory::figures;          // one row: 0 if all is proven
};

// Numbers in Memory::work.
[[nodiscard]] inline std::size_t work_of_closing_step(const Program& equations) {
  return static_cast<std::size_t>(equations.n) + 4;
}

// For classes without functions and gears.
[[nodiscard]] StepProgram closing_step(const Program& equations, const lanes::Elimination& elimination);

}  // namespace assur
