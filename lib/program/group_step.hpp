// The step of a group with a few unknowns as a program: Newton's method, velocity, acceleration and the branch test.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "assur/structure.hpp"
#include "equations/program.hpp"
#include "program/step_program.hpp"

namespace assur {

// Bounds in Memory::settings.
enum class GroupSetting : std::uint32_t {
  converged_at,     // relative residual at which the equations count as solved
  most_iterations,  // of Newton's method
  ball_used,        // before the step
};
inline constexpr std::size_t kGroupSettings = 3;

// What each lane tells in Memory::figures.
enum class GroupFigure : std::uint32_t {
  failed,        // 0: solved; else positive, and the general path must solve the step again
  iterations,    // of Newton's method
  position,      // largest relative residuals
  velocity,      // of the linear system
  acceleration,  // of the linear system
  ball_used,     // omega |coordinates - anchor|
  needs_anchor,  // 1: the next step may leave the ball
};
inline constexpr std::size_t kGroupFigures = 7;

[[nodiscard]] constexpr Slot slot_of(GroupSetting s) { return {Memory::settings, static_cast<std::uint32_t>(s)}; }
[[nodiscard]] constexpr Slot slot_of(GroupFigure f) { return {Memory::figures, static_cast<std::uint32_t>(f)}; }

// A step program, and how many numbers it keeps in Memory::work.
struct GroupProgram {
  StepProgram program;
  std::uint32_t work = 0;
};

// True for classes of two or three unknowns, all wanted, in one irreducible block of quadratic equations.
[[nodiscard]] bool has_group_step(const GroupClass& group_class);
// Numbers in Memory::pivots.
[[nodiscard]] std::size_t pivots_of_group_step(const GroupClass& group_class);

// For a class that has_group_step(). reads: coordinates of the branch test, as registers of `equations`.
// Memory::unknowns holds the prediction, and the solution where the step does not fail. Rows k and i > k are swapped
// before column k is eliminated where the pivot of this pair is positive.
[[nodiscard]] GroupProgram group_step(const GroupClass& group_class, const Program& equations,
                                      std::span<const std::int32_t> reads);

}  // namespace assur
