// The step of a pack: the position by Newton's method; velocity and acceleration by one factorisation, or by two with
// `+separate`.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "groups/attempt.hpp"
#include "groups/branch_guard.hpp"
#include "groups/jacobian_solver.hpp"
#include "groups/workspace.hpp"

namespace assur {

// The step of the packs of one class.
class NewtonStep {
 public:
  NewtonStep(Workspace& work, JacobianSolver& solver, BranchGuard& guard, const SolverSettings& settings);

  // Solves the position. The inputs must be set; x is the prediction and becomes the solution, unspecified on failure.
  // A lane whose equations are solved keeps its unknowns, so that they do not depend on its neighbours as long as each
  // factorisation is fresh. solved: W, 1 where x is solved already.
  [[nodiscard]] Status position(Pack& pack, double* x, const Attempt& attempt, std::span<const std::uint8_t> solved,
                                Counters& counters, StepErrors& errors);

  // Solves rates and accelerations of the unknowns at the posture of position(), as far as the class or the attempt
  // needs them. state[d]: d-th derivative of all coordinates.
  [[nodiscard]] Status derivatives(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters,
                                   StepErrors& errors);

  // The relative residual of a posture. weights: n x W, reciprocal scales of the equations that position() would use;
  // null: those of the posture.
  [[nodiscard]] double residual_of(const Pack& pack, const double* state, const double* weights = nullptr);

 private:
  using Factors = JacobianSolver::Factors;

  [[nodiscard]] std::int32_t lane_with_most_left(const Pack& pack);
  // The lane with the largest last correction.
  [[nodiscard]] std::int32_t lane_that_moved_most(const Pack& pack) const {
    return work_.lane_with_most(pack, work_.correction);
  }
  void measure();
  void raise(std::span<const std::uint8_t> lanes);
  [[nodiscard]] double largest_open() const;
  [[nodiscard]] bool close(double converged, bool rounds);
  [[nodiscard]] bool corrections_contract(bool is_first);
  [[nodiscard]] double correct(double* x);

  Workspace& work_;
  JacobianSolver& solver_;
  BranchGuard& guard_;
  const SolverSettings settings_;
  LaneArray inverse_scale_, correction_;  // n x W
  LaneArray ratios_, before_;             // W: relative residuals, now and before the last correction
  LaneArray last_;                        // W: largest entry of the last correction
  std::vector<std::uint8_t> open_;        // W: 1 as long as the lane iterates
};

}  // namespace assur
