#include "groups/newton_step.hpp"

#include <algorithm>
#include <cmath>

#include "program/step_rules.hpp"

namespace assur {

NewtonStep::NewtonStep(Workspace& work, JacobianSolver& solver, BranchGuard& guard, const SolverSettings& settings)
    : work_(work), solver_(solver), guard_(guard), settings_(settings) {
  inverse_scale_.resize(work_.size());
  correction_.resize(work_.size());
  for (LaneArray* v : {&ratios_, &before_, &last_}) v->resize(idx(work_.lanes));
  open_.resize(idx(work_.lanes));
}

// Fills ratios_ for the equations in the workspace.
void NewtonStep::measure() {
  work_.kernels.largest_ratios(work_.phi.data(), inverse_scale_.data(), work_.group_class.n, ratios_.data());
}

// Raises the scales of the equations of these lanes to their lower bounds at this posture.
void NewtonStep::raise(std::span<const std::uint8_t> lanes) {
  std::fill(work_.scale.begin(), work_.scale.end(), 0.0);
  work_.evaluator->raise_scale(work_.scale.data());
  for (std::size_t i = 0; i < work_.scale.size(); ++i) {
    if (lanes[i % lanes.size()] == 0 || !(work_.scale[i] > 0)) continue;
    inverse_scale_[i] = std::min(inverse_scale_[i], 1 / work_.scale[i]);
  }
  measure();
}

// The largest relative residual of the lanes that iterate; NaN if one is.
double NewtonStep::largest_open() const {
  double largest = 0;
  for (std::size_t l = 0; l < open_.size(); ++l) {
    if (open_[l] == 0 || ratios_[l] <= largest) continue;
    largest = ratios_[l];
    if (std::isnan(largest)) break;
  }
  return largest;
}

// Closes the lanes that are solved; rounds: also those where only rounding is left. False if all are closed.
bool NewtonStep::close(double converged, bool rounds) {
  bool any = false;
  for (std::size_t l = 0; l < open_.size(); ++l) {
    if (ratios_[l] <= converged || (rounds && only_rounding_is_left(ratios_[l], before_[l]))) open_[l] = 0;
    any = any || open_[l] != 0;
  }
  return any;
}

double NewtonStep::residual_of(const Pack& pack, const double* state, const double* weights) {
  work_.set_inputs(pack, state);
  work_.evaluator->evaluate(state + pack.unknowns, work_.phi.data(), nullptr);
  if (weights != nullptr) {
    std::copy_n(weights, inverse_scale_.size(), inverse_scale_.begin());
  } else {
    work_.evaluator->scale(inverse_scale_.data());
    work_.kernels.invert_scale(inverse_scale_.data(), work_.group_class.n);
  }
  std::fill(open_.begin(), open_.end(), std::uint8_t{1});
  raise(open_);
  return largest_open();
}

Status NewtonStep::position(Pack& pack, double* x, const Attempt& attempt, std::span<const std::uint8_t> solved,
                            Counters& counters, StepErrors& errors) {
  const std::int64_t evaluated = std::int64_t{pack.used} * work_.group_class.n;
  work_.evaluate(x);
  work_.evaluator->scale(inverse_scale_.data());
  work_.kernels.invert_scale(inverse_scale_.data(), work_.group_class.n);
  counters.evaluated_equations += evaluated;
  counters.group_solutions += pack.used;
  solver_.begin_step();
  // Beyond a change point the determinant has the other sign: factors from before it would mislead the iteration.
  bool usable = settings_.reuse == Reuse::run && pack.factored && attempt.branch != Attempt::Branch::pass;
  bool stale = false;
  std::transform(solved.begin(), solved.end(), open_.begin(), [](std::uint8_t s) -> std::uint8_t { return s == 0; });
  measure();
  double relative = largest_open(), before = 0, last_norm = 0;
  int iteration = 0;
  for (;; ++iteration) {
    if (!std::isfinite(relative)) {  // the scale may be too small to have an inverse
      raise(open_);
      relative = largest_open();
    }
    if (!std::isfinite(relative)) return pack.failed(Code::not_finite, relative, lane_with_most_left(pack));
    if (attempt.iterations > 0) {
      if (iteration == attempt.iterations) break;
    } else {
      if (!close(attempt.converged, false)) break;
      if (iteration > 0) {
        // What does not fall any more is rounding, or the factors no longer fit.
        if (!stale && !close(attempt.converged, true)) break;
        if (stale && only_rounding_is_left(relative, before)) usable = false;
      }
      if (iteration == (attempt.branch == Attempt::Branch::anywhere ? kMostSearching : attempt.most_iterations))
        return pack.failed(Code::not_converged, largest_open(), lane_with_most_left(pack));
    }
    if (iteration == kSlowIterations && attempt.iterations == 0) {
      // If nearly all terms of an equation vanish at this posture, its residual is measured against the raised scale.
      raise(open_);
      if (!close(attempt.converged, false)) break;
      relative = largest_open();
    }
    before = relative;
    before_ = ratios_;
    stale = usable;
    if (!usable) {
      if (const Status s = solver_.factorize(pack, Factors::step, counters); !s.ok()) return s;
    }
    // In quadratic groups the second correction makes up for errors of the first one, which is not checked.
    const bool checked = !stale && (iteration > 0 || !work_.group_class.quadratic());
    if (const Status s = solver_.correction(pack, work_.phi, correction_.data(), checked, counters); !s.ok()) return s;
    counters.newton_iterations += pack.used;
    for (std::size_t i = 0; i < correction_.size(); ++i) {
      if (open_[i % open_.size()] == 0) correction_[i] = 0;
    }
    const double norm = correct(x);
    if (!std::isfinite(norm)) return pack.failed(Code::not_finite, norm, lane_that_moved_most(pack));
    if (attempt.branch == Attempt::Branch::pass && iteration == 0 && !(norm <= attempt.largest_correction)) {
      return pack.failed(Code::branch_unknown, norm, lane_that_moved_most(pack));
    }
    if (attempt.branch == Attempt::Branch::inside && work_.group_class.quadratic() && iteration == 0) {
      if (const Status s = guard_.check_first_correction(pack); !s.ok()) return s;
    }
    // Where no ball guards the branch, each correction must be at most a tenth of the one before.
    const bool must_contract = attempt.branch == Attempt::Branch::pass ||
                               (!work_.group_class.quadratic() && attempt.branch != Attempt::Branch::anywhere);
    bool contracts = corrections_contract(iteration == 0);
    if (must_contract && attempt.iterations == 0 && !contracts) {
      // Corrections by rounding do not contract, and they look large if the terms of an equation vanish here.
      raise(open_);
      contracts = largest_open() <= kRoundingLevel;
      if (!contracts) return pack.failed(Code::not_converged, norm / last_norm, lane_that_moved_most(pack));
    }
    // Factors of another posture are kept as long as the corrections contract.
    usable = (settings_.once || settings_.reuse != Reuse::fresh) && contracts;
    last_norm = norm;
    work_.evaluate(x);
    counters.evaluated_equations += evaluated;
    measure();
    relative = largest_open();
  }
  counters.most_iterations = std::max<std::int64_t>(counters.most_iterations, iteration);
  std::fill(open_.begin(), open_.end(), std::uint8_t{1});
  relative = largest_open();
  if (relative > std::max(kConverged, attempt.known_residual)) {
    raise(open_);
    relative = largest_open();
  }
  errors.position = std::max(errors.position, relative);
  return {};
}

// The lane with the largest relative residual, of an attempt that failed: its equations are scaled here.
std::int32_t NewtonStep::lane_with_most_left(const Pack& pack) {
  for (std::size_t i = 0; i < work_.phi.size(); ++i) work_.phi[i] *= inverse_scale_[i];
  return work_.lane_with_most(pack, work_.phi);
}

// True if the last correction of each open lane is at most a tenth of the one before, or is rounding.
bool NewtonStep::corrections_contract(bool is_first) {
  bool all = true;
  for (std::size_t l = 0; l < open_.size(); ++l) {
    double norm = 0;
    for (std::size_t at = l; at < work_.correction.size(); at += open_.size()) {
      norm = std::max(norm, work_.correction[at]);
    }
    const bool is_small = norm <= kContraction * last_[l] || before_[l] <= kRoundingLevel;
    all = all && (is_first || open_[l] == 0 || is_small);
    last_[l] = norm;
  }
  return all;
}

// x -= correction_; returns its largest element.
double NewtonStep::correct(double* x) {
  double norm = 0;
  for (std::int32_t b = 0; b < work_.group_class.blocks; ++b) {
    const auto unknowns = guard_.blocks().unknowns(b);
    const double largest = work_.kernels.correct(unknowns.data(), static_cast<std::int32_t>(unknowns.size()),
                                                 correction_.data(), x, work_.correction.data() + b * work_.lanes);
    if (!(largest <= norm)) norm = largest;
  }
  return norm;
}

Status NewtonStep::derivatives(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters,
                               StepErrors& errors) {
  const int most = std::max(work_.group_class.derivatives, attempt.all_rates ? 1 : 0);
  const int first = attempt.all_rates ? 0 : work_.group_class.first_wanted;
  if (most == 0) return {};
  // +once: the factors from the prediction (or, with +reuse=run, from an earlier step) are used, with refinement.
  const bool at_hand = settings_.reuse == Reuse::run ? pack.factored : solver_.factors() != Factors::earlier;
  if (!(settings_.once && at_hand)) {
    if (const Status s = solver_.factorize(pack, Factors::solution, counters); !s.ok()) return s;
  }
  solver_.new_jacobian();
  double* rate = state[1] + pack.unknowns;
  work_.gather(pack, state[1], work_.input_rates);
  work_.evaluator->velocity_rhs(work_.input_rates.data(), work_.rhs.data());
  double unwanted = 0;
  double& error = work_.group_class.derivatives > 0 ? errors.velocity : unwanted;
  const Status s = solver_.solve(pack, work_.rhs, rate, most == 1 ? first : 0, attempt.converged, counters, error);
  if (!s.ok() || most == 1) return s;
  if (settings_.separate) {
    if (const Status failed = solver_.factorize(pack, Factors::solution, counters); !failed.ok()) return failed;
  }
  work_.gather(pack, state[2], work_.input_accelerations);
  work_.evaluator->acceleration_rhs(rate, work_.input_accelerations.data(), work_.rhs.data());
  return solver_.solve(pack, work_.rhs, state[2] + pack.unknowns, first, attempt.converged, counters,
                       errors.acceleration);
}

}  // namespace assur
