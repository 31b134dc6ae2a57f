// The step of a group of any size as a program: the operations of the general path (groups/newton_step.hpp) where a
// step is ordinary, one by one and in the same order, so that both have the same bits. Its linear systems are solved by
// the pivots that the backend `lanes` has chosen. Where anything is unusual, a lane fails, and the general path must
// solve the step.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "backends/lanes_elimination.hpp"
#include "evaluation/coefficients.hpp"
#include "program/group_step.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

// True for classes in one irreducible block, without functions, that have rates and no group_step().
[[nodiscard]] bool has_class_step(const GroupClass& group_class);
// False if its programs are certainly longer than `most` instructions.
[[nodiscard]] bool is_short(const lanes::Elimination& elimination, std::size_t most);

// Numbers in Memory::work. It begins with the reciprocal scales of the equations; the last number is the largest entry
// of Newton's first correction, which the caller must test, see BranchGuard. Without a ball, because the equations are
// not quadratic, each correction must contract instead.
[[nodiscard]] constexpr std::size_t work_of_class_step(const GroupClass& group_class) {
  return 2 * static_cast<std::size_t>(group_class.n) + 5;
}

// reads: see group_step(). Memory::unknowns holds the prediction, and then the solution. GroupFigure::failed is
// positive where the step is unusual; results are then unspecified.
[[nodiscard]] StepProgram class_step(const GroupClass& group_class, const lanes::Elimination& elimination,
                                     std::span<const std::int32_t> reads);

// The factors of the Jacobian at a posture, in Memory::work, for class_changes(). GroupFigure::failed as above.
[[nodiscard]] StepProgram class_factors(const GroupClass& group_class, const lanes::Elimination& elimination);
// Changes of the unknowns, in Memory::rates, that follow from changes of the inputs, in Memory::input_rates, to first
// order: J dq = -Phi_h dh. GroupFigure::failed is raised.
[[nodiscard]] StepProgram class_changes(const GroupClass& group_class, const lanes::Elimination& elimination);
// What follows a step after which a lane needs an anchor, if the equations are quadratic: see anchor_program().
[[nodiscard]] StepProgram class_anchor(const GroupClass& group_class, const lanes::Elimination& elimination,
                                       std::span<const std::int32_t> reads);

// Numbers that class_factors() and class_changes() have in Memory::work, at most.
[[nodiscard]] std::size_t work_of_changes(const GroupClass& group_class);

}  // namespace assur
