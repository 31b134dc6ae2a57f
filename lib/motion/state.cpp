#include "motion/state.hpp"

#include <algorithm>
#include <cmath>

#include "index.hpp"
#include "numbers.hpp"

namespace assur {
namespace {

double square(double x) { return x * x; }

double length(const double* v, std::size_t begin, std::size_t end) {
  double sum = 0;
  for (std::size_t i = begin; i < end; ++i) sum += square(v[i]);
  return std::sqrt(sum);
}

}  // namespace

void State::resize(std::size_t first_unknown, std::size_t size, const Predictor& predictor) {
  predictor_ = predictor;
  first_unknown_ = first_unknown;
  size_ = size;
  depth_ = static_cast<std::size_t>(postures_read(predictor));
  levels_ = derivatives_read(predictor) + 1;
  for (int d = 0; d < 3; ++d) {
    Ring& r = ring(d);
    r.count = 1 + (d < levels_ ? depth_ : 1);
    for (std::size_t i = 0; i < r.postures.size(); ++i) r.postures[i].assign(i < r.count ? size : 0, 0.0);
  }
  times_.reserve(depth_ + 1);
}

void State::copy(const State& from) {
  *this = from;
  times_.reserve(depth_ + 1);
}

bool State::is_like(const State& o) const {
  return size_ == o.size_ && first_unknown_ == o.first_unknown_ && depth_ == o.depth_ && levels_ == o.levels_;
}

void State::clear() {
  for (Ring& r : rings_) {
    for (auto& posture : r.postures) std::fill(posture.begin(), posture.end(), 0.0);
  }
  begun_ = true;
  times_.clear();
  weights_.clear();
}

void State::begin() {
  if (begun_) return;
  for (Ring& r : rings_) r.newest = (r.newest == 0 ? r.count : r.newest) - 1;
  begun_ = true;
}

void State::predict(double t) {
  Prediction prediction;
  begin_prediction(t, prediction);
  predict(prediction, 0, unknowns());
}

void State::begin_prediction(double t, Prediction& out) {
  begin();
  const PredictionWeights& w = weights_.at(predictor_, times_, t);
  const auto levels = static_cast<std::size_t>(levels_);
  const double** source = out.sources;
  double* weight = out.weights;
  std::size_t place = rings_[0].place(last());  // derivatives that are read lie in the same places
  for (std::size_t p = 0; p < static_cast<std::size_t>(w.postures); ++p) {
    for (std::size_t d = 0; d < levels; ++d) {
      *source++ = rings_[d].postures[place].data() + first_unknown_;
      *weight++ = w.weight[p][d];
    }
    if (++place == rings_[0].count) place = 0;
  }
  out.count = static_cast<std::int32_t>(source - out.sources);
  for (const double* const* const end = out.sources + weights(); source < end;) {
    *source++ = out.sources[0];
    *weight++ = 0;
  }
}

void State::begin_expansion(double t, Prediction& out, int derivatives) {
  if (levels_ > 2 && derivatives == 2) return begin_prediction(t, out);
  begin();
  const double dt = t - times_.front();
  out.count = 0;
  for (const double weight : {1.0, dt, dt * dt / 2}) {
    out.sources[out.count] = ring(out.count).at(last()) + first_unknown_;
    out.weights[out.count++] = weight;
    if (out.count > derivatives) break;
  }
}

void State::reserve(PostureHistory& history) const {
  for (LaneArray& posture : history.postures) posture.assign(size_, 0.0);
}

void State::save_history(PostureHistory& history) const {
  std::rotate(history.postures.begin(), history.postures.end() - 1, history.postures.end());
  std::rotate(history.times.begin(), history.times.end() - 1, history.times.end());
  const double* const newest = ring(0).at(last());
  history.postures[0].assign(newest, newest + size_);
  history.times[0] = times_.front();
  history.count = std::min(history.count + 1, PostureHistory::kMost);
}

void State::begin_prediction(const PostureHistory& history, double t, Prediction& out) {
  begin();
  const Predictor through_all{Predictor::Kind::past, static_cast<std::int32_t>(history.count) - 1};
  const PredictionWeights w = prediction_weights(through_all, std::span(history.times).first(history.count), t);
  for (out.count = 0; out.count < w.postures; ++out.count) {
    out.sources[out.count] = history.postures[static_cast<std::size_t>(out.count)].data() + first_unknown_;
    out.weights[out.count] = w.weight[static_cast<std::size_t>(out.count)][0];
  }
}

void State::predict(const Prediction& prediction, std::size_t begin, std::size_t end) {
  const double* sources[kMostWeights];
  for (std::int32_t i = 0; i < prediction.count; ++i) sources[i] = prediction.sources[i] + begin;
  kernels_->combine(sources, prediction.weights, prediction.count, end - begin, at(0) + first_unknown_ + begin);
}

double State::predicted_move(std::size_t address, std::size_t count) const {
  const double *now = at(0), *before = ring(0).at(last());
  double largest = 0;
  for (std::size_t i = address; i < address + count; ++i) largest = std::max(largest, std::abs(now[i] - before[i]));
  return largest;
}

double State::move() const {
  const double *now = at(0), *before = accepted(0);
  double sum = 0;
  for (std::size_t i = first_unknown_; i < size_; ++i) sum += square(now[i] - before[i]);
  return std::sqrt(sum);
}

double State::speed() const { return length(accepted(1), first_unknown_, size_); }

double State::time_of_rounding() const {
  const double rate = length(accepted(1), 0, first_unknown_);
  return rate > 0 ? kEps * length(accepted(0), 0, first_unknown_) / rate : 0;
}

void State::accept(double t) {
  if (times_.empty()) spread_known();  // those that never move are equal in all postures
  begun_ = false;
  if (times_.size() == depth_) times_.pop_back();
  times_.insert(times_.begin(), t);
}

void State::spread_known() {
  Ring& r = ring(0);
  for (std::size_t age = 0; age < r.count; ++age) {
    if (r.at(age) != at(0)) std::copy_n(at(0), first_unknown_, r.at(age));
  }
}

void State::forget() {
  while (times_.size() > 1) times_.pop_back();
}

void State::stand_still() {
  forget();
  for (int d = 1; d < 3; ++d) std::fill_n(ring(d).at(last()) + first_unknown_, size_ - first_unknown_, 0.0);
}

void State::restore() {
  begin();
  for (int d = 0; d < 3; ++d) std::copy_n(ring(d).at(last()), size_, at(d));
}

void State::replace() {
  for (int d = 0; d < 3; ++d) {
    std::copy_n(at(d) + first_unknown_, size_ - first_unknown_, ring(d).at(last()) + first_unknown_);
  }
}

}  // namespace assur
