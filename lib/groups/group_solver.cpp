#include "groups/group_solver.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "backends/small_steps.hpp"
#include "equations/residual_scale.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "program/class_step.hpp"

namespace assur {
namespace {

constexpr double kSameSolution = 1e-8;  // typical lengths are 1; solutions differ by rounding times a condition

}  // namespace

GroupSolver::GroupSolver(const System& system, const GroupedSystem& structure, std::int32_t group_class,
                         const Plan::Choice& choice, std::span<const Backend> table)
    : work_(system, structure.classes[idx(group_class)], choice.solver.lanes),
      solver_(work_, choice, table),
      guard_(work_, solver_),
      step_(work_, solver_, guard_, choice.solver),
      probe_(system, work_, solver_, guard_.blocks()) {
  if (has_small_steps(choice.solver)) small_step_ = make_small_step(work_, guard_.blocks());
  is_kept_.resize(idx(work_.lanes));
  predicted_.resize(work_.size());
  if (!small_step_) return;
  for (LaneArray& of : kept_) of.resize(work_.size());
  omega_.resize(idx(work_.lanes));
}

void GroupSolver::use(StepCode& code) {
  if (has_small_steps(solver_.settings()) && has_class_step(work_.group_class)) {
    code_ = &code;
    class_step_ = make_class_step(work_);
    most_.resize(idx(work_.lanes));
  }
  if (!small_step_) return;
  auto coded = make_coded_step(work_, guard_.blocks(), code);
  is_coded_ = coded != nullptr;
  if (coded) small_step_ = std::move(coded);
}

void GroupSolver::size(Pack& pack) const {
  const std::size_t w = idx(work_.lanes);
  pack.coefficients.assign((idx(one_coefficient(work_.group_class)) + 1) * w, 0.0);
  std::fill_n(pack.coefficients.data() + idx(one_coefficient(work_.group_class)) * w, w, 1.0);
  pack.lipschitz.resize(idx(work_.group_class.n) * w);
  pack.anchor.resize(guard_.blocks().reads_start(work_.group_class.blocks) * w);
  pack.omega.assign(idx(work_.group_class.blocks) * w, 0.0);
  pack.own_use.assign(idx(work_.group_class.blocks) * w, 0.0);
  pack.ball_used = pack.own_use;
  pack.anchor_rates.resize(pack.anchor.size());
  pack.anchor_time.assign(idx(work_.group_class.blocks) * w, kNan);
  pack.kept = {0, 0, 0, pack.own_use, pack.anchor, pack.anchor_rates, pack.anchor_time, pack.omega};
}

Status GroupSolver::solve(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters,
                          StepErrors& errors) {
  if (attempt.branch == Attempt::Branch::change_point)
    return use_change_point(*attempt.change_point, pack, state, counters, errors);
  std::fill(is_kept_.begin(), is_kept_.end(), std::uint8_t{0});
  if (Status s; small_step_ && small_step(pack, state, attempt, counters, errors, s)) return s;
  solver_.choose(pack);
  if (Status s; class_step(pack, state, attempt, counters, errors, s)) return s;
  pack.kept.factors_of = attempt.number;
  work_.set_inputs(pack, state[0]);
  double* const x = state[0] + pack.unknowns;
  if (small_step_) std::copy_n(x, predicted_.size(), predicted_.begin());
  StepErrors found;
  if (const Status s = step_.position(pack, x, attempt, is_kept_, counters, found); !s.ok()) return s;
  const bool searches = attempt.branch == Attempt::Branch::anywhere;
  if (!searches) {
    if (const Status s = step_.derivatives(pack, state, attempt, counters, found); !s.ok()) return s;
    if (small_step_) solve_in_lanes(pack, state, attempt, found);
  }
  errors.merge(found);
  if (attempt.branch == Attempt::Branch::start) find_code(pack, attempt.makes_code);
  return searches ? Status{} : guard_.check(pack, state, attempt, counters);
}

// What the general path has solved is solved by small steps as well, now that its branch is known: their bits depend
// neither on neighbours in the pack nor on W. Lanes that do not succeed, or that find another solution, keep the
// results of the general path.
void GroupSolver::solve_in_lanes(Pack& pack, double* const (&state)[3], const Attempt& attempt, StepErrors& errors) {
  take_kept(pack, state);
  if (attempt.branch == Attempt::Branch::pass || !serves(attempt)) return;
  keep(pack, state);
  std::copy(predicted_.begin(), predicted_.end(), state[0] + pack.unknowns);
  std::copy(pack.omega.begin(), pack.omega.end(), omega_.begin());
  std::fill(pack.omega.begin(), pack.omega.end(), 0.0);
  SmallStepFigures figures;
  (void)small_step_->run(pack, state, attempt.most_iterations, attempt.converged, figures);
  std::copy(omega_.begin(), omega_.end(), pack.omega.begin());
  const double* const x = state[0] + pack.unknowns;
  for (std::size_t l = 0; l < is_kept_.size(); ++l) is_kept_[l] = figures.failed[l] <= 0 ? 0 : 1;
  for (std::size_t i = 0; i < kept_[0].size(); ++i) {
    if (!(std::abs(x[i] - kept_[0][i]) <= kSameSolution)) is_kept_[i % is_kept_.size()] = 1;
  }
  take_kept(pack, state);
  work_.evaluate(x);
  if (std::find(is_kept_.begin(), is_kept_.end(), 1) != is_kept_.end()) return;
  if (figures.position <= kConverged) errors.position = figures.position;
  if (work_.group_class.derivatives > 0) errors.velocity = figures.velocity;
  if (work_.group_class.derivatives > 1) errors.acceleration = figures.acceleration;
}

void GroupSolver::keep(const Pack& pack, double* const (&state)[3]) {
  for (std::size_t d = 0; d < 3; ++d) std::copy_n(state[d] + pack.unknowns, kept_[d].size(), kept_[d].begin());
}

void GroupSolver::take_kept(const Pack& pack, double* const (&state)[3]) const {
  if (std::find(is_kept_.begin(), is_kept_.end(), 1) == is_kept_.end()) return;
  for (std::size_t d = 0; d < 3; ++d) {
    double* const to = state[d] + pack.unknowns;
    for (std::size_t i = 0; i < kept_[d].size(); ++i) {
      if (is_kept_[i % is_kept_.size()] != 0) to[i] = kept_[d][i];
    }
  }
}

Status GroupSolver::use_change_point(const ChangePointPosture& posture, const Pack& pack, double* const (&state)[3],
                                     Counters& counters, StepErrors& errors) {
  const std::size_t size = work_.size();
  for (std::size_t d = 0; d < 3; ++d) std::copy_n(posture.values.data() + d * size, size, state[d] + pack.unknowns);
  counters.group_solutions += pack.used;
  const double left = step_.residual_of(pack, state[0]);
  if (!(left <= kConsistent)) return pack.failed(Code::not_converged, left, 0);
  errors.position = std::max(errors.position, left);
  return {};
}

bool GroupSolver::small_step(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters,
                             StepErrors& errors, Status& status) {
  if (attempt.branch != Attempt::Branch::inside || !serves(attempt)) return false;
  SmallStepFigures figures{errors.position, errors.velocity, errors.acceleration};
  if (!small_step_->run(pack, state, attempt.most_iterations, attempt.converged, figures)) {
    for (std::size_t l = 0; l < is_kept_.size(); ++l) is_kept_[l] = figures.failed[l] <= 0 ? 1 : 0;
    keep(pack, state);
    return false;
  }
  status = finish_small_step(pack, state, attempt, figures, *small_step_, counters, errors);
  return true;
}

bool GroupSolver::class_step(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters,
                             StepErrors& errors, Status& status) {
  const bool is_wanted = attempt.branch == Attempt::Branch::inside && serves(attempt) &&
                         !(attempt.all_rates && work_.group_class.first_wanted > 0);
  if (!is_wanted || !pack.machine_code.step || !lanes::eliminates_by(*solver_.at_hand(), pack.eliminates.get()))
    return false;
  double* const x = state[0] + pack.unknowns;
  std::copy_n(x, predicted_.size(), predicted_.begin());
  SmallStepFigures figures{errors.position, errors.velocity, errors.acceleration};
  if (!class_step_->run(pack, state, attempt.most_iterations, attempt.converged, figures) ||
      !is_near(pack, state[0], figures.first_correction)) {
    std::copy(predicted_.begin(), predicted_.end(), x);
    return false;
  }
  // The general path iterates and counts all lanes together.
  const double most = *std::max_element(figures.iterations, figures.iterations + pack.used);
  std::fill(most_.begin(), most_.end(), most);
  figures.iterations = most_.data();
  solver_.leave_to_program(static_cast<std::int64_t>(most) + 1);
  status = finish_small_step(pack, state, attempt, figures, *class_step_, counters, errors);
  return true;
}

// True if Newton's first correction, from predicted_, leads to the solution of the branch.
bool GroupSolver::is_near(const Pack& pack, const double* state, const double* first_correction) {
  std::copy_n(first_correction, work_.lanes, work_.correction.begin());
  if (guard_.is_near(pack)) return true;
  work_.set_inputs(pack, state);
  work_.evaluate(predicted_.data());
  return guard_.check_first_correction(pack).ok();
}

// At the start, when the solver has chosen its pivots.
void GroupSolver::find_code(Pack& pack, bool makes) {
  if (code_ == nullptr) return;
  auto elimination = lanes::elimination_of(*solver_.at_hand());
  const bool is_known = pack.eliminates && elimination && *elimination == *pack.eliminates;
  if (is_known && (pack.machine_code.step || !makes)) {
    pack.eliminates = std::move(elimination);
    return;
  }
  pack.machine_code = {};
  if (elimination) {
    pack.machine_code = code_->of(work_.group_class, *elimination, guard_.blocks().reads(0), work_.lanes, makes);
  }
  pack.eliminates = std::move(elimination);
}

void GroupSolver::count_small_step(const Pack& pack, const double* of_lanes, Counters& counters) const {
  std::int64_t iterations = 0, most = 0;
  for (std::int32_t l = 0; l < pack.used; ++l) {
    const auto of_lane = static_cast<std::int64_t>(of_lanes[l]);
    iterations += of_lane;
    most = std::max(most, of_lane);
  }
  counters.most_iterations = std::max(counters.most_iterations, most);
  const std::int64_t n = work_.group_class.n, used = pack.used, derivatives = work_.group_class.derivatives;
  const std::int64_t factorizations = iterations + (derivatives > 0 ? used : 0);
  counters.group_solutions += used;
  counters.newton_iterations += iterations;
  counters.evaluated_equations += n * (iterations + used);
  counters.factorizations += factorizations;
  counters.factorized_unknowns += n * factorizations;
  counters.solved_unknowns += n * (iterations + used * derivatives) - used * work_.group_class.first_wanted;
}

Status GroupSolver::finish_small_step(Pack& pack, double* const (&state)[3], const Attempt& attempt,
                                      const SmallStepFigures& figures, AnchorStep& anchors, Counters& counters,
                                      StepErrors& errors) {
  count_small_step(pack, figures.iterations, counters);
  // The figure is an upper bound.
  const bool is_measured = figures.position > std::max({errors.position, kConverged, attempt.known_residual});
  errors.position =
      !is_measured ? figures.position : std::max(errors.position, step_.residual_of(pack, state[0], figures.weights));
  errors.velocity = figures.velocity;
  errors.acceleration = figures.acceleration;
  pack.keep_use(attempt.number);
  if (figures.balls_last) {
    std::copy_n(figures.ball_used, work_.lanes, pack.ball_used.begin());
    return {};
  }
  pack.keep_anchor(attempt.number);
  const double* const failed = anchors.renew_anchors(pack, state, attempt.time);
  bool any = false;
  for (std::int32_t l = 0; l < pack.used; ++l) {
    if (figures.needs_anchor[l] <= 0) continue;
    any = any || failed[l] > 0;
    counters.branch_checks += failed[l] > 0 ? 0 : 1;
  }
  return any ? renew_anchor(pack, state, attempt, counters) : Status{};
}

Status GroupSolver::renew_anchor(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters) {
  pack.keep_anchor(attempt.number);
  work_.set_inputs(pack, state[0]);
  work_.evaluate(state[0] + pack.unknowns);
  return guard_.check(pack, state, attempt, counters);
}

}  // namespace assur
