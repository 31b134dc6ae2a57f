// The ordinary step of a small group, all of it in registers: Newton, velocity, acceleration and the branch check
// without a call in between. Whatever is not ordinary is left to GroupSolver, which then solves the step anew.
#pragma once

#include <memory>

#include "assur/structure.hpp"
#include "equations/program.hpp"
#include "group/branch.hpp"
#include "group/pack.hpp"

namespace assur {

struct SmallStepFigures {
  int iterations = 0;
  // Relative residuals: the worst so far, before and after.
  double position = 0, velocity = 0, acceleration = 0;
  double ball_used = 0;
};

class SmallStep {
 public:
  virtual ~SmallStep() = default;

  // The order of the pack's rows in each lane, from a posture; run() needs one. The first one takes memory.
  virtual void choose_pivots(Pack& pack, const double* state) = 0;

  // state[d]: d-th derivative of all coordinates, with the prediction in the pack's unknowns. True: they are solved, by
  // the same rules as in GroupSolver, where their relative residuals are at most `converged`. False: the factorisation,
  // the convergence or the Kantorovich number of some lane is not as usual; the prediction is as before, the
  // derivatives of the unknowns are unspecified.
  [[nodiscard]] virtual bool run(const Pack& pack, double* const (&state)[3], int most_iterations, double converged,
                                 SmallStepFigures& figures) = 0;
};

// Null if the class has none: 2 or 3 unknowns, all wanted, of one irreducible block of separable equations; 8 lanes.
// `program` and `blocks` must outlive it.
[[nodiscard]] std::unique_ptr<SmallStep> make_small_step(const GroupClass& group_class, const Program& program,
                                                         const BlockConditions& blocks, int lanes);

}  // namespace assur
