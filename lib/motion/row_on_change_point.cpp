// Rows of the time grid on a change point, or so close to it that rounding spoils them.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "index.hpp"
#include "motion/continuation.hpp"
#include "motion/two_sided_limit.hpp"
#include "numbers.hpp"

namespace assur {
namespace {

constexpr double kFarthest = 0.5;  // first reach: so far (characteristic lengths, or rad) the fastest coordinate moves
constexpr int kReaches = 8;        // each half of the one before
constexpr double kBeside = 1.0 / 64;  // part of the reach: largest distance of the row from the change point
constexpr double kJump = 1.0 / 16;  // part of the reach: the step over the change point begins and ends so far from it
constexpr double kSmooth = 1e-3;    // largest gap between the limits of both sides, in parts of the move over the reach
constexpr double kExact = 1e-11;    // relative; smaller reaches are not tried if the errors are smaller

}  // namespace

// The packs that cross branches at t get the limits of both sides; all others are solved. On the way to the samples the
// drivers follow their expansions about t, so that the limits are those of a smooth motion, and no law is asked beyond
// t. False: the limits do not agree, or the drivers rest; the posture is unchanged.
bool Continuation::arrive_on_change_point(double t, double smallest) {
  const std::size_t at_fault = failed_pack_;
  const Pack& pack = packs_[at_fault];
  const std::size_t count = idx(levels_.solver(pack).group_class().n) * idx(levels_.solver(pack).lanes());
  double speed = 0, acceleration = 0;
  const auto raise = [](double& most, double by) { most = std::max(most, std::abs(by)); };
  for (std::size_t i = 0; i < count; ++i) raise(speed, state_.at(1)[pack.unknowns + i]);
  for (std::size_t i = 0; i < layout_.first_unknown; ++i) {
    raise(speed, state_.at(1)[i]);
    raise(acceleration, state_.at(2)[i]);
  }
  const double rate = speed + std::sqrt(acceleration);
  double reach = std::copysign(kFarthest / rate, t - now_);
  const auto is_beside = [&] { return std::isfinite(reach) && std::abs(t - now_) <= kBeside * std::abs(reach); };
  if (!is_beside()) return false;

  Snapshot here;
  save(here, false);
  std::vector<ChangePointPosture> best;
  double least = kInfinity;
  try {
    inputs_.expand_about(t);
    for (int k = 0; k < kReaches && is_beside(); ++k, reach /= 2) {
      std::vector<ChangePointPosture> postures;
      failed_pack_ = at_fault;
      const bool found = find_change_point(t, reach, smallest, postures);
      restore(here);
      if (!found) continue;
      double worst = 0;
      for (const ChangePointPosture& posture : postures) {
        const auto [in_posture, in_rate, in_acceleration] = posture.errors;
        worst = std::max({worst, in_posture, in_rate / rate, in_acceleration / (rate * rate)});
      }
      if (!(worst < least)) break;
      least = worst;
      best = std::move(postures);
      if (least <= kExact) break;
    }
    inputs_.follow();
  } catch (...) {  // from a callback
    inputs_.follow();
    restore(here);
    throw;
  }
  failed_pack_ = at_fault;
  if (best.empty()) return false;
  layout_.change_points = std::move(best);
  change_point_at_ = t;
  passes_ = false;
  const bool arrived = try_step(t, Attempt::Branch::inside).ok();
  passes_ = true;
  if (arrived) return true;
  restore(here);
  failed_pack_ = at_fault;
  return false;
}

// The limits at t of the packs that cross branches there, from samples up to `reach` seconds away.
bool Continuation::find_change_point(double t, double reach, double smallest,
                                     std::vector<ChangePointPosture>& postures) {
  constexpr std::size_t kSide = kLimitPlaces.size();
  const double change = now_;
  struct Posture {
    LaneArray values, rates;
  };
  std::array<Posture, TwoSidedLimit::kSamples> samples;
  const auto sample = [&](double place, Posture& at) {
    if (!walk(t + place * reach, smallest, change)) return false;
    at.values.assign(state_.at(0), state_.at(0) + layout_.size);
    at.rates.assign(state_.at(1), state_.at(1) + layout_.size);
    return true;
  };
  Snapshot here;
  save(here, false);
  if (!pass_by(kJump * reach, smallest, change + kJump * reach)) return false;
  const std::vector<std::uint8_t> cross = passed_;
  for (std::size_t k = 0; k < kSide; ++k) {
    if (!sample(kLimitPlaces[k], samples[kSide + k])) return false;
  }
  restore(here);
  for (std::size_t k = 0; k < kSide; ++k) {
    if (!sample(-kLimitPlaces[k], samples[k])) return false;
  }
  const TwoSidedLimit weights(reach);
  postures.resize(packs_.size());
  for (std::size_t p = 0; p < packs_.size(); ++p) {
    if (cross[p] == 0) continue;
    const GroupSolver& solver = levels_.solver(packs_[p]);
    const std::size_t size = idx(solver.group_class().n) * idx(solver.lanes());
    postures[p].values.resize(4 * size);
    std::array<double, 3> gap{};
    double move = 0;
    for (std::size_t i = 0; i < size; ++i) {
      std::array<double, TwoSidedLimit::kSamples> values{}, rates{};
      for (std::size_t k = 0; k < values.size(); ++k) {
        values[k] = samples[k].values[packs_[p].unknowns + i];
        rates[k] = samples[k].rates[packs_[p].unknowns + i];
      }
      const TwoSidedLimit::Limit limit = weights.of(values, rates);
      for (std::size_t d = 0; d < 4; ++d) postures[p].values[d * size + i] = limit.value[d];
      for (std::size_t d = 0; d < 3; ++d) {
        const double rounding = 4 * kEps * std::abs(limit.value[d]);
        postures[p].errors[d] = std::max({postures[p].errors[d], limit.error[d], rounding});
        gap[d] = std::max(gap[d], limit.gap[d]);
      }
      for (const double value : values) move = std::max(move, std::abs(value - limit.value[0]));
    }
    double unit = 1;  // reach^d
    for (const double g : gap) {
      if (!(g * unit <= kSmooth * move)) return false;
      unit *= std::abs(reach);
    }
  }
  return true;
}

void Continuation::leave_change_point() {
  if (std::isnan(change_point_at_)) return;
  layout_.change_points.assign(packs_.size(), {});
  change_point_at_ = kNan;
}

}  // namespace assur
