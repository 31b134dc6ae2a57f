#include "group/newton_step.hpp"

#include <algorithm>
#include <cmath>

#include "program/step_rules.hpp"

namespace assur {

NewtonStep::NewtonStep(Workspace& work, JacobianSolver& solver, BranchGuard& guard, const SolverSettings& settings)
    : work_(work), solver_(solver), guard_(guard), settings_(settings) {
  inverse_scale_.resize(work_.size());
  correction_.resize(work_.size());
}

double NewtonStep::residual_of(const Pack& pack, const double* state) {
  work_.set_inputs(pack, state);
  work_.evaluator->evaluate(state + pack.unknowns, work_.phi.data(), nullptr);
  work_.evaluator->scale(inverse_scale_.data());
  work_.kernels.invert_scale(inverse_scale_.data(), work_.program.n);
  return raised_ratio();
}

Status NewtonStep::position(Pack& pack, double* x, const Attempt& attempt, Counters& counters, StepErrors& errors) {
  const std::int64_t evaluated = std::int64_t{pack.used} * work_.program.n;
  work_.evaluate(x);
  work_.evaluator->scale(inverse_scale_.data());
  work_.kernels.invert_scale(inverse_scale_.data(), work_.program.n);
  counters.evaluated_equations += evaluated;
  counters.group_solutions += pack.used;
  solver_.begin_step();
  // Beyond a change point the determinant has the other sign: factors from before it would mislead the iteration.
  bool usable = settings_.reuse == Reuse::run && pack.factored && attempt.branch != Attempt::Branch::pass;
  bool stale = false;
  double relative = work_.kernels.largest_ratio(work_.phi.data(), inverse_scale_.data(), work_.program.n), before = 0,
         last_norm = 0;
  int iteration = 0;
  for (;; ++iteration) {
    if (!std::isfinite(relative)) relative = raised_ratio();  // the scale may be too small to have an inverse
    if (!std::isfinite(relative)) return pack.failed(Code::not_finite, relative, lane_with_most_left(pack));
    if (attempt.iterations > 0) {
      if (iteration == attempt.iterations) break;
    } else {
      if (relative <= attempt.converged) break;
      if (iteration > 0 && only_rounding_is_left(relative, before)) {
        // This is rounding, or the factors no longer fit.
        if (!stale) break;
        usable = false;
      }
      if (iteration == (attempt.branch == Attempt::Branch::anywhere ? kMostSearching : attempt.most_iterations))
        return pack.failed(Code::not_converged, relative, lane_with_most_left(pack));
    }
    if (iteration == kSlowIterations && attempt.iterations == 0) {
      // If nearly all terms of an equation vanish at this posture, its residual is measured against the raised scale.
      relative = raised_ratio();
      if (relative <= attempt.converged) break;
    }
    stale = usable;
    if (!usable) {
      if (const Status s = solver_.factorize(pack, Factors::step, counters); !s.ok()) return s;
    }
    // In quadratic groups the second correction makes up for errors of the first one, which is not checked.
    const bool checked = !stale && (iteration > 0 || !work_.group_class.quadratic);
    if (const Status s = solver_.correction(pack, work_.phi, correction_.data(), checked, counters); !s.ok()) return s;
    counters.newton_iterations += pack.used;
    const double norm = correct(x);
    if (!std::isfinite(norm)) return pack.failed(Code::not_finite, norm, lane_that_moved_most(pack));
    if (attempt.branch == Attempt::Branch::pass && iteration == 0 && !(norm <= attempt.largest_correction)) {
      return pack.failed(Code::branch_unknown, norm, lane_that_moved_most(pack));
    }
    if (attempt.branch == Attempt::Branch::inside && work_.group_class.quadratic && iteration == 0) {
      if (const Status s = guard_.check_first_correction(pack); !s.ok()) return s;
    }
    // Where no ball guards the branch, each correction must be at most a tenth of the one before.
    const bool must_contract = attempt.branch == Attempt::Branch::pass ||
                               (!work_.group_class.quadratic && attempt.branch != Attempt::Branch::anywhere);
    bool contracts = iteration == 0 || norm <= kContraction * last_norm || relative <= kRoundingLevel;
    if (must_contract && attempt.iterations == 0 && !contracts) {
      // Corrections by rounding do not contract, and they look large if the terms of an equation vanish here.
      contracts = raised_ratio() <= kRoundingLevel;
      if (!contracts) return pack.failed(Code::not_converged, norm / last_norm, lane_that_moved_most(pack));
    }
    // Factors of another posture are kept as long as the corrections contract.
    usable = (settings_.once || settings_.reuse != Reuse::fresh) && contracts;
    last_norm = norm;
    before = relative;
    work_.evaluate(x);
    counters.evaluated_equations += evaluated;
    relative = work_.kernels.largest_ratio(work_.phi.data(), inverse_scale_.data(), work_.program.n);
  }
  counters.most_iterations = std::max<std::int64_t>(counters.most_iterations, iteration);
  if (relative > kConverged) relative = raised_ratio();
  errors.position = std::max(errors.position, relative);
  return {};
}

// The lane with the largest relative residual, of an attempt that failed: its equations are scaled here.
std::int32_t NewtonStep::lane_with_most_left(const Pack& pack) {
  for (std::size_t i = 0; i < work_.phi.size(); ++i) work_.phi[i] *= inverse_scale_[i];
  return work_.lane_with_most(pack, work_.phi);
}

// Relative residual after the scales of the equations were raised to their lower bounds at this posture.
double NewtonStep::raised_ratio() {
  std::fill(work_.scale.begin(), work_.scale.end(), 0.0);
  work_.evaluator->raise_scale(work_.scale.data());
  for (std::size_t i = 0; i < work_.scale.size(); ++i) {
    if (work_.scale[i] > 0) inverse_scale_[i] = std::min(inverse_scale_[i], 1 / work_.scale[i]);
  }
  return work_.kernels.largest_ratio(work_.phi.data(), inverse_scale_.data(), work_.program.n);
}

// x -= correction_; returns its largest element.
double NewtonStep::correct(double* x) {
  double norm = 0;
  for (std::int32_t b = 0; b < work_.program.blocks; ++b) {
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
