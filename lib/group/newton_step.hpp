// The step of a pack: position by Newton, velocity and acceleration by one factorisation or, as `+separate` asks, two.
#pragma once

#include <cstdint>

#include "group/attempt.hpp"
#include "group/branch_guard.hpp"
#include "group/jacobian_solver.hpp"
#include "group/workspace.hpp"

namespace assur {

class NewtonStep {
 public:
  NewtonStep(Workspace& work, JacobianSolver& solver, BranchGuard& guard, const SolverSettings& settings);

  // The inputs are set, x is the prediction and becomes the solution. On failure it is unspecified.
  [[nodiscard]] Status position(Pack& pack, double* x, const Attempt& attempt, Counters& counters, StepErrors& errors);

  // At the posture of position(): rates and accelerations of the unknowns, as far as the class or the attempt wants
  // them. state[d]: d-th derivative of all coordinates.
  [[nodiscard]] Status derivatives(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters,
                                   StepErrors& errors);

  // The relative residual of a posture.
  [[nodiscard]] double residual_of(const Pack& pack, const double* state);

 private:
  using Factors = JacobianSolver::Factors;

  [[nodiscard]] std::int32_t lane_with_most_left(const Pack& pack) const;
  [[nodiscard]] double raised_ratio();
  [[nodiscard]] double correct(double* x);

  Workspace& work_;
  JacobianSolver& solver_;
  BranchGuard& guard_;
  const SolverSettings settings_;
  LaneArray inverse_scale_, correction_;  // n x W
};

}  // namespace assur
