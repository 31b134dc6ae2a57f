// Solves the packs of one group class: Newton's method under the guard of the branch. Small groups do the same in
// registers, by machine code where there is some.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "assur/plan.hpp"
#include "executors/step_code.hpp"
#include "groups/attempt.hpp"
#include "groups/branch_guard.hpp"
#include "groups/error_probe.hpp"
#include "groups/jacobian_solver.hpp"
#include "groups/newton_step.hpp"
#include "groups/singularity.hpp"
#include "groups/small_step.hpp"
#include "groups/workspace.hpp"

namespace assur {

// Solver of one class.
class GroupSolver {
 public:
  // Throws Error (environment) if the backend cannot run here.
  GroupSolver(const System& system, const GroupedSystem& structure, std::int32_t group_class,
              const Plan::Choice& choice, std::span<const Backend> table);
  // Takes ordinary steps by machine code, if there is some for them, with the same bits.
  void use(StepCode& code);
  [[nodiscard]] bool is_coded(const Pack& pack) const { return is_coded_ || pack.machine_code.step != nullptr; }

  [[nodiscard]] int lanes() const { return work_.lanes; }
  [[nodiscard]] const GroupClass& group_class() const { return work_.group_class; }
  [[nodiscard]] const BlockConditions& blocks() const { return guard_.blocks(); }

  // Forgets earlier runs, so that runs repeat bit for bit; the packs must drop their own solvers. The next solve() of
  // each pack makes a solver, see JacobianSolver::restart().
  void restart(bool alike = true) { solver_.restart(alike); }

  // Extra work of the solver that all packs share, and refinements of all packs. Pack::solver counts its own work.
  [[nodiscard]] Effort effort() const { return solver_.effort(); }

  // Allocates the arrays of a pack of this class.
  void size(Pack& pack) const;
  // Gives the lanes of the pack their groups; of(lane): a pair of the system and the group.
  template <class Of>
  void bind(Pack& pack, const Of& of) {
    const auto w = static_cast<std::size_t>(work_.lanes);
    for (std::size_t lane = 0; lane < w; ++lane) {
      const auto& [system, group] = of(lane);
      constants_.resize(group.constants.size() * w);
      for (std::size_t k = 0; k < group.constants.size(); ++k) {
        constants_[k * w + lane] = system.constants[static_cast<std::size_t>(group.constants[k])];
      }
    }
    bind_coefficients(work_.group_class, constants_.data(), pack.coefficients.data(), w);
    lipschitz(work_.group_class, pack.coefficients.data(), pack.lipschitz.data(), w);
  }

  // Solves the pack at one time. state[d]: d-th derivative of all coordinates; the unknowns of the pack hold the
  // prediction and become the solution. If it fails, Status::where is the group, and the unknowns are unspecified.
  [[nodiscard]] Status solve(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters,
                             StepErrors& errors);

  // The block of a pack that is nearest to a singular posture; the memory must be reserved for it.
  void diagnose(const Pack& pack, double* const (&state)[3], DiagnosisMemory& memory, Singularity& into) {
    nearest_singularity(work_, guard_.blocks(), pack, state, memory, into);
  }
  void reserve(DiagnosisMemory& memory) const { memory.reserve(work_, guard_.blocks()); }

  // True if a step of the whole mechanism may take the place of small steps (motion/whole_step.hpp).
  [[nodiscard]] bool has_small_step() const { return small_step_ != nullptr; }
  // After a small step that did not fail: counts its work, and makes new anchors where that is necessary.
  [[nodiscard]] Status finish_small_step(Pack& pack, double* const (&state)[3], const Attempt& attempt,
                                         const SmallStepFigures& figures, AnchorStep& anchors, Counters& counters,
                                         StepErrors& errors);
  // For a pack that another step solved: makes the posture of each lane whose next step may leave its ball the anchor.
  // Fails if a posture is not known to be on the branch.
  [[nodiscard]] Status renew_anchor(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters);
  // Relative residual of a solved pack, as exactly as it can be measured.
  [[nodiscard]] double residual_of(const Pack& pack, const double* state) { return step_.residual_of(pack, state); }
  // The nonzeros of the Jacobian of a pack x W, until the next call.
  [[nodiscard]] const LaneArray& jacobian(const Pack& pack, const double* state) {
    work_.set_inputs(pack, state);
    work_.evaluate(state + pack.unknowns);
    return work_.jacobian;
  }

  // ErrorProbe at a solved posture.
  [[nodiscard]] bool perturb(Pack& pack, const double* const (&state)[3], Probes probes, const Unseen& unseen,
                             std::uint64_t seed) {
    return probe_.perturb(pack, state, probes, unseen, seed);
  }
  void perturb(const Pack& pack, const ChangePointPosture& posture, const double* const (&state)[3], Probes probes,
               std::uint64_t seed) {
    probe_.perturb(pack, posture, state, probes, seed);
  }
  [[nodiscard]] bool follow(Pack& pack, const double* posture, std::span<double* const> changes) {
    return probe_.follow(pack, posture, changes);
  }
  [[nodiscard]] GroupHealth examine(Pack& pack, const double* state) { return probe_.examine(pack, state); }

 private:
  [[nodiscard]] Status use_change_point(const ChangePointPosture& posture, const Pack& pack, double* const (&state)[3],
                                        Counters& counters, StepErrors& errors);
  // Tries the step in registers. False if the step cannot be made so, or if lanes fail; results of other lanes are
  // kept.
  [[nodiscard]] bool small_step(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters,
                                StepErrors& errors, Status& status);
  // True if small steps can make this attempt.
  [[nodiscard]] bool serves(const Attempt& attempt) const {
    return attempt.iterations == 0 && (!attempt.all_rates || work_.group_class.derivatives > 0);
  }
  // Tries the step by Pack::machine_code. False if there is none, or if a lane fails.
  [[nodiscard]] bool class_step(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters,
                                StepErrors& errors, Status& status);
  [[nodiscard]] bool is_near(const Pack& pack, const double* state, const double* first_correction);
  void find_code(Pack& pack, bool makes);
  void count_small_step(const Pack& pack, const double* iterations, Counters& counters) const;
  void solve_in_lanes(Pack& pack, double* const (&state)[3], const Attempt& attempt, StepErrors& errors);
  void keep(const Pack& pack, double* const (&state)[3]);
  void take_kept(const Pack& pack, double* const (&state)[3]) const;

  Workspace work_;
  JacobianSolver solver_;
  BranchGuard guard_;
  NewtonStep step_;
  ErrorProbe probe_;
  std::unique_ptr<SmallStep> small_step_;  // null if the class or the strategy allows none
  std::array<LaneArray, 3> kept_;          // [d]: derivatives of the unknowns, n x W
  bool is_coded_ = false;
  std::unique_ptr<SmallStep> class_step_;  // null if the class or the strategy allows none
  StepCode* code_ = nullptr;               // makes Pack::machine_code
  std::vector<std::uint8_t> is_kept_;      // W: lanes whose results are kept_
  LaneArray predicted_;                    // unknowns before the step, n x W
  LaneArray omega_, most_;                 // W: see solve_in_lanes() and class_step()
  std::vector<double> constants_;          // of the groups of a pack, x W
};

}  // namespace assur
