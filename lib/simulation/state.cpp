#include "simulation/state.hpp"

#include <algorithm>
#include <cmath>

namespace assur {

void State::resize(std::size_t first_unknown, std::size_t size, const Predictor& predictor) {
  predictor_ = predictor;
  first_unknown_ = first_unknown;
  depth_ = static_cast<std::size_t>(postures_read(predictor));
  levels_ = derivatives_read(predictor) + 1;
  for (int d = 0; d < 3; ++d) {
    values_[d].assign(size, 0.0);
    last_[d].assign(size - first_unknown, 0.0);
  }
  history_.resize(depth_ - 1);
  for (auto& posture : history_) {
    for (int d = 0; d < levels_; ++d) posture[static_cast<std::size_t>(d)].assign(size - first_unknown, 0.0);
  }
  times_.reserve(depth_);
}

void State::clear() {
  for (auto& v : values_) std::fill(v.begin(), v.end(), 0.0);
  times_.clear();
}

void State::predict(double t) {
  const PredictionWeights w = prediction_weights(predictor_, times_, t);
  const double* sources[3 * kMostPostures];
  double weights[3 * kMostPostures];
  std::int32_t count = 0;
  for (std::size_t p = 0; p < static_cast<std::size_t>(w.postures); ++p) {
    for (std::size_t d = 0; d < static_cast<std::size_t>(levels_); ++d) {
      if (w.weight[p][d] == 0) continue;
      sources[count] = (p == 0 ? last_[d] : history_[p - 1][d]).data();
      weights[count++] = w.weight[p][d];
    }
  }
  kernels_.combine(sources, weights, count, last_[0].size(), values_[0].data() + first_unknown_);
}

double State::predicted_move(std::size_t address, std::size_t count) const {
  double largest = 0;
  for (std::size_t i = address; i < address + count; ++i) {
    largest = std::max(largest, std::abs(values_[0][i] - last_[0][i - first_unknown_]));
  }
  return largest;
}

void State::accept(double t) {
  if (!times_.empty() && depth_ > 1) {
    std::rotate(history_.begin(), history_.end() - 1, history_.end());
    for (int d = 0; d < levels_; ++d) history_[0][static_cast<std::size_t>(d)].swap(last_[d]);
  }
  for (int d = 0; d < 3; ++d) {
    std::copy(values_[d].begin() + static_cast<std::ptrdiff_t>(first_unknown_), values_[d].end(), last_[d].begin());
  }
  if (times_.size() == depth_) times_.pop_back();
  times_.insert(times_.begin(), t);
}

void State::forget() {
  while (times_.size() > 1) times_.pop_back();
}

void State::stand_still() {
  forget();
  for (int d = 1; d < 3; ++d) std::fill(last_[d].begin(), last_[d].end(), 0.0);
}

void State::restore() {
  for (int d = 0; d < 3; ++d) {
    std::copy(last_[d].begin(), last_[d].end(), values_[d].begin() + static_cast<std::ptrdiff_t>(first_unknown_));
  }
}

void State::estimate_rates() {
  if (times_.size() < 2) return;
  const double dt = times_[0] - times_[1];
  for (std::size_t i = 0; i < last_[0].size(); ++i) {
    values_[1][first_unknown_ + i] = (last_[0][i] - history_[0][0][i]) / dt;
  }
}

}  // namespace assur
