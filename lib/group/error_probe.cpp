// Effect of errors in a group's inputs, of its residuals and of its rounding on its unknowns, to first order. With
// q = (unknowns, inputs), Phi quadratic and e the perturbation of each right-hand side, differentiating
//   Phi(q) = 0,  Phi' q' = 0,  Phi' q'' + Phi''[q', q'] = 0
// along an error (d, d', d'') of posture, velocity and acceleration gives
//   Phi' d = e0,  Phi' d' = e1 - Phi''[d, q'],  Phi' d'' = e2 - Phi''[d, q''] - 2 Phi''[d', q'].
// For callbacks the terms with third derivatives are missing.
#include "group/error_probe.hpp"

#include <algorithm>
#include <cmath>

#include "backends/residual.hpp"
#include "group/step_rules.hpp"
#include "numbers.hpp"
#include "signals/random_sign.hpp"

namespace assur {
namespace {

constexpr double kHalfEps = kEps / 2;

}  // namespace

ErrorProbe::ErrorProbe(Workspace& work, JacobianSolver& solver, BlockConditions& blocks)
    : work_(work), solver_(solver), blocks_(blocks) {
  for (LaneArray* v : {&residual_, &noise_, &tolerance_, &error_, &bent_, &moved_, &whole_}) v->resize(work_.size());
  for (LaneArray* v : {&input_errors_, &moved_inputs_, &resting_inputs_}) v->resize(work_.inputs.size());
}

bool ErrorProbe::perturb(Pack& pack, const double* const (&state)[3], Probes probes, std::uint64_t seed) {
  solver_.choose(pack);
  work_.set_inputs(pack, state[0]);
  const double* const x = state[0] + pack.unknowns;
  work_.evaluate(x);
  work_.evaluator->scale(tolerance_.data());
  work_.evaluator->raise_scale(tolerance_.data());
  work_.evaluator->rounding(noise_.data());
  if (!solver_.factorize(pack)) return false;

  const std::size_t size = work_.phi.size();
  for (std::size_t i = 0; i < size; ++i) work_.phi[i] = -work_.phi[i];
  round_unknowns(x);
  bool finite = error_of(pack, work_.phi, probes, 0, seed, {});
  if (work_.group_class.derivatives == 0) return finite;

  work_.gather(pack, state[1], work_.input_rates);
  work_.evaluator->velocity_rhs(work_.input_rates.data(), work_.rhs.data());
  const double* const rate = solution(pack, state[1], 1);
  left_of(rate);
  finite = finite && error_of(pack, residual_, probes, 1, seed, {{0, rate, &work_.input_rates, 1}});
  if (work_.group_class.derivatives == 1) return finite;

  work_.evaluator->velocity_rhs(work_.input_rates.data(), work_.rhs.data());
  work_.gather(pack, state[2], work_.input_accelerations);
  work_.evaluator->acceleration_rhs(rate, work_.input_accelerations.data(), work_.rhs.data());
  const double* const acceleration = solution(pack, state[2], 2);
  left_of(acceleration);
  return finite && error_of(pack, residual_, probes, 2, seed,
                            {{0, acceleration, &work_.input_accelerations, 1}, {1, rate, &work_.input_rates, 2}});
}

GroupHealth ErrorProbe::examine(Pack& pack, const double* state) {
  solver_.choose(pack);
  work_.set_inputs(pack, state);
  work_.evaluate(state + pack.unknowns);
  work_.evaluator->scale(noise_.data());
  work_.evaluator->raise_scale(noise_.data());
  const bool regular = solver_.factorize(pack);
  GroupHealth health;
  for (std::size_t i = 0; i < work_.phi.size(); ++i) {
    double& worst = health.residual[i % idx(work_.lanes)];
    worst = std::max(worst, std::abs(work_.phi[i]) / (noise_[i] > 0 ? noise_[i] : 1));
  }
  std::array<double, kMostLanes> condition{};
  for (std::int32_t b = 0; b < work_.program.blocks; ++b) {
    if (!regular && blocks_.needs_solver(b)) {
      condition.fill(kInfinity);
    } else {
      const BlockConditions::Weights both{noise_.data(), noise_.data()};
      blocks_.measure(b, work_.jacobian.data(), both, solver_.at_hand(), {condition.data(), condition.data()});
    }
    for (std::size_t l = 0; l < kMostLanes; ++l) health.condition[l] = std::max(health.condition[l], condition[l]);
  }
  return health;
}

// The solution of the step. If the step solved only for the wanted unknowns, the whole solution is computed from rhs.
const double* ErrorProbe::solution(const Pack& pack, const double* state, int derivative) {
  if (work_.group_class.first_wanted == 0 || derivative != work_.group_class.derivatives) return state + pack.unknowns;
  whole_ = work_.rhs;
  (void)solver_.at_hand()->solve(whole_, 1);
  return whole_.data();
}

// noise_ bounds the rounding of Phi over epsilon / 2. It becomes the size of the perturbations with random signs: twice
// that bound, plus the residual that the rounding of the unknowns causes. That rounding differs from step to step; the
// inputs count as exact.
void ErrorProbe::round_unknowns(const double* x) {
  for (std::size_t i = 0; i < noise_.size(); ++i) residual_[i] = 2 * noise_[i];
  subtract_product(system(), {x, noise_.size()}, residual_, noise_);
  for (double& e : noise_) e *= kHalfEps / kSumRounding;
}

// residual_ = rhs - J y; noise_ and tolerance_ become the size of its terms.
void ErrorProbe::left_of(const double* y) {
  residual_ = work_.rhs;
  subtract_product(system(), {y, residual_.size()}, residual_, noise_);
  tolerance_ = noise_;
}

// Computes the d-th derivative of every probe. left: residual of the equations.
bool ErrorProbe::error_of(Pack& pack, const LaneArray& left, Probes probes, int derivative, std::uint64_t seed,
                          std::initializer_list<Bend> bends) {
  bool finite = true;
  for (std::size_t k = 0; k < probes.size(); ++k) {
    const auto d = static_cast<std::size_t>(derivative);
    work_.gather(pack, probes[k].errors[d], input_errors_);
    work_.evaluator->velocity_rhs(input_errors_.data(), error_.data());
    for (const Bend& bend : bends) add_bend(pack, probes[k].errors[bend.probe], bend);
    if (probes[k].cause == Probe::Cause::left) {
      for (std::size_t i = 0; i < error_.size(); ++i) error_[i] += left[i];
    } else {
      RandomSign sign(seed + (pack.unknowns * 3 + d) * probes.size() + k);
      const LaneArray& size = probes[k].cause == Probe::Cause::rounding ? noise_ : tolerance_;
      for (std::size_t i = 0; i < error_.size(); ++i) error_[i] += sign() * kSumRounding * size[i];
    }
    if (!solver_.at_hand()->solve(error_, 1).ok()) return false;
    for (const double e : error_) finite = finite && std::isfinite(e);
    std::copy(error_.begin(), error_.end(), probes[k].errors[d] + pack.unknowns);
  }
  return finite;
}

// error_ -= times * Phi''[probe, direction], from the curvatures along the sum and the difference of both. Both are
// scaled to size 1 in every lane, because their squares may overflow.
void ErrorProbe::add_bend(const Pack& pack, const double* probe, const Bend& bend) {
  const std::size_t w = idx(work_.lanes), n = idx(work_.program.n);
  work_.gather(pack, probe, input_errors_);
  const auto measure = [&](const double* values, std::size_t count, std::array<double, kMostLanes>& largest) {
    for (std::size_t i = 0; i < count * w; ++i) largest[i % w] = std::max(largest[i % w], std::abs(values[i]));
  };
  std::array<double, kMostLanes> direction{}, error{};
  measure(bend.direction, n, direction);
  measure(bend.inputs->data(), idx(work_.program.inputs), direction);
  measure(probe + pack.unknowns, n, error);
  measure(input_errors_.data(), idx(work_.program.inputs), error);
  const auto part = [](double value, double size) { return size > 0 ? value / size : 0; };
  for (const double side : {1.0, -1.0}) {
    for (std::size_t i = 0; i < n * w; ++i) {
      moved_[i] = part(bend.direction[i], direction[i % w]) + side * part(probe[pack.unknowns + i], error[i % w]);
    }
    for (std::size_t i = 0; i < input_errors_.size(); ++i) {
      moved_inputs_[i] = part((*bend.inputs)[i], direction[i % w]) + side * part(input_errors_[i], error[i % w]);
    }
    work_.evaluator->velocity_rhs(moved_inputs_.data(), bent_.data());
    work_.evaluator->acceleration_rhs(moved_.data(), resting_inputs_.data(), bent_.data());
    for (std::size_t i = 0; i < bent_.size(); ++i) {
      error_[i] += side * bend.times * bent_[i] / 4 * direction[i % w] * error[i % w];
    }
  }
}

}  // namespace assur
