// The six legs of `stewart` written by hand: groups/klu or groups/lapack without the code of assur around KLU or
// LAPACK. It runs without checks or with the checks of the simulator: residuals relative to their terms, residuals of
// the linear systems, and the ball in which the branch cannot change (lib/groups/branch.hpp; here one ball for a whole
// leg).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "assur/scene.hpp"
#include "leg_by_hand.hpp"

namespace assur::bench {

inline std::string leg_name(const char* name, int leg) { return name + std::to_string(leg + 1); }

enum class Checks : std::uint8_t { none, as_the_library };

template <class Bare, Checks kChecks>
class LegsByHand {
 public:
  using Unknowns = LegByHand::Unknowns;
  static constexpr int kLegs = 6;

  // Starts at the posture of `start`: start.value(name, d) is the d-th derivative of a point or vector.
  template <class Start>
  LegsByHand(const Scene& scene, const Start& start) {
    const auto at = [](const auto& all, const std::string& name) {
      return std::find_if(all.begin(), all.end(), [&](const auto& x) { return x.name == name; });
    };
    const Body& terminal = scene.bodies().at(0);
    for (int k = 0; k < kLegs; ++k) {
      Leg& leg = legs_.emplace_back(LegByHand(
          values(at(scene.points(), leg_name("A", k))->at), values(at(scene.vectors(), leg_name("a", k))->at),
          values(at(terminal.points, leg_name("P", k))->local), values(at(terminal.vectors, leg_name("t", k))->local)));
      for (int d = 0; d < 3; ++d) {
        auto* to = (d == 0 ? leg.q : d == 1 ? leg.v : leg.a).data();
        for (const char* name : {"B", "e", "r", "c", "d"}) {
          const Vec x = start.value(leg_name(name, k), d);
          to = std::copy(x.begin(), x.end(), to);
        }
      }
      predict(leg, scene.time().step, true);
    }
  }

  // Inputs: the terminal with both derivatives at the time of the step. The next step is dt later.
  bool step(const Terminal& value, const Terminal& rate, const Terminal& acceleration, double dt) {
    iterations_ = 0;
    for (Leg& leg : legs_) {
      leg.equations.set_inputs(value);
      if (!newton(leg) || !leg.solver->factorize(leg.jacobian.data())) return false;
      if constexpr (kChecks != Checks::none) leg.norm = norm_of_jacobian(leg);
      leg.equations.velocity(rate, right_);
      if (!linear(leg, leg.v, velocity_error_)) return false;
      leg.equations.acceleration(leg.v, acceleration, right_);
      if (!linear(leg, leg.a, acceleration_error_)) return false;
      if constexpr (kChecks != Checks::none) {
        if (!stays_in_ball(leg)) return false;
      }
      predict(leg, dt, false);
    }
    return true;
  }

  // Only the calls of KLU or LAPACK in such a step: two factorisations and three solutions for each leg.
  bool calls() {
    bool ok = true;
    for (Leg& leg : legs_) {
      for (int solutions : {1, 2}) {
        ok = leg.solver->factorize(leg.jacobian.data()) && ok;
        for (int i = 0; i < solutions; ++i) {
          correction_ = leg.last_v;
          ok = leg.solver->solve(correction_.data()) && ok;
        }
      }
    }
    return ok;
  }

  [[nodiscard]] std::int64_t iterations() const { return iterations_; }  // of all legs in the last step
  [[nodiscard]] std::int64_t balls() const { return balls_; }            // measured so far
  [[nodiscard]] double worst_error() const { return std::max({position_error_, velocity_error_, acceleration_error_}); }
  // Position of B of a leg after the last step.
  [[nodiscard]] Vec B(int leg) const {
    const Unknowns& q = legs_[static_cast<std::size_t>(leg)].last_q;
    return {q[0], q[1], q[2]};
  }

 private:
  struct Leg {
    explicit Leg(const LegByHand& leg)
        : equations(leg),
          solver(std::make_unique<Bare>(LegByHand::pattern())),
          jacobian(LegByHand::pattern().row.size()) {}
    LegByHand equations;
    std::unique_ptr<Bare> solver;
    std::vector<double> jacobian;           // of the last evaluation
    double norm = 0;                        // of the Jacobian, maximum norm
    Unknowns q{}, v{}, a{};                 // of the current step: q is the prediction before the step
    Unknowns last_q{}, last_v{}, last_a{};  // of the last step
    LegByHand::Reads anchor{};              // centre of the ball
    double omega = 0, ball_used = 1;        // no ball yet
  };

  // The same criterion as in the library, so that both take the same iterations.
  static constexpr double kConverged = 8 * std::numeric_limits<double>::epsilon();
  static constexpr double kRoundingLevel = 1e-12;
  static constexpr int kMostIterations = 12;
  static constexpr double kKantorovich = 0.25, kBall = 0.7;

  bool newton(Leg& leg) {
    double worst = evaluate(leg, true);
    for (int k = 0; !(worst <= kConverged); ++k) {
      if (k == kMostIterations || !leg.solver->factorize(leg.jacobian.data())) return false;
      correction_ = phi_;
      if (!leg.solver->solve(correction_.data())) return false;
      for (std::size_t i = 0; i < leg.q.size(); ++i) leg.q[i] -= correction_[i];
      if constexpr (kChecks != Checks::none) {
        // If the posture is outside the ball, a new ball is measured after the step, as in the library's side of the
        // benchmark.
        if (k == 0 && leg.omega * largest(correction_) > kKantorovich * (1 - leg.ball_used)) leg.ball_used = 1;
      }
      ++iterations_;
      const double before = worst;
      worst = evaluate(leg, false);
      if (worst <= kRoundingLevel && worst > before / 4) break;
    }
    position_error_ = std::max(position_error_, worst);
    return true;
  }

  // The largest residual: absolute, or relative to the terms at the prediction.
  double evaluate(Leg& leg, bool at_prediction) {
    leg.equations.evaluate(leg.q, phi_, leg.jacobian.data());
    if constexpr (kChecks == Checks::none) return largest(phi_);
    if (at_prediction) {
      leg.equations.scale(leg.q, inverse_scale_);
      for (double& scale : inverse_scale_) scale = 1 / scale;
    }
    double worst = 0;
    for (std::size_t i = 0; i < phi_.size(); ++i) worst = std::max(worst, std::abs(phi_[i]) * inverse_scale_[i]);
    return worst;
  }

  // x = J^-1 right_, and its normwise residual.
  bool linear(Leg& leg, Unknowns& x, double& error) {
    x = right_;
    if (!leg.solver->solve(x.data())) return false;
    if constexpr (kChecks == Checks::none) return true;
    Unknowns rest = right_;
    std::size_t k = 0;
    for (std::size_t j = 0; j < x.size(); ++j) {
      for (const auto end = static_cast<std::size_t>(pattern_.column_start[j + 1]); k < end; ++k) {
        rest[static_cast<std::size_t>(pattern_.row[k])] -= leg.jacobian[k] * x[j];
      }
    }
    const double against = leg.norm * largest(x) + largest(right_);
    const double residual = against > 0 ? largest(rest) / against : 0;
    error = std::max(error, residual);
    return std::isfinite(residual);
  }

  double norm_of_jacobian(const Leg& leg) const {
    Unknowns sum{};
    for (std::size_t k = 0; k < leg.jacobian.size(); ++k) {
      sum[static_cast<std::size_t>(pattern_.row[k])] += std::abs(leg.jacobian[k]);
    }
    return largest(sum);
  }

  // Measures a new ball if the next step of this length would leave the current one.
  bool stays_in_ball(Leg& leg) {
    const LegByHand::Reads now = leg.equations.reads(leg.q);
    double moved = 0;
    for (std::size_t i = 0; i < now.size(); ++i) moved = std::max(moved, std::abs(now[i] - leg.anchor[i]));
    const double used = leg.omega * moved, before = std::exchange(leg.ball_used, used);
    if (before < 1 && used + 2 * std::max(used - before, 0.0) <= kBall) return true;
    ++balls_;
    leg.anchor = now;
    leg.ball_used = 0;
    Unknowns sum{};  // rows of |J^-1| k
    for (std::size_t c = 0; c < sum.size(); ++c) {
      if (LegByHand::kLipschitz[c] == 0) continue;
      correction_.fill(0);
      correction_[c] = LegByHand::kLipschitz[c];
      if (!leg.solver->solve(correction_.data())) return false;
      for (std::size_t r = 0; r < sum.size(); ++r) sum[r] += std::abs(correction_[r]);
    }
    leg.omega = largest(sum);
    return std::isfinite(leg.omega);
  }

  // Accepts the current posture and predicts the next one: by the quintic through the last two postures with their
  // rates and accelerations, for equal steps; after the first step by a Taylor series.
  void predict(Leg& leg, double h, bool first) {
    const Unknowns q = leg.q;
    for (std::size_t i = 0; i < q.size(); ++i) {
      leg.q[i] = first ? q[i] + h * leg.v[i] + h * h / 2 * leg.a[i]
                       : 32 * q[i] - 31 * leg.last_q[i] - h * (16 * leg.v[i] + 14 * leg.last_v[i]) +
                             h * h * (4 * leg.a[i] - 2 * leg.last_a[i]);
    }
    leg.last_q = q, leg.last_v = leg.v, leg.last_a = leg.a;
  }

  static double largest(const Unknowns& x) {
    double norm = 0;
    for (const double value : x) norm = std::abs(value) <= norm ? norm : std::abs(value);
    return norm;
  }

  const Pattern pattern_ = LegByHand::pattern();
  std::vector<Leg> legs_;
  Unknowns phi_{}, correction_{}, right_{}, inverse_scale_{};
  std::int64_t iterations_ = 0, balls_ = 0;
  double position_error_ = 0, velocity_error_ = 0, acceleration_error_ = 0;
};

}  // namespace assur::bench
