// Solves the packs of one group class: position by Newton, velocity and acceleration by one factorisation or, as
// `+separate` asks, two.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <vector>

#include "assur/plan.hpp"
#include "assur/report.hpp"
#include "assur/simulator.hpp"
#include "equations/evaluator.hpp"
#include "equations/lane_array.hpp"
#include "equations/program.hpp"
#include "group/branch.hpp"
#include "group/pack.hpp"
#include "group/pack_kernels.hpp"
#include "group/small_step.hpp"
#include "group/tolerances.hpp"
#include "numbers.hpp"

namespace assur {

// Errors of one attempt; merged into the report when the step is accepted. Less than 0: nothing was measured.
struct StepErrors {
  double position = -1, velocity = -1, acceleration = -1;
  void merge(const StepErrors& o);
  void add_to(ErrorFigures& worst) const {
    const auto raise = [](double& figure, double error) {
      if (error >= 0 && !(error <= figure)) figure = error;
    };
    raise(worst.position, position);
    raise(worst.velocity, velocity);
    raise(worst.acceleration, acceleration);
  }
  [[nodiscard]] double worst() const;
};

// Possible errors of posture, velocity and acceleration, each laid out like the state, with their cause.
struct Probe {
  enum class Cause : std::uint8_t {
    left,       // in the equations, with the signs that it has
    rounding,   // with random signs
    tolerance,  // a relative residual of kSumRounding in every equation, with random signs
  };
  Cause cause = Cause::left;
  std::array<double*, 3> errors{};
};
using Probes = std::span<const Probe>;

// How a step is solved.
struct Attempt {
  enum class Branch : std::uint8_t {
    start,     // the posture is given: measure the ball around it
    inside,    // stay inside the ball
    pass,      // through a change point: corrections have to contract
    anywhere,  // is there a solution at all? nothing is kept
  };
  Branch branch = Branch::inside;
  std::int64_t number = 0;  // its own, from 1 on: by it a rejected attempt is undone in the packs
  int iterations = 0;       // exactly so many; 0: until convergence
  int most_iterations = 12;
  double converged = kConverged;  // relative residual that counts as solved
  double time = kNan;             // s, of the posture, or from any beginning; NaN: not known
  double largest_correction = 0;  // pass: the first one, in the maximum norm; a larger one may lead to the other branch
  bool all_rates = false;         // of all unknowns, also where none are wanted; accelerations of all if of some
};

class GroupSolver {
 public:
  // Throws Error (environment) if the backend cannot run here.
  GroupSolver(const System& system, const Structure& structure, std::int32_t group_class, const Plan::Choice& choice,
              std::span<const Backend> table);

  [[nodiscard]] int lanes() const { return lanes_; }
  [[nodiscard]] const Program& program() const { return program_; }
  [[nodiscard]] bool quadratic() const { return class_.quadratic; }

  // Drops what an earlier run left behind, so that runs repeat bit for bit; the packs drop their own solvers. The next
  // solve() of each pack makes its solver: the first one chooses the pivots, the others start from them.
  void restart();

  // What the solver that all packs share did, and what had to be refined after any; each pack's own one tells for
  // itself.
  [[nodiscard]] Effort effort() const {
    Effort sum = shared_ ? shared_->effort() : Effort{};
    sum.refined += refined_;
    sum.unplanned += refined_;
    return sum;
  }

  // Makes room in the pack for what it holds of this class.
  void size(Pack& pack) const;
  // One lane of the pack is `group`, with the constants of `system`.
  void bind_lane(const System& system, const Group& group, Pack& pack, int lane) const;

  // state[d]: d-th derivative of all coordinates, with the prediction in the pack's unknowns.
  // On failure `where` is the group and the pack's unknowns are unspecified.
  [[nodiscard]] Status solve(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters,
                             StepErrors& errors);

  // The block of a pack that is nearest to a singular posture (dense SVD; allocates).
  struct Singularity {
    Status status;            // limit_reached: its rates grow as they do towards a fold, which is no evidence of one
                              // yet; change_point_passed: they do not, passing may be tried; else branch_unknown
    std::int32_t block = -1;  // -1: none was looked at
    int lane = 0;
    double smallest = 0;        // singular value of the block
    std::vector<double> reads;  // what the block reads of others, internal units
  };
  [[nodiscard]] Singularity diagnose(Pack& pack, double* const (&state)[3]);

  // The errors of the pack's unknowns that follow, to first order, from those of its inputs and from the cause of each
  // probe, with signs drawn by `seed`. False if the Jacobian is singular.
  [[nodiscard]] bool perturb(Pack& pack, const double* const (&state)[3], Probes probes, std::uint64_t seed);

  // Relative residuals and conditions (GroupFigures) of the lanes at a posture.
  struct Health {
    std::array<double, kMostLanes> residual{}, condition{};
  };
  [[nodiscard]] Health examine(Pack& pack, const double* state);

 private:
  struct Bend {  // times * Phi''[a probe's derivative, direction]
    std::size_t probe;
    const double* direction;  // of the unknowns
    const LaneArray* inputs;
    double times;
  };
  [[nodiscard]] const double* solution(const Pack& pack, const double* state, int derivative);
  void left_of(const double* y);
  void round_unknowns(const double* x);
  [[nodiscard]] bool error_of(Pack& pack, const LaneArray& left, Probes probes, int derivative, std::uint64_t seed,
                              std::initializer_list<Bend> bends);
  void add_bend(const Pack& pack, const double* probe, const Bend& bend);
  void sort_by_rows();
  [[nodiscard]] std::unique_ptr<LinearSolver> make_solver() const;
  void choose_solver(Pack& pack);
  void gather(const Pack& pack, const double* state, LaneArray& out) const;
  // The ordinary step of a small group; false if it is none.
  [[nodiscard]] bool small_step(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters,
                                StepErrors& errors, Status& status);
  void set_inputs(const Pack& pack, const double* state);
  [[nodiscard]] Status newton(Pack& pack, double* x, const Attempt& attempt, Counters& counters, StepErrors& errors);
  [[nodiscard]] static bool stays_inside(double ball_used, double& before);
  [[nodiscard]] Status check_branch(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters);
  [[nodiscard]] Status derivatives(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters,
                                   StepErrors& errors);
  // x = J^-1 b with refinement where the factorisation is that of another posture; returns the normwise residual.
  [[nodiscard]] Status linear(Pack& pack, const LaneArray& b, double* x, int first_wanted, const Attempt& attempt,
                              Counters& counters, double& error);
  [[nodiscard]] double linear_residual(const double* x, const LaneArray& b);
  [[nodiscard]] double scaled_residual(const double* x, const LaneArray& b);
  [[nodiscard]] Status refine_grown(const Pack& pack, const LaneArray& b, double* x, Counters& counters,
                                    double& residual);
  [[nodiscard]] std::int32_t lane_with_most_left(const Pack& pack) const;
  [[nodiscard]] double raised_ratio();
  [[nodiscard]] double residual_of(const Pack& pack, const double* state);
  [[nodiscard]] double correct(double* x);
  [[nodiscard]] Status kantorovich(const Pack& pack);
  [[nodiscard]] Status factorize(Pack& pack, Counters& counters);
  [[nodiscard]] Status fail(const Pack& pack, Code code, double figure, std::int32_t lane = 0) const;
  [[nodiscard]] Status check_tubes(const Pack& pack, double* const (&state)[3], std::int32_t block,
                                   const Attempt& attempt);
  [[nodiscard]] bool tube_leads_here(const Pack& pack, double* const (&state)[3], std::int32_t block, int lane,
                                     double seconds);
  [[nodiscard]] Status set_anchor(Pack& pack, double* const (&state)[3], std::int32_t block, const Attempt& attempt,
                                  Counters& counters);
  [[nodiscard]] double ball_use(const Pack& pack, const double* x, std::int32_t block) const;
  [[nodiscard]] double ball_use_of(const Pack& pack, const double* x, std::int32_t block, std::int32_t lane) const;

  const GroupClass& class_;
  SolverSettings settings_;
  Program program_;
  int lanes_ = 1;
  std::unique_ptr<Evaluator> evaluator_;
  const Backend& backend_;
  bool own_solvers_;  // one for each pack
  std::unique_ptr<LinearSolver> shared_;
  const LinearSolver* first_ = nullptr;  // of the packs' own ones: what the others are cloned from
  LinearSolver* solver_ = nullptr;       // the pack's at hand, or shared_
  BlockConditions blocks_;
  const PackKernels& kernels_;
  std::unique_ptr<SmallStep> small_step_;                 // null: the class, or the strategy, has none
  std::vector<std::int32_t> row_start_;                   // n + 1
  std::vector<RowEntry> row_entries_;                     // nnz: the Jacobian by rows
  LaneArray inputs_, input_rates_, input_accelerations_;  // inputs x W
  LaneArray phi_, inverse_scale_, correction_, rhs_, residual_, jacobian_;
  LaneArray jacobian_norm_;            // W
  LaneArray row_scale_, column_size_;  // n x W: of scaled_residual()
  LaneArray largest_correction_;       // blocks x W
  // Of tube_leads_here(): a posture on the way.
  LaneArray there_, there_inputs_, there_phi_, there_jacobian_;
  LaneArray scale_;                   // n x W
  LaneArray omega_, posture_errors_;  // W: of one block, of set_anchor()
  // Of perturb().
  LaneArray noise_, tolerance_, error_, bent_, moved_, whole_;  // n x W
  LaneArray input_errors_, moved_inputs_, resting_inputs_;      // inputs x W
  std::int64_t refined_ = 0;                                    // solutions, because their residual was too large
  bool jacobian_measured_ = false, scales_measured_ = false;
  bool factored_in_step_ = false, factored_at_solution_ = false;
};

}  // namespace assur
