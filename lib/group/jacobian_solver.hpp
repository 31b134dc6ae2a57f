// Systems with the Jacobian of a pack: factors of this posture or of an earlier one, solutions refined where those do
// not serve as they are.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "assur/backend.hpp"
#include "assur/plan.hpp"
#include "assur/simulator.hpp"
#include "group/workspace.hpp"

namespace assur {

class JacobianSolver {
 public:
  // Where the factors at hand are from.
  enum class Factors : std::uint8_t {
    earlier,   // an earlier step, if there are any: Pack::factored
    step,      // a posture of this step
    solution,  // the posture of the workspace, which solves the equations
  };

  // Throws Error (environment) if the backend cannot run here.
  JacobianSolver(const Workspace& work, const Plan::Choice& choice, std::span<const Backend> table);

  // Drops the solvers: the next of each pack is made anew. The first one chooses the pivots, the others start from
  // them.
  void restart();
  // The solver of a pack, or the one that all packs share, is at hand.
  void choose(Pack& pack);
  [[nodiscard]] LinearSolver* at_hand() { return solver_; }  // null: choose() was not called

  // What the solver that all packs share did, and what had to be refined after any.
  [[nodiscard]] Effort effort() const;

  // A new step begins.
  void begin_step() { factors_ = Factors::earlier; }
  [[nodiscard]] Factors factors() const { return factors_; }

  // Factorises the workspace's Jacobian. from: step or solution.
  [[nodiscard]] Status factorize(Pack& pack, Factors from, Counters& counters);
  // The same, uncounted, for what is no step.
  [[nodiscard]] bool factorize(Pack& pack);

  // x = J^-1 b by the factors at hand. checked: factors that grew are refined, which only those of J itself can be.
  [[nodiscard]] Status correction(Pack& pack, const LaneArray& b, double* x, bool checked, Counters& counters);

  // x = J^-1 b, from factors of whatever posture: refined to the relative residual `converged`, or, where that does not
  // help, by new factors. Unknowns before first_wanted are not wanted. error: raised to the normwise residual.
  [[nodiscard]] Status solve(Pack& pack, const LaneArray& b, double* x, int first_wanted, double converged,
                             Counters& counters, double& error);

  // The workspace's Jacobian is another one.
  void new_jacobian() { jacobian_measured_ = scales_measured_ = false; }

 private:
  // How far refinement goes.
  struct Goal {
    double enough;     // a residual
    double tolerated;  // a residual that ceases to fall
    bool scaled;       // the larger one of normwise and scaled
  };
  [[nodiscard]] std::unique_ptr<LinearSolver> make() const;
  [[nodiscard]] Status refine(const Pack& pack, const LaneArray& b, double* x, const Goal& goal, Counters& counters,
                              double& residual, int& rounds);
  [[nodiscard]] Status refine_grown(const Pack& pack, const LaneArray& b, double* x, Counters& counters,
                                    double& residual);
  [[nodiscard]] double residual_of(const double* x, const LaneArray& b);
  [[nodiscard]] double scaled_residual(const double* x, const LaneArray& b);
  void sort_by_rows();

  const Workspace& work_;
  const SolverSettings settings_;
  const Backend& backend_;
  const bool own_solvers_;  // one for each pack
  std::unique_ptr<LinearSolver> shared_;
  const LinearSolver* first_ = nullptr;  // of the packs' own ones: what the others are cloned from
  LinearSolver* solver_ = nullptr;       // the pack's at hand, or shared_
  Factors factors_ = Factors::earlier;
  std::int64_t refined_ = 0;             // solutions, because their residual was too large
  std::vector<std::int32_t> row_start_;  // n + 1
  std::vector<RowEntry> row_entries_;    // nnz: the Jacobian by rows
  LaneArray residual_;                   // n x W
  LaneArray jacobian_norm_;              // W
  LaneArray row_scale_, column_size_;    // n x W: of scaled_residual()
  bool jacobian_measured_ = false, scales_measured_ = false;
};

}  // namespace assur
