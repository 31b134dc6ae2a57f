// The step of a pack: the position by Newton's method; velocity and acceleration by one factorisation, or by two with
// `+separate`.
#pragma once

#include <cstdint>

#include "group/attempt.hpp"
#include "group/branch_guard.hpp"
#include "group/jacobian_solver.hpp"
#include "group/workspace.hpp"

namespace assur {

// The step of the packs of one class.
class NewtonStep {
 public:
  NewtonStep(Workspace& work, JacobianSolver& solver, BranchGuard& guard, const SolverSettings& settings);

  // Solves the position. The inputs must be set; x is the prediction and becomes the solution, unspecified on failure.
  [[nodiscard]] Status position(Pack& pack, double* x, const Attempt& attempt, Counters& counters, StepErrors& errors);

  // Solves rates and accelerations of the unknowns at the posture of position(), as far as the class or the attempt
  // needs them. state[d]: d-th derivative of all coordinates.
  [[nodiscard]] Status derivatives(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters,
                                   StepErrors& errors);

  // The relative residual of a posture.
  [[nodiscard]] double residual_of(const Pack& pack, const double* state);

 private:
  using Factors = JacobianSolver::Factors;

  [[nodiscard]] std::int32_t lane_with_most_left(const Pack& pack);
  // The lane with the largest last correction.
  [[nodiscard]] std::int32_t lane_that_moved_most(const Pack& pack) const {
    return work_.lane_with_most(pack, work_.correction);
  }
  [[nodiscard]] double raised_ratio();
  [[nodiscard]] double correct(double* x);

  Workspace& work_;
  JacobianSolver& solver_;
  BranchGuard& guard_;
  const SolverSettings settings_;
  LaneArray inverse_scale_, correction_;  // n x W
};

}  // namespace assur
