// The ordinary step of a small group, all of it in registers: Newton's method, velocity, acceleration and the branch
// test, without function calls. If anything is unusual, GroupSolver solves the step again.
#pragma once

#include <memory>

#include "assur/structure.hpp"
#include "equations/program.hpp"
#include "group/branch.hpp"
#include "group/pack.hpp"

namespace assur {

// Results of a step.
struct SmallStepFigures {
  int iterations = 0;
  // Relative residuals: the largest so far; run() raises them.
  double position = 0, velocity = 0, acceleration = 0;
  double ball_used = 0;
};

// The step of the packs of one class.
class SmallStep {
 public:
  virtual ~SmallStep() = default;

  // Chooses the order of the rows in each lane at a posture, which the workspace of GroupSolver has evaluated; run()
  // needs it. The first call allocates memory.
  virtual void choose_pivots(Pack& pack, const double* state) = 0;

  // Tries the step. state[d]: d-th derivative of all coordinates, with the prediction in the unknowns of the pack.
  // True: the unknowns are solved by the rules of GroupSolver, to relative residuals of at most `converged`. False: the
  // factorisation, the convergence or the Kantorovich number of a lane is unusual; the prediction is unchanged, and the
  // derivatives of the unknowns are unspecified.
  [[nodiscard]] virtual bool run(const Pack& pack, double* const (&state)[3], int most_iterations, double converged,
                                 SmallStepFigures& figures) = 0;
};

// A SmallStep for a class with 2 or 3 unknowns, all wanted, in one irreducible block of separable equations, and for at
// most 8 lanes; else null. Null on processors without SIMD. `program` and `blocks` must outlive it.
[[nodiscard]] std::unique_ptr<SmallStep> make_small_step(const GroupClass& group_class, const Program& program,
                                                         const BlockConditions& blocks, int lanes);

}  // namespace assur
