// Solves the packs of one group class: a step of Newton's method within the guard of its branch, or the same in
// registers where the group is small.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "assur/plan.hpp"
#include "group/attempt.hpp"
#include "group/branch_guard.hpp"
#include "group/error_probe.hpp"
#include "group/jacobian_solver.hpp"
#include "group/newton_step.hpp"
#include "group/singularity.hpp"
#include "group/small_step.hpp"
#include "group/workspace.hpp"

namespace assur {

class GroupSolver {
 public:
  // Throws Error (environment) if the backend cannot run here.
  GroupSolver(const System& system, const Structure& structure, std::int32_t group_class, const Plan::Choice& choice,
              std::span<const Backend> table);

  [[nodiscard]] int lanes() const { return work_.lanes; }
  [[nodiscard]] const Program& program() const { return work_.program; }
  [[nodiscard]] bool quadratic() const { return work_.group_class.quadratic; }

  // Drops what an earlier run left behind, so that runs repeat bit for bit; the packs drop their own solvers. The next
  // solve() of each pack makes its solver: the first one chooses the pivots, the others start from them.
  void restart() { solver_.restart(); }

  // What the solver that all packs share did, and what had to be refined after any; each pack's own one tells for
  // itself.
  [[nodiscard]] Effort effort() const { return solver_.effort(); }

  // Makes room in the pack for what it holds of this class.
  void size(Pack& pack) const;
  // One lane of the pack is `group`, with the constants of `system`.
  void bind_lane(const System& system, const Group& group, Pack& pack, int lane) const;

  // state[d]: d-th derivative of all coordinates, with the prediction in the pack's unknowns.
  // On failure `where` is the group and the pack's unknowns are unspecified.
  [[nodiscard]] Status solve(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters,
                             StepErrors& errors);

  // The block of a pack that is nearest to a singular posture (dense SVD; allocates).
  [[nodiscard]] Singularity diagnose(const Pack& pack, double* const (&state)[3]) {
    return nearest_singularity(work_, guard_.blocks(), pack, state);
  }

  // Of a posture that is solved: see ErrorProbe.
  [[nodiscard]] bool perturb(Pack& pack, const double* const (&state)[3], Probes probes, std::uint64_t seed) {
    return probe_.perturb(pack, state, probes, seed);
  }
  [[nodiscard]] GroupHealth examine(Pack& pack, const double* state) { return probe_.examine(pack, state); }

 private:
  // The ordinary step of a small group; false if it is none.
  [[nodiscard]] bool small_step(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters,
                                StepErrors& errors, Status& status);

  Workspace work_;
  JacobianSolver solver_;
  BranchGuard guard_;
  NewtonStep step_;
  ErrorProbe probe_;
  std::unique_ptr<SmallStep> small_step_;  // null: the class, or the strategy, has none
};

}  // namespace assur
