// The step of a group with a few unknowns as a program: Newton's method, velocity, acceleration and the branch test.
#pragma once

#include <cstdint>
#include <span>

#include "assur/structure.hpp"
#include "equations/program.hpp"
#include "program/step_program.hpp"

namespace assur {

// Settings of the step.
enum GroupSetting : std::uint32_t {
  kConvergedAt,  // relative residual at which the equations count as solved
  kMostIterations,
  kLargestFirst,  // omega |first correction|
  kGroupSettings,
};

// What each lane tells.
enum GroupFigure : std::uint32_t {
  kFailed,  // 0: solved; else positive, and the general path must solve the step again
  kIterations,
  kPosition,  // relative residuals
  kVelocity,
  kAcceleration,
  kBallUsed,  // omega |coordinates - anchor|
  kGroupFigures,
};

// Numbers in Memory::work and Memory::pivots.
[[nodiscard]] std::uint32_t work_of_group_step(const Program& equations);
[[nodiscard]] std::uint32_t pivots_of_group_step(const Program& equations);

// reads: coordinates of the branch test, as registers of `equations`. The rules are those of step_rules.hpp and of
// NewtonStep. Memory::unknowns holds the prediction and keeps it: solved unknowns are the first slots of Memory::work.
// A pivot above 0 swaps two rows; see SmallLu.
[[nodiscard]] StepProgram group_step(const GroupClass& group_class, const Program& equations,
                                     std::span<const std::int32_t> reads);

}  // namespace assur
