// Solves linear systems with the Jacobian of a pack, by factors of the current posture or of an earlier one; refines
// solutions that are not exact enough.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "assur/backend.hpp"
#include "assur/plan.hpp"
#include "assur/report.hpp"
#include "backends/lanes_elimination.hpp"
#include "groups/workspace.hpp"

namespace assur {

// Linear solver for the packs of one class.
class JacobianSolver {
 public:
  // Posture of the current factors.
  enum class Factors : std::uint8_t {
    earlier,   // a posture of an earlier step; without Pack::factored there are no factors
    step,      // a posture within this step
    solution,  // the solved posture in the workspace
    program,   // the same, but the program that solved it has kept them for itself
  };

  // Throws Error (environment) if the backend cannot run here.
  JacobianSolver(const Workspace& work, const Plan::Choice& choice, std::span<const Backend> table);

  // Drops the solvers, so that each pack gets a new one. It starts from the pivots Pack::pivots, else from those of the
  // first pack, which chooses them. alike = false: each pack chooses its own ones.
  void restart(bool alike = true);
  // Makes the solver of a pack, or the solver that all packs share, the current one.
  void choose(Pack& pack);
  [[nodiscard]] const SolverSettings& settings() const { return settings_; }
  [[nodiscard]] LinearSolver* at_hand() { return solver_; }  // the current solver; null before choose()

  // Extra work of the solver that all packs share, and refinements of all packs.
  [[nodiscard]] Effort effort() const;

  // To be called when a new step begins.
  void begin_step() { factors_ = Factors::earlier; }
  // To be called when a program has taken a step in place of the solver `lanes`, with so many factorisations, the last
  // of them at the solution.
  void leave_to_program(std::int64_t factorizations) {
    factors_ = Factors::program;
    lanes::count_factorizations(*solver_, factorizations);
  }
  [[nodiscard]] Factors factors() const { return factors_; }

  // Factorises the workspace's Jacobian. from: step or solution. What a program factorised is not counted again.
  [[nodiscard]] Status factorize(Pack& pack, Factors from, Counters& counters);
  // The same without counting, outside of steps. False if it failed.
  [[nodiscard]] bool factorize(Pack& pack);

  // x = J^-1 b by the current factors. checked: refine if pivots grew; only for factors of J itself.
  [[nodiscard]] Status correction(Pack& pack, const LaneArray& b, double* x, bool checked, Counters& counters);

  // x = J^-1 b by factors of any posture. Refines to the relative residual `converged`, and factorises again if
  // refinement fails. Unknowns before first_wanted are not needed. error becomes at least the normwise residual.
  [[nodiscard]] Status solve(Pack& pack, const LaneArray& b, double* x, int first_wanted, double converged,
                             Counters& counters, double& error);

  // To be called when the Jacobian of the workspace has changed.
  void new_jacobian() { jacobian_measured_ = scales_measured_ = false; }

 private:
  // End of a refinement.
  struct Goal {
    double enough;     // residual that ends the refinement
    double tolerated;  // residual that is accepted if it no longer falls
    bool scaled;       // true: tests the larger one of the normwise and the scaled residual
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
  bool alike_ = true;       // packs start from the pivots of the first one
  std::unique_ptr<LinearSolver> shared_;
  const LinearSolver* first_ = nullptr;  // own solver of the first pack; the others are its clones
  LinearSolver* solver_ = nullptr;       // the current one
  Factors factors_ = Factors::earlier;
  std::int64_t refined_ = 0;             // refinements of solutions whose residual was too large
  std::vector<std::int32_t> row_start_;  // n + 1
  std::vector<RowEntry> row_entries_;    // nnz: the Jacobian by rows
  LaneArray residual_;                   // n x W
  LaneArray jacobian_norm_;              // W
  LaneArray row_scale_, column_size_;    // n x W: of scaled_residual()
  bool jacobian_measured_ = false, scales_measured_ = false;
};

}  // namespace assur
