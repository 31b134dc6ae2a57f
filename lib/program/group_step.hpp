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
  largest_first,    // omega |first correction|
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
};
inline constexpr std::size_t kGroupFigures = 6;

[[nodiscard]] constexpr Slot slot_of(GroupSetting s) { return {Memory::settings, static_cast<std::uint32_t>(s)}; }
[[nodiscard]] constexpr Slot slot_of(GroupFigure f) { return {Memory::figures, static_cast<std::uint32_t>(f)}; }

// Numbers in Memory::work and Memory::pivots.
[[nodiscard]] std::uint32_t work_of_group_step(const Program& equations);
[[nodiscard]] std::uint32_t pivots_of_group_step(const Program& equations);

// reads: coordinates of the branch test, as registers of `equations`. The rules are those of step_rules.hpp and of
// NewtonStep. Memory::unknowns holds the prediction and keeps it: solved unknowns are the first slots of Memory::work.
// A pivot above 0 swaps two rows; see SmallLu.
[[nodiscard]] StepProgram group_step(const GroupClass& group_class, const Program& equations,
                                     std::span<const std::int32_t> reads);

}  // namespace assur
