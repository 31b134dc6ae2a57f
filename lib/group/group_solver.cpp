#include "group/group_solver.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "backends/refined.hpp"
#include "backends/residual.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "planning/small_steps.hpp"

namespace assur {
namespace {
constexpr double kLinear = 8 * kEps;   // normwise residual of a refined linear system
constexpr double kPivotsGrew = 1e-13;  // that of a direct solution is smaller, unless pivots grew
constexpr int kSlowIterations = 2;     // iterations that a step seldom takes
constexpr int kMostSearching = 40;     // iterations at a fold, where they gain one bit each
constexpr int kMostRefinements = 6;
constexpr double kContraction = 0.1;  // of successive corrections

}  // namespace

void StepErrors::merge(const StepErrors& o) {
  position = std::max(position, o.position);
  velocity = std::max(velocity, o.velocity);
  acceleration = std::max(acceleration, o.acceleration);
}

double StepErrors::worst() const { return std::max({position, velocity, acceleration}); }

GroupSolver::GroupSolver(const System& system, const Structure& structure, std::int32_t group_class,
                         const Plan::Choice& choice, std::span<const Backend> table)
    : class_(structure.classes[idx(group_class)]),
      settings_(choice.solver),
      program_(compile(class_, structure.pattern(group_class))),
      lanes_(settings_.lanes),
      evaluator_(make_evaluator(system, program_, lanes_)),
      backend_(find_backend(table, settings_.backend)),
      own_solvers_(backend_.keeps_pivots || settings_.reuse == Reuse::run),
      blocks_(class_, program_, lanes_),
      kernels_(pack_kernels(lanes_)) {
  const std::string why_not = backend_.why_not(choice.shape, ThreadBudget{settings_.threads});
  if (!why_not.empty()) throw Error(Error::Kind::environment, "backend " + settings_.backend + ": " + why_not);
  const std::size_t w = idx(lanes_), n = idx(program_.n) * w;
  inputs_.resize(idx(program_.inputs) * w);
  input_rates_.resize(inputs_.size());
  input_accelerations_.resize(inputs_.size());
  if (has_small_steps(settings_)) small_step_ = make_small_step(class_, program_, blocks_, lanes_);
  for (LaneArray* v : {&phi_, &inverse_scale_, &correction_, &rhs_, &residual_, &noise_, &tolerance_, &error_, &bent_,
                       &moved_, &whole_}) {
    v->resize(n);
  }
  for (LaneArray* v : {&input_errors_, &moved_inputs_, &resting_inputs_}) v->resize(inputs_.size());
  jacobian_.resize(idx(program_.pattern.nnz()) * w);
  jacobian_norm_.resize(w);
  row_scale_.resize(n);
  column_size_.resize(n);
  largest_correction_.resize(idx(program_.blocks) * w);
  there_.resize(n);
  there_phi_.resize(n);
  there_jacobian_.resize(jacobian_.size());
  there_inputs_.resize(inputs_.size());
  scale_.resize(n);
  omega_.resize(w);
  posture_errors_.resize(w);
  sort_by_rows();
}

void GroupSolver::sort_by_rows() {
  const Pattern& p = program_.pattern;
  row_start_.assign(idx(program_.n) + 1, 0);
  for (const std::int32_t r : p.row) ++row_start_[idx(r) + 1];
  for (std::size_t r = 0; r < idx(program_.n); ++r) row_start_[r + 1] += row_start_[r];
  row_entries_.resize(p.row.size());
  std::vector<std::int32_t> next(row_start_.begin(), row_start_.end() - 1);
  for (std::int32_t c = 0; c < program_.n; ++c) {
    for (std::int32_t k = p.column_start[idx(c)]; k < p.column_start[idx(c) + 1]; ++k) {
      row_entries_[idx(next[idx(p.row[idx(k)])]++)] = {k, c};
    }
  }
}

std::unique_ptr<LinearSolver> GroupSolver::make_solver() const {
  auto solver = assur::make_solver(backend_, ThreadBudget{settings_.threads},
                                   settings_.single ? Precision::binary32 : Precision::binary64, settings_.refine);
  if (!solver->analyze(program_.pattern, lanes_).ok()) {
    throw Error(Error::Kind::environment, "backend " + settings_.backend + " cannot analyse the pattern of a group");
  }
  return solver;
}

void GroupSolver::restart() {
  first_ = nullptr;
  refined_ = 0;
  if (!own_solvers_) shared_ = make_solver();
}

void GroupSolver::choose_solver(Pack& pack) {
  solver_ = shared_.get();
  if (!own_solvers_) return;
  if (!pack.solver) {
    if (first_ != nullptr) pack.solver = first_->clone();
    if (!pack.solver) pack.solver = make_solver();
    if (first_ == nullptr) first_ = pack.solver.get();
  }
  solver_ = pack.solver.get();
}

void GroupSolver::size(Pack& pack) const {
  const std::size_t w = idx(lanes_);
  pack.coefficients.assign((idx(one_coefficient(program_)) + 1) * w, 0.0);
  std::fill_n(pack.coefficients.begin() + one_coefficient(program_) * lanes_, w, 1.0);
  pack.lipschitz.resize(idx(program_.n) * w);
  pack.anchor.resize(blocks_.reads_start(program_.blocks) * w);
  pack.omega.assign(idx(program_.blocks) * w, 0.0);
  pack.ball_used.assign(idx(program_.blocks), 0.0);
  pack.anchor_rates.resize(pack.anchor.size());
  pack.anchor_time.assign(idx(program_.blocks), kNan);
  pack.kept = {0, 0, 0, pack.ball_used, pack.anchor, pack.anchor_rates, pack.anchor_time, pack.omega, {}};
}

void GroupSolver::bind_lane(const System& system, const Group& group, Pack& pack, int lane) const {
  std::vector<double> constants;
  constants.reserve(group.constants.size());
  for (const std::int32_t k : group.constants) constants.push_back(system.constants[idx(k)]);
  bind_coefficients(program_, constants, pack.coefficients.data() + lane, idx(lanes_));
  lipschitz(class_, constants, pack.lipschitz.data() + lane, idx(lanes_));
}

void GroupSolver::gather(const Pack& pack, const double* state, LaneArray& out) const {
  kernels_.gather(pack.input_rows.data(), pack.inputs.data(), program_.inputs, state, out.data());
}

Status GroupSolver::fail(const Pack& pack, Code code, double figure, std::int32_t lane) const {
  return {code, Place::group(pack.groups[std::min(idx(lane), pack.groups.size() - 1)]), figure};
}

Status GroupSolver::solve(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters,
                          StepErrors& errors) {
  if (Status s; small_step_ && small_step(pack, state, attempt, counters, errors, s)) return s;
  choose_solver(pack);
  pack.kept.factors_of = attempt.number;
  set_inputs(pack, state[0]);
  double* x = state[0] + pack.unknowns;
  if (const Status s = newton(pack, x, attempt, counters, errors); !s.ok()) return s;
  if (attempt.branch == Attempt::Branch::anywhere) return {};
  if (const Status s = derivatives(pack, state, attempt, counters, errors); !s.ok()) return s;
  if (small_step_) {
    pack.keep_anchor(attempt.number);
    small_step_->choose_pivots(pack, state[0]);
  }
  return check_branch(pack, state, attempt, counters);
}

void GroupSolver::set_inputs(const Pack& pack, const double* state) {
  gather(pack, state, inputs_);
  evaluator_->set_inputs(pack.coefficients.data(), inputs_.data());
}

bool GroupSolver::small_step(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters,
                             StepErrors& errors, Status& status) {
  if (attempt.branch != Attempt::Branch::inside || attempt.iterations > 0) return false;
  if (attempt.all_rates && class_.derivatives == 0) return false;
  SmallStepFigures figures{0, errors.position, errors.velocity, errors.acceleration, 0};
  if (!small_step_->run(pack, state, attempt.most_iterations, attempt.converged, figures)) return false;
  const int factorizations = figures.iterations + (class_.derivatives > 0 ? 1 : 0);
  const std::int64_t unknowns = std::int64_t{pack.used} * program_.n;
  counters.group_solutions += pack.used;
  counters.newton_iterations += std::int64_t{pack.used} * figures.iterations;
  counters.most_iterations = std::max<std::int64_t>(counters.most_iterations, figures.iterations);
  counters.evaluated_equations += unknowns * (figures.iterations + 1);
  counters.factorizations += std::int64_t{pack.used} * factorizations;
  counters.factorized_unknowns += unknowns * factorizations;
  counters.solved_unknowns += unknowns * (figures.iterations + class_.derivatives);
  if (figures.position > std::max(errors.position, kConverged)) {
    figures.position = std::max(errors.position, residual_of(pack, state[0]));
  }
  errors = {figures.position, figures.velocity, figures.acceleration};
  pack.keep_use(attempt.number);
  if (stays_inside(figures.ball_used, pack.ball_used[0])) return true;
  pack.keep_anchor(attempt.number);
  small_step_->choose_pivots(pack, state[0]);
  set_inputs(pack, state[0]);
  const double* x = state[0] + pack.unknowns;
  evaluator_->evaluate(x, phi_.data(), jacobian_.data());
  status = check_branch(pack, state, attempt, counters);
  return true;
}

// The relative residual of a posture.
double GroupSolver::residual_of(const Pack& pack, const double* state) {
  set_inputs(pack, state);
  evaluator_->evaluate(state + pack.unknowns, phi_.data(), nullptr);
  evaluator_->scale(inverse_scale_.data());
  kernels_.invert_scale(inverse_scale_.data(), program_.n);
  return raised_ratio();
}

Status GroupSolver::factorize(Pack& pack, Counters& counters) {
  counters.factorizations += pack.used;
  counters.factorized_unknowns += std::int64_t{pack.used} * program_.n;
  const Status s = solver_->factorize(jacobian_);
  pack.factored = factored_in_step_ = s.ok();
  // An idle lane repeats lane 0 and fails with it.
  return s.ok() ? s : fail(pack, s.code, s.figure, s.where.index < pack.used ? std::max(s.where.index, 0) : 0);
}

Status GroupSolver::newton(Pack& pack, double* x, const Attempt& attempt, Counters& counters, StepErrors& errors) {
  const std::int64_t evaluated = std::int64_t{pack.used} * program_.n;
  evaluator_->evaluate(x, phi_.data(), jacobian_.data());
  evaluator_->scale(inverse_scale_.data());
  kernels_.invert_scale(inverse_scale_.data(), program_.n);
  counters.evaluated_equations += evaluated;
  counters.group_solutions += pack.used;
  factored_at_solution_ = factored_in_step_ = false;
  // Beyond a change point a singular value has the other sign: factors of before lead astray.
  bool usable = settings_.reuse == Reuse::run && pack.factored && attempt.branch != Attempt::Branch::pass;
  bool stale = false;
  double relative = kernels_.largest_ratio(phi_.data(), inverse_scale_.data(), program_.n), before = 0, last_norm = 0;
  int iteration = 0;
  for (;; ++iteration) {
    if (!std::isfinite(relative)) relative = raised_ratio();  // terms below all normal numbers have no inverse
    if (!std::isfinite(relative)) return fail(pack, Code::not_finite, relative, lane_with_most_left(pack));
    if (attempt.iterations > 0) {
      if (iteration == attempt.iterations) break;
    } else {
      if (relative <= attempt.converged) break;
      if (iteration > 0 && only_rounding_is_left(relative, before)) {
        // Rounding, or factors that no longer fit.
        if (!stale) break;
        usable = false;
      }
      if (iteration == (attempt.branch == Attempt::Branch::anywhere ? kMostSearching : attempt.most_iterations))
        return fail(pack, Code::not_converged, relative, lane_with_most_left(pack));
    }
    if (iteration == kSlowIterations && attempt.iterations == 0) {
      // All terms of an equation may nearly vanish: then it is measured against what does not.
      relative = raised_ratio();
      if (relative <= attempt.converged) break;
    }
    stale = usable;
    if (!usable) {
      if (const Status s = factorize(pack, counters); !s.ok()) return s;
    }
    std::copy(phi_.begin(), phi_.end(), correction_.begin());
    if (const Status s = solver_->solve(correction_, 1); !s.ok()) return fail(pack, s.code, s.figure);
    counters.solved_unknowns += evaluated;
    counters.newton_iterations += pack.used;
    // The first correction is seldom looked at so closely: the second one, if need be, tells.
    if (!stale && (iteration > 0 || !class_.quadratic)) {
      jacobian_measured_ = false;
      double residual = linear_residual(correction_.data(), phi_);
      if (const Status s = refine_grown(pack, phi_, correction_.data(), counters, residual); !s.ok()) return s;
    }

    const double norm = correct(x);
    if (!std::isfinite(norm)) return fail(pack, Code::not_finite, norm);
    if (attempt.branch == Attempt::Branch::pass && iteration == 0 && !(norm <= attempt.largest_correction)) {
      return fail(pack, Code::branch_unknown, norm);
    }
    if (attempt.branch == Attempt::Branch::inside && class_.quadratic && iteration == 0) {
      if (const Status s = kantorovich(pack); !s.ok()) return s;
    }
    // Without a constant second derivative two corrections have to contract tenfold.
    const bool must_contract =
        attempt.branch == Attempt::Branch::pass || (!class_.quadratic && attempt.branch != Attempt::Branch::anywhere);
    const bool contracts = iteration == 0 || norm <= kContraction * last_norm || relative <= kRoundingLevel;
    if (must_contract && attempt.iterations == 0 && !contracts) {
      return fail(pack, Code::not_converged, norm / last_norm);
    }
    // Factors of another posture serve as long as the corrections contract.
    usable = (settings_.once || settings_.reuse != Reuse::fresh) && contracts;
    last_norm = norm;
    before = relative;
    evaluator_->evaluate(x, phi_.data(), jacobian_.data());
    counters.evaluated_equations += evaluated;
    relative = kernels_.largest_ratio(phi_.data(), inverse_scale_.data(), program_.n);
  }
  counters.most_iterations = std::max<std::int64_t>(counters.most_iterations, iteration);
  if (relative > kConverged) relative = raised_ratio();
  errors.position = std::max(errors.position, relative);
  return {};
}

// Whose equations are furthest from being solved.
std::int32_t GroupSolver::lane_with_most_left(const Pack& pack) const {
  const std::size_t w = idx(lanes_);
  std::int32_t found = 0;
  double most = -1;
  for (std::int32_t l = 0; l < pack.used; ++l) {
    for (std::size_t i = idx(l); i < phi_.size(); i += w) {
      const double left = std::abs(phi_[i]) * inverse_scale_[i];
      if (left <= most) continue;  // a NaN is not
      if (std::isnan(left)) return l;
      most = left;
      found = l;
    }
  }
  return found;
}

// x = J^-1 b, whose residual_ is at hand, by factors of J itself: where they grew they do not serve as they are.
Status GroupSolver::refine_grown(const Pack& pack, const LaneArray& b, double* x, Counters& counters,
                                 double& residual) {
  for (int k = 0; k < kMostRefinements && residual > kPivotsGrew; ++k) {
    if (const Status s = solver_->solve(residual_, 1); !s.ok()) return fail(pack, s.code, s.figure);
    counters.solved_unknowns += std::int64_t{pack.used} * program_.n;
    refined_ += pack.used;
    for (std::size_t i = 0; i < b.size(); ++i) x[i] += residual_[i];
    const double before = std::exchange(residual, linear_residual(x, b));
    if (!(residual < before / 2)) break;
  }
  return {};
}

// The relative residual, with the scales of the equations raised to the least that they are at this posture.
double GroupSolver::raised_ratio() {
  std::fill(scale_.begin(), scale_.end(), 0.0);
  evaluator_->raise_scale(scale_.data());
  for (std::size_t i = 0; i < scale_.size(); ++i) {
    if (scale_[i] > 0) inverse_scale_[i] = std::min(inverse_scale_[i], 1 / scale_[i]);
  }
  return kernels_.largest_ratio(phi_.data(), inverse_scale_.data(), program_.n);
}

// x -= correction_; returns its largest element.
double GroupSolver::correct(double* x) {
  double norm = 0;
  for (std::int32_t b = 0; b < program_.blocks; ++b) {
    const auto unknowns = blocks_.unknowns(b);
    const double largest = kernels_.correct(unknowns.data(), static_cast<std::int32_t>(unknowns.size()),
                                            correction_.data(), x, largest_correction_.data() + b * lanes_);
    if (!(largest <= norm)) norm = largest;
  }
  return norm;
}

// From omega |first correction| <= 1/4 the iteration converges to the one solution nearby; so it does where a box
// around the prediction, where phi_ and jacobian_ are from, holds only one.
Status GroupSolver::kantorovich(const Pack& pack) {
  for (std::int32_t b = 0; b < program_.blocks; ++b) {
    const double left = 1 - pack.ball_used[idx(b)];
    const double *omega = pack.omega.data() + b * lanes_, *largest = largest_correction_.data() + b * lanes_;
    for (int l = 0; l < pack.used; ++l) {
      if (largest[l] == 0 || omega[l] * largest[l] <= kKantorovich * left) continue;
      evaluator_->scale(scale_.data());
      const bool one = blocks_.invert(b, l, jacobian_.data()) &&
                       blocks_.holds_one_solution(b, l, jacobian_.data(), jacobian_.data(), phi_.data(), scale_.data(),
                                                  pack.coefficients.data());
      if (!one) return fail(pack, Code::branch_unknown, omega[l] * largest[l] / left, l);
    }
  }
  return {};
}

// residual_ = b - J x; returns |residual| / (|J| |x| + |b|), maximum norms, of the worst lane.
double GroupSolver::linear_residual(const double* x, const LaneArray& b) {
  const bool measure = !std::exchange(jacobian_measured_, true);
  return kernels_.residual(row_start_.data(), row_entries_.data(), program_.n, jacobian_.data(), x, b.data(),
                           residual_.data(), jacobian_norm_.data(), measure);
}

// The same of the worst lane once rows and columns have been scaled to size 1: what a few large ones hide in the norms
// of all. residual_ is that of x.
double GroupSolver::scaled_residual(const double* x, const LaneArray& b) {
  if (!std::exchange(scales_measured_, true)) {
    equilibrate({program_.pattern, jacobian_, lanes_, Transpose::no}, row_scale_, column_size_);
    for (double& c : column_size_) c = 1 / c;
  }
  std::array<double, kMostLanes> left{}, right{}, size{};
  const std::size_t w = idx(lanes_);
  norms(residual_, row_scale_, std::span(left).first(w));
  norms(b, row_scale_, std::span(right).first(w));
  norms({x, b.size()}, column_size_, std::span(size).first(w));
  double worst = 0;
  for (std::size_t l = 0; l < w; ++l) {
    if (!(left[l] <= 0)) worst = std::max(worst, left[l] / (size[l] + right[l]));
  }
  return worst;
}

Status GroupSolver::linear(Pack& pack, const LaneArray& b, double* x, int first_wanted, const Attempt& attempt,
                           Counters& counters, double& error) {
  std::copy(b.begin(), b.end(), x);
  // With a factorisation from elsewhere the whole solution is needed to refine it.
  const int first = factored_at_solution_ ? first_wanted : 0;
  const std::span<double> out(x, b.size());
  if (const Status s = solver_->solve(out, 1, Transpose::no, first); !s.ok()) return fail(pack, s.code, s.figure);
  counters.solved_unknowns += std::int64_t{pack.used} * (program_.n - first);
  if (first > 0) {  // what was not solved for is nobody's business
    std::fill_n(x, idx(first * lanes_), 0.0);
    return {};
  }
  double residual = linear_residual(x, b);
  if (factored_at_solution_) {
    if (const Status s = refine_grown(pack, b, x, counters, residual); !s.ok()) return s;
  } else {
    const double converged = std::max(kLinear, attempt.converged);
    double left = std::max(residual, scaled_residual(x, b));
    for (int k = 0; left > converged; ++k) {
      if (k == kMostRefinements) {
        // The posture is too far from where the factorisation was taken: take it here.
        if (const Status s = factorize(pack, counters); !s.ok()) return s;
        factored_at_solution_ = true;
        return linear(pack, b, x, first_wanted, attempt, counters, error);
      }
      if (const Status s = solver_->solve(residual_, 1); !s.ok()) return fail(pack, s.code, s.figure);
      counters.solved_unknowns += std::int64_t{pack.used} * program_.n;
      for (std::size_t i = 0; i < b.size(); ++i) x[i] += residual_[i];
      residual = linear_residual(x, b);
      const double before = std::exchange(left, std::max(residual, scaled_residual(x, b)));
      if (!(left < before / 2) && left <= 4 * converged) break;
    }
  }
  if (!std::isfinite(residual)) return fail(pack, Code::not_finite, residual);
  error = std::max(error, residual);
  return {};
}

Status GroupSolver::derivatives(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters,
                                StepErrors& errors) {
  const int most = std::max(class_.derivatives, attempt.all_rates ? 1 : 0);
  const int first = attempt.all_rates ? 0 : class_.first_wanted;
  if (most == 0) return {};
  // +once: the factors of the prediction (or, with +reuse=run, of an earlier step) serve, with refinement.
  const bool at_hand = settings_.reuse == Reuse::run ? pack.factored : factored_in_step_;
  if (!(settings_.once && at_hand)) {
    if (const Status s = factorize(pack, counters); !s.ok()) return s;
    factored_at_solution_ = true;
  }
  jacobian_measured_ = scales_measured_ = false;
  double* rate = state[1] + pack.unknowns;
  gather(pack, state[1], input_rates_);
  evaluator_->velocity_rhs(input_rates_.data(), rhs_.data());
  double unwanted = 0;
  double& error = class_.derivatives > 0 ? errors.velocity : unwanted;
  if (const Status s = linear(pack, rhs_, rate, most == 1 ? first : 0, attempt, counters, error); !s.ok()) return s;
  if (most == 1) return {};
  if (settings_.separate) {
    if (const Status s = factorize(pack, counters); !s.ok()) return s;
  }
  gather(pack, state[2], input_accelerations_);
  evaluator_->acceleration_rhs(rate, input_accelerations_.data(), rhs_.data());
  return linear(pack, rhs_, state[2] + pack.unknowns, first, attempt, counters, errors.acceleration);
}

}  // namespace assur
