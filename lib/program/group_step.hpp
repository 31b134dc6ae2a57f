// The step of a group with a few unknowns as a program: Newton's method, velocity, acceleration and the branch test.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "evaluation/coefficients.hpp"
#include "program/step_graph.hpp"
#include "program/step_program.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

// Bounds in Memory::settings, the same for all lanes.
enum class GroupSetting : std::uint32_t {
  converged_at,     // relative residual at which the equations count as solved
  most_iterations,  // of Newton's method
  corrections,      // so far, of groups that are solved together
  time,             // of the step, s; for new anchors
};
inline constexpr std::size_t kGroupSettings = 4;

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

[[nodiscard]] constexpr Slot slot_of(GroupSetting s) {
  return {Memory::settings, static_cast<std::uint32_t>(s), Reach::one};
}
[[nodiscard]] constexpr Slot slot_of(GroupFigure f) { return {Memory::figures, static_cast<std::uint32_t>(f)}; }

// A step program, and how many numbers it keeps in Memory::work.
struct GroupProgram {
  StepProgram program;
  std::uint32_t work = 0;
};

// True for classes of two or three unknowns, all wanted, in one irreducible block, without functions.
[[nodiscard]] bool has_group_step(const GroupClass& group_class);

// The begin of the step within a larger program.
struct GroupBegin {
  Graph& graph;         // the first phase is added to it
  std::uint16_t group;  // of all slots
  // [d]: d-th derivatives. Constants: read from Memory::inputs and so on, as all are in later phases
  std::array<std::vector<Value>, 3> inputs;
  std::vector<Value> unknowns;  // predicted
};

// For a class that has_group_step(). reads: coordinates of the branch test, as registers of `equations`.
// Memory::unknowns holds the prediction, and the solution where the step does not fail. begin: null for a step by
// itself
[[nodiscard]] GroupProgram group_step(const GroupClass& group_class, std::span<const std::int32_t> reads,
                                      const GroupBegin* begin = nullptr);

// What follows a step after which a lane needs an anchor, see renew_anchors() (program/anchor-inl.hpp). Inputs and
// figures are those of the step.
[[nodiscard]] StepProgram anchor_program(const GroupClass& group_class, std::span<const std::int32_t> reads);

}  // namespace assur
