// How the errors of a group's inputs, of its residuals and of its rounding show in its unknowns, to first order. With
// q = (unknowns, inputs), Phi quadratic and e the perturbation of each right-hand side, differentiating
//   Phi(q) = 0,  Phi' q' = 0,  Phi' q'' + Phi''[q', q'] = 0
// along an error (d, d', d'') of posture, velocity and acceleration gives
//   Phi' d = e0,  Phi' d' = e1 - Phi''[d, q'],  Phi' d'' = e2 - Phi''[d, q''] - 2 Phi''[d', q'].
// Callbacks lack the terms of the third derivative.
#include <algorithm>
#include <cmath>

#include "group/group_solver.hpp"
#include "group/tolerances.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "signals/random_sign.hpp"

namespace assur {
namespace {

constexpr double kHalfEps = kEps / 2;

}  // namespace

bool GroupSolver::perturb(Pack& pack, const double* const (&state)[3], Probes probes, std::uint64_t seed) {
  choose_solver(pack);
  set_inputs(pack, state[0]);
  const double* const x = state[0] + pack.unknowns;
  evaluator_->evaluate(x, phi_.data(), jacobian_.data());
  evaluator_->scale(tolerance_.data());
  evaluator_->raise_scale(tolerance_.data());
  evaluator_->rounding(noise_.data());
  if (!solver_->factorize(jacobian_).ok()) return false;
  pack.factored = true;

  const std::size_t size = phi_.size();
  for (std::size_t i = 0; i < size; ++i) phi_[i] = -phi_[i];
  round_unknowns(x);
  bool finite = error_of(pack, phi_, probes, 0, seed, {});
  if (class_.derivatives == 0) return finite;

  gather(pack, state[1], input_rates_);
  evaluator_->velocity_rhs(input_rates_.data(), rhs_.data());
  const double* const rate = solution(pack, state[1], 1);
  left_of(rate);
  finite = finite && error_of(pack, residual_, probes, 1, seed, {{0, rate, &input_rates_, 1}});
  if (class_.derivatives == 1) return finite;

  evaluator_->velocity_rhs(input_rates_.data(), rhs_.data());
  gather(pack, state[2], input_accelerations_);
  evaluator_->acceleration_rhs(rate, input_accelerations_.data(), rhs_.data());
  const double* const acceleration = solution(pack, state[2], 2);
  left_of(acceleration);
  return finite && error_of(pack, residual_, probes, 2, seed,
                            {{0, acceleration, &input_accelerations_, 1}, {1, rate, &input_rates_, 2}});
}

GroupSolver::Health GroupSolver::examine(Pack& pack, const double* state) {
  choose_solver(pack);
  set_inputs(pack, state);
  evaluator_->evaluate(state + pack.unknowns, phi_.data(), jacobian_.data());
  evaluator_->scale(noise_.data());
  evaluator_->raise_scale(noise_.data());
  const bool regular = solver_->factorize(jacobian_).ok();
  pack.factored = regular;
  Health health;
  for (std::size_t i = 0; i < phi_.size(); ++i) {
    double& worst = health.residual[i % idx(lanes_)];
    worst = std::max(worst, std::abs(phi_[i]) / (noise_[i] > 0 ? noise_[i] : 1));
  }
  std::array<double, kMostLanes> condition{};
  for (std::int32_t b = 0; b < program_.blocks; ++b) {
    if (!regular && blocks_.needs_solver(b)) {
      condition.fill(kInfinity);
    } else {
      const BlockConditions::Weights both{noise_.data(), noise_.data()};
      blocks_.measure(b, jacobian_.data(), both, solver_, {condition.data(), condition.data()});
    }
    for (std::size_t l = 0; l < kMostLanes; ++l) health.condition[l] = std::max(health.condition[l], condition[l]);
  }
  return health;
}

// What the step solved for; where it stopped at those wanted, all of it, from rhs_.
const double* GroupSolver::solution(const Pack& pack, const double* state, int derivative) {
  if (class_.first_wanted == 0 || derivative != class_.derivatives) return state + pack.unknowns;
  whole_ = rhs_;
  (void)solver_->solve(whole_, 1);
  return whole_.data();
}

// noise_, a bound of the rounding of Phi over epsilon / 2, becomes what random signs are given to: twice that bound,
// and what the rounding of the unknowns themselves leaves in the equations. That differs from step to step; inputs are
// as they are.
void GroupSolver::round_unknowns(const double* x) {
  const std::size_t w = idx(lanes_);
  for (std::size_t r = 0; r < idx(program_.n); ++r) {
    for (std::size_t l = 0; l < w; ++l) {
      double sum = 2 * noise_[r * w + l];
      for (std::int32_t k = row_start_[r]; k < row_start_[r + 1]; ++k) {
        const RowEntry& e = row_entries_[idx(k)];
        sum += std::abs(jacobian_[idx(e.nonzero) * w + l] * x[idx(e.column) * w + l]);
      }
      noise_[r * w + l] = kHalfEps / kSumRounding * sum;
    }
  }
}

// residual_ = rhs_ - J y, and the size of its terms as noise_ and tolerance_.
void GroupSolver::left_of(const double* y) {
  const std::size_t w = idx(lanes_);
  for (std::size_t r = 0; r < idx(program_.n); ++r) {
    for (std::size_t l = 0; l < w; ++l) {
      double left = rhs_[r * w + l], size = std::abs(left);
      for (std::int32_t k = row_start_[r]; k < row_start_[r + 1]; ++k) {
        const RowEntry& e = row_entries_[idx(k)];
        const double term = jacobian_[idx(e.nonzero) * w + l] * y[idx(e.column) * w + l];
        left -= term;
        size += std::abs(term);
      }
      residual_[r * w + l] = left;
      noise_[r * w + l] = tolerance_[r * w + l] = size;
    }
  }
}

// The d-th derivative of every probe. left: what the equations are off by.
bool GroupSolver::error_of(Pack& pack, const LaneArray& left, Probes probes, int derivative, std::uint64_t seed,
                           std::initializer_list<Bend> bends) {
  bool finite = true;
  for (std::size_t k = 0; k < probes.size(); ++k) {
    const auto d = static_cast<std::size_t>(derivative);
    gather(pack, probes[k].errors[d], input_errors_);
    evaluator_->velocity_rhs(input_errors_.data(), error_.data());
    for (const Bend& bend : bends) add_bend(pack, probes[k].errors[bend.probe], bend);
    if (probes[k].cause == Probe::Cause::left) {
      for (std::size_t i = 0; i < error_.size(); ++i) error_[i] += left[i];
    } else {
      RandomSign sign(seed + (pack.unknowns * 3 + d) * probes.size() + k);
      const LaneArray& size = probes[k].cause == Probe::Cause::rounding ? noise_ : tolerance_;
      for (std::size_t i = 0; i < error_.size(); ++i) error_[i] += sign() * kSumRounding * size[i];
    }
    if (!solver_->solve(error_, 1).ok()) return false;
    for (const double e : error_) finite = finite && std::isfinite(e);
    std::copy(error_.begin(), error_.end(), probes[k].errors[d] + pack.unknowns);
  }
  return finite;
}

// error_ -= times * Phi''[probe, direction], from the curvatures along the sum and the difference of both, each scaled
// to size 1 in every lane: their squares may be beyond all numbers.
void GroupSolver::add_bend(const Pack& pack, const double* probe, const Bend& bend) {
  const std::size_t w = idx(lanes_), n = idx(program_.n);
  gather(pack, probe, input_errors_);
  const auto measure = [&](const double* values, std::size_t count, std::array<double, kMostLanes>& largest) {
    for (std::size_t i = 0; i < count * w; ++i) largest[i % w] = std::max(largest[i % w], std::abs(values[i]));
  };
  std::array<double, kMostLanes> direction{}, error{};
  measure(bend.direction, n, direction);
  measure(bend.inputs->data(), idx(program_.inputs), direction);
  measure(probe + pack.unknowns, n, error);
  measure(input_errors_.data(), idx(program_.inputs), error);
  const auto part = [](double value, double size) { return size > 0 ? value / size : 0; };
  for (const double side : {1.0, -1.0}) {
    for (std::size_t i = 0; i < n * w; ++i) {
      moved_[i] = part(bend.direction[i], direction[i % w]) + side * part(probe[pack.unknowns + i], error[i % w]);
    }
    for (std::size_t i = 0; i < input_errors_.size(); ++i) {
      moved_inputs_[i] = part((*bend.inputs)[i], direction[i % w]) + side * part(input_errors_[i], error[i % w]);
    }
    evaluator_->velocity_rhs(moved_inputs_.data(), bent_.data());
    evaluator_->acceleration_rhs(moved_.data(), resting_inputs_.data(), bent_.data());
    for (std::size_t i = 0; i < bent_.size(); ++i) {
      error_[i] += side * bend.times * bent_[i] / 4 * direction[i % w] * error[i % w];
    }
  }
}

}  // namespace assur
