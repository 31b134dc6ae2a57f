// Effect of errors in a group's inputs, of its residuals and of its rounding on its unknowns, to first order. With
// q = (unknowns, inputs), Phi quadratic and e the perturbation of each right-hand side, differentiating
//   Phi(q) = 0,  Phi' q' = 0,  Phi' q'' + Phi''[q', q'] = 0
// along an error (d, d', d'') of posture, velocity and acceleration gives
//   Phi' d = e0,  Phi' d' = e1 - Phi''[d, q'],  Phi' d'' = e2 - Phi''[d, q''] - 2 Phi''[d', q'].
// For callbacks the terms with third derivatives are missing.
#include "groups/error_probe.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "backends/residual.hpp"
#include "numbers.hpp"
#include "outputs/random_sign.hpp"
#include "program/step_rules.hpp"

namespace assur {
namespace {

constexpr double kHalfEps = kEps / 2;    // rounding of one operation
constexpr std::size_t kVectorLanes = 8;  // probes of one lane that are computed side by side

}  // namespace

ErrorProbe::ErrorProbe(const System& system, Workspace& work, JacobianSolver& solver, BlockConditions& blocks)
    : work_(work),
      solver_(solver),
      blocks_(blocks),
      side_by_side_(work.group_class.quadratic() ? std::max<std::size_t>(kVectorLanes / idx(work.lanes), 1) : 1),
      lanes_(idx(work.lanes)),
      size_(work.size()),
      evaluator_(side_by_side_ > 1 ? make_evaluator(system, work.group_class, static_cast<int>(kVectorLanes))
                                   : nullptr),
      coded_(work) {
  for (LaneArray* v : {&residual_, &noise_, &tolerance_, &whole_}) v->resize(size_);
  for (LaneArray* v : {&rhs_, &error_, &bent_, &probe_, &direction_}) v->resize(size_ * side_by_side_);
  for (LaneArray* v : {&input_errors_, &input_direction_}) v->resize(work_.inputs.size() * side_by_side_);
  if (evaluator_ == nullptr) return;
  coefficients_.resize((idx(one_coefficient(work.group_class)) + 1) * lanes_ * side_by_side_);
  inputs_.resize(input_errors_.size());
  unknowns_.resize(error_.size());
}

bool ErrorProbe::perturb(Pack& pack, const double* const (&state)[3], Probes probes, const Unseen& unseen,
                         std::uint64_t seed) {
  unseen_ = unseen;
  solver_.choose(pack);
  work_.set_inputs(pack, state[0]);
  const double* const x = state[0] + pack.unknowns;
  work_.evaluate(x);
  work_.evaluator->scale(tolerance_.data());
  work_.evaluator->raise_scale(tolerance_.data());
  work_.evaluator->rounding(noise_.data());
  if (!solver_.factorize(pack)) return false;
  if (evaluator_ != nullptr) {
    repeat(pack.coefficients.data(), coefficients_);
    repeat(work_.inputs.data(), inputs_);
    repeat(x, unknowns_);
    evaluator_->set_inputs(coefficients_.data(), inputs_.data());
    evaluator_->evaluate(unknowns_.data(), error_.data(), nullptr);
  }
  for (std::size_t i = 0; i < size_; ++i) work_.phi[i] = -work_.phi[i];
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

// An error of the inputs along their motion is an error of the time, which the posture on a change point follows like any
// other. Across it, it would separate the branches: their crossing counts as exact, and its own error is what both sides
// say.
void ErrorProbe::perturb(const Pack& pack, const ChangePointPosture& posture, const double* const (&state)[3],
                         Probes probes, std::uint64_t seed) const {
  const std::size_t w = lanes_, n = size_ / w, inputs = pack.inputs.size() / w;
  const double* const of[4] = {posture.values.data(), posture.values.data() + size_, posture.values.data() + 2 * size_,
                               posture.values.data() + 3 * size_};
  for (std::size_t k = 0; k < probes.size(); ++k) {
    const auto& errors = probes[k].errors;
    RandomSign sign(seed + pack.unknowns * probes.size() + k);
    for (std::size_t l = 0; l < w; ++l) {
      double speed = 0, time = 0, rate = 0, acceleration = 0;
      const auto each_input = [&](const auto& work) {
        for (std::size_t i = 0; i < inputs; ++i) work(idx(pack.inputs[i * w + l]));
      };
      each_input([&](std::size_t a) {
        speed += state[1][a] * state[1][a];
        time += errors[0][a] * state[1][a];
      });
      if (speed > 0) time /= speed;
      each_input([&](std::size_t a) { rate += (errors[1][a] - state[2][a] * time) * state[1][a]; });
      if (speed > 0) rate /= speed;
      each_input([&](std::size_t a) { acceleration += (errors[2][a] - 2 * state[2][a] * rate) * state[1][a]; });
      if (speed > 0) acceleration /= speed;
      for (std::size_t i = 0; i < n; ++i) {
        const std::size_t at = i * w + l;
        const double side = probes[k].cause == Probe::Cause::rounding ? sign() : 0;
        const auto [in_posture, in_rate, in_acceleration] = posture.errors;
        errors[0][pack.unknowns + at] = of[1][at] * time + side * in_posture;
        errors[1][pack.unknowns + at] = of[2][at] * time + of[1][at] * rate + side * in_rate;
        errors[2][pack.unknowns + at] =
            of[3][at] * time + 2 * of[2][at] * rate + of[1][at] * acceleration + side * in_acceleration;
      }
    }
  }
}

bool ErrorProbe::follow(Pack& pack, const double* posture, std::span<double* const> changes) {
  solver_.choose(pack);
  if (coded_.follow(pack, *solver_.at_hand(), posture, changes)) return true;
  work_.set_inputs(pack, posture);
  work_.evaluate(posture + pack.unknowns);
  solver_.new_jacobian();
  if (!solver_.factorize(pack)) return false;
  Counters outside_of_steps;
  for (double* const change : changes) {
    work_.gather(pack, change, work_.input_rates);
    work_.evaluator->velocity_rhs(work_.input_rates.data(), work_.rhs.data());
    if (!solver_.correction(pack, work_.rhs, change + pack.unknowns, true, outside_of_steps).ok()) return false;
  }
  return true;
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
  for (std::int32_t b = 0; b < work_.group_class.blocks; ++b) {
    if (!regular && blocks_.is_large(b)) {
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

// Calls work(W), with small W as constants, so that loops over lanes unroll. Probes side by side fill kVectorLanes.
template <class Work>
void ErrorProbe::with_lanes(const Work& work) const {
  switch (lanes_) {
    case 1:
      return work(std::integral_constant<std::size_t, 1>());
    case 2:
      return work(std::integral_constant<std::size_t, 2>());
    case 4:
      return work(std::integral_constant<std::size_t, 4>());
    default:
      return work(lanes_);
  }
}

// Copies the same numbers to the lanes of each probe.
void ErrorProbe::repeat(const double* from, LaneArray& to) const {
  if (side_by_side_ == 1) {
    std::copy_n(from, to.size(), to.begin());
    return;
  }
  with_lanes([&](auto w) {
    for (double* row = to.data(); row != to.data() + to.size(); from += w, row += kVectorLanes) {
      for (std::size_t l = 0; l < kVectorLanes; ++l) row[l] = from[l % w];
    }
  });
}

// Gathers the d-th derivative of the probes side by side; the missing ones are zero. unknowns: may be null.
void ErrorProbe::gather(const Pack& pack, Probes probes, std::size_t d, double* unknowns) {
  if (side_by_side_ == 1) {
    work_.gather(pack, probes[0].errors[d], input_errors_);
    if (unknowns != nullptr) std::copy_n(probes[0].errors[d] + pack.unknowns, size_, unknowns);
    return;
  }
  std::fill(input_errors_.begin(), input_errors_.end(), 0.0);
  with_lanes([&](auto w) {
    for (std::size_t k = 0; k < probes.size(); ++k) {
      const double* const errors = probes[k].errors[d];
      for (std::size_t i = 0, at = k * w; i < pack.inputs.size(); i += w, at += kVectorLanes) {
        for (std::size_t l = 0; l < w; ++l) input_errors_[at + l] = errors[pack.inputs[i + l]];
      }
      if (unknowns == nullptr) continue;
      const double* const own = errors + pack.unknowns;
      double* to = unknowns + k * w;
      for (std::size_t i = 0; i < size_; i += w, to += kVectorLanes) {
        for (std::size_t l = 0; l < w; ++l) to[l] = own[i + l];
      }
    }
  });
}

// Computes the d-th derivative of every probe. left: residual of the equations.
bool ErrorProbe::error_of(Pack& pack, const LaneArray& left, Probes probes, int derivative, std::uint64_t seed,
                          std::initializer_list<Bend> bends) {
  const auto d = static_cast<std::size_t>(derivative);
  for (std::size_t first = 0; first < probes.size(); first += side_by_side_) {
    const Probes some = probes.subspan(first, std::min(side_by_side_, probes.size() - first));
    gather(pack, some, d, nullptr);
    evaluator().velocity_rhs(input_errors_.data(), error_.data());
    for (const Bend& bend : bends) add_bend(pack, some, bend);
    double* e = rhs_.data();
    for (std::size_t k = 0; k < some.size(); ++k) {
      const bool is_left = some[k].cause == Probe::Cause::left;
      RandomSign sign(seed + (pack.unknowns * 3 + d) * probes.size() + first + k);
      const bool rounds = some[k].cause == Probe::Cause::rounding;
      const double of_noise = rounds ? kSumRounding : 0;
      with_lanes([&](auto w) {
        const double* from = error_.data() + k * w;
        for (std::size_t i = 0; i < size_; from += side_by_side_ * w) {
          for (std::size_t l = 0; l < w; ++l, ++i) {
            const double of_tolerance = rounds ? unseen_[l] : kSumRounding;
            *e++ = from[l] + (is_left ? left[i] : sign() * (of_noise * noise_[i] + of_tolerance * tolerance_[i]));
          }
        }
      });
    }
    const std::span<double> all(rhs_.data(), some.size() * size_);
    if (!solver_.at_hand()->solve(all, static_cast<int>(some.size())).ok()) return false;
    for (const double value : all) {
      if (!std::isfinite(value)) return false;
    }
    for (std::size_t k = 0; k < some.size(); ++k) {
      std::copy_n(all.data() + k * size_, size_, some[k].errors[d] + pack.unknowns);
    }
  }
  return true;
}

// error_ -= times * Phi''[probe, direction].
void ErrorProbe::add_bend(const Pack& pack, Probes probes, const Bend& bend) {
  gather(pack, probes, bend.probe, probe_.data());
  repeat(bend.direction, direction_);
  repeat(bend.inputs->data(), input_direction_);
  evaluator().subtract_bend({direction_.data(), input_direction_.data()}, {probe_.data(), input_errors_.data()},
                            bend.times, bent_.data(), error_.data());
}

}  // namespace assur
