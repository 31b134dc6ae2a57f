// The ordinary step of a small group (program/group_step.hpp) in registers: by machine code where there is some, else
// by kernels, with the same bits. If anything is unusual, GroupSolver solves the step again.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "executors/step_code.hpp"
#include "groups/branch.hpp"
#include "groups/pack.hpp"
#include "groups/workspace.hpp"

namespace assur {

// Results of a step. W numbers are valid until the next run.
struct SmallStepFigures {
  // Largest relative residuals; run() raises them if no lane fails.
  double position = 0, velocity = 0, acceleration = 0;
  const double *iterations = nullptr, *ball_used = nullptr, *needs_anchor = nullptr;  // W
  const double* failed = nullptr;  // W: 0, or 1 where the general path must solve the step
  // Of a class step: reciprocal scales of the equations, n x W, and the largest entry of the first correction, W.
  const double *weights = nullptr, *first_correction = nullptr;
  bool balls_last = true;  // no lane needs another anchor before its next step
};

// Makes new anchors after a step.
class AnchorStep {
 public:
  virtual ~AnchorStep() = default;

  // After a step of this pack in which no lane failed: see renew_anchors() (program/anchor-inl.hpp). time: of the step,
  // s. Returns W numbers, positive for lanes that need an anchor and have none.
  [[nodiscard]] virtual const double* renew_anchors(Pack& pack, double* const (&state)[3], double time) = 0;
};

// The step of the packs of one class.
class SmallStep : public AnchorStep {
 public:
  // Tries the step. state[d]: d-th derivative of all coordinates, with the prediction in the unknowns of the pack.
  // True: the unknowns are solved by the rules of GroupSolver, to relative residuals of at most `converged`. False: the
  // factorisation, the convergence or the Kantorovich number of some lanes is unusual; their prediction is unchanged,
  // and the derivatives of their unknowns are unspecified. The other lanes are solved.
  [[nodiscard]] virtual bool run(const Pack& pack, double* const (&state)[3], int most_iterations, double converged,
                                 SmallStepFigures& figures) = 0;
};

// By kernels, or by the interpreter if this processor has no SIMD. Null for a class that has no group_step(). All must
// outlive the step.
[[nodiscard]] std::unique_ptr<SmallStep> make_small_step(const Workspace& work, const BlockConditions& blocks);
[[nodiscard]] std::unique_ptr<SmallStep> make_interpreted_step(const Workspace& work, const BlockConditions& blocks);
// By machine code, for a class that has a group_step(). Null if there is none.
[[nodiscard]] std::unique_ptr<SmallStep> make_coded_step(const Workspace& work, const BlockConditions& blocks,
                                                         StepCode& code);
// Runs Pack::machine_code of a class that has a class_step(). Where a lane fails, all lanes must be solved again. The
// test of the first correction is left to the general path.
[[nodiscard]] std::unique_ptr<SmallStep> make_class_step(const Workspace& work);

}  // namespace assur
