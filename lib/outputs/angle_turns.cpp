#include "outputs/angle_turns.hpp"

#include <algorithm>
#include <cmath>

#include "index.hpp"
#include "numbers.hpp"

namespace assur {
namespace {

constexpr double kNoise = 1e-12;  // relative to the terms of a vector: a shorter vector has no direction
constexpr std::size_t kRows = 5;  // members of Arms

}  // namespace

double whole_turns(double from, double to) { return std::round((to - from) / kTurn); }

AngleTurns::AngleTurns(std::span<const OutputProgram> outputs)
    : outputs_(outputs), columns_(outputs[0].angles()), count_(columns_.size() * outputs.size()) {
  for (LaneArray* v : {&turns_, &bows_, &bends_, &strays_, &nothing_}) v->resize(padded(count_));
  for (LaneArray* v : {&now_, &next_, &probe_}) v->resize(kRows * padded(count_));
}

Arms AngleTurns::arms(LaneArray& of) const {
  double* const at = of.data();
  const std::size_t n = padded(count_);
  return {at, at + n, at + 2 * n, at + 3 * n, at + 4 * n};
}

void AngleTurns::find_arms(const double* q, LaneArray& to) {
  if (steps_ != nullptr && steps_->arms(q, to.data())) return;
  const Arms at = arms(to);
  const std::size_t w = outputs_.size();
  for (std::size_t i = 0; i < count_; ++i) outputs_[i % w].arm(i / w, q + i % w, at.x[i], at.y[i]);
}

void AngleTurns::start(const double* q) {
  if (empty()) return;
  (void)follow(q, 0, nothing_, 0);
  accept(0);
  std::fill_n(arms(now_).speed, count_, -1.0);
  std::fill(turns_.begin(), turns_.end(), 0.0);
}

AngleTurns::Followed AngleTurns::follow(const double* q, double seconds, std::span<const double> times,
                                        std::size_t used) {
  if (empty()) return {};
  find_arms(q, next_);
  const std::size_t w = outputs_.size();
  const bool bends = std::any_of(times.begin(), times.end(), [](double t) { return t != 0; });
  for (std::size_t lane = 0; lane < w && bends; ++lane) {
    const double t = times[lane];
    for (std::size_t i = lane; i < count_; i += w) bends_[i] = t == 0 ? 0 : t * t * bows_[i];
  }
  const Arms from = arms(now_), to = arms(next_);
  if (kernels_->follow(count_, from, to, seconds, bends ? bends_.data() : nothing_.data(), strays_.data())) {
    return {};
  }
  Followed found;
  for (std::size_t lane = 0; lane < used && found.turned == Turned::known; ++lane) {
    for (std::size_t i = lane; i < count_ && found.turned != Turned::unknown; i += w) {
      if (strays_[i] == 0) continue;
      const double longest = std::sqrt(std::max(from.square[i], to.square[i]));
      const bool is_noise = longest <= kNoise * outputs_[lane].size_of_arm(i / w, q + lane);
      found = {is_noise ? Turned::none : Turned::unknown, lane};
    }
  }
  return found;
}

void AngleTurns::measure(const double* q, std::span<double* const> probes, std::span<double> scratch,
                         std::size_t lane) {
  if (empty()) return;
  std::fill(bows_.begin(), bows_.end(), 0.0);
  const Arms now = arms(now_), there = arms(probe_);
  for (const double* const probe : probes) {
    for (std::size_t a = lane; a < scratch.size(); ++a) scratch[a] = q[a - lane] + probe[a];
    find_arms(scratch.data() + lane, probe_);
    for (std::size_t i = 0; i < count_; ++i) {
      bows_[i] += std::hypot(there.x[i] - now.x[i], there.y[i] - now.y[i]);
    }
  }
  for (double& bow : bows_) bow *= bow;
}

void AngleTurns::accept(double seconds) {
  if (empty()) return;
  kernels_->turn(count_, arms(now_), arms(next_), seconds, turns_.data());
}

void AngleTurns::continue_from(std::span<const double> row, std::size_t lane) {
  const Arms now = arms(now_);
  for (std::size_t i = lane; i < count_; i += outputs_.size()) {
    turns_[i] = whole_turns(std::atan2(now.y[i], now.x[i]), row[columns_[i / outputs_.size()]]);
  }
}

void AngleTurns::save(Snapshot& into) const {
  into.now = now_;
  into.turns = turns_;
  into.bows = bows_;
}

void AngleTurns::restore(const Snapshot& from) {
  now_ = from.now;
  turns_ = from.turns;
  bows_ = from.bows;
}

}  // namespace assur
