#include "motion/predictor.hpp"

#include <algorithm>
#include <cmath>

namespace assur {
namespace {

// The sum of the weights amplifies rounding errors of the postures: at most to about 1e-12.
constexpr double kMostAmplification = 5e3;
// Steps with a smaller relative difference are equal; a sum changes by at most 2^6 times this part of a step.
constexpr double kEqual = 1e-10;

PredictionWeights taylor(int order, double h) {
  PredictionWeights w;
  w.postures = 1;
  w.weight[0][0] = 1;
  if (order >= 1) w.weight[0][1] = h;
  if (order >= 2) w.weight[0][2] = h * h / 2;
  return w;
}

// Quintic through value, rate and acceleration at t0 (newest) and t1, in s = (t - t1) / (t0 - t1).
PredictionWeights hermite(double t0, double t1, double t) {
  const double d = t0 - t1, s = (t - t1) / d, r = 1 - s;
  PredictionWeights w;
  w.postures = 2;
  const double s3 = s * s * s, r3 = r * r * r;
  w.weight[0] = {s3 * (10 + s * (6 * s - 15)), -d * s3 * r * (4 - 3 * s), d * d / 2 * s3 * r * r};
  w.weight[1] = {r3 * (10 + r * (6 * r - 15)), d * r3 * s * (4 - 3 * r), d * d / 2 * r3 * s * s};
  return w;
}

PredictionWeights lagrange(std::span<const double> times, double t) {
  PredictionWeights w;
  w.postures = static_cast<int>(times.size());
  for (std::size_t i = 0; i < times.size(); ++i) {
    double product = 1;
    for (std::size_t j = 0; j < times.size(); ++j) {
      if (j != i) product *= (t - times[j]) / (times[i] - times[j]);
    }
    w.weight[i][0] = product;
  }
  return w;
}

double amplification(const PredictionWeights& w) {
  double sum = 0;
  for (int i = 0; i < w.postures; ++i) sum += std::abs(w.weight[static_cast<std::size_t>(i)][0]);
  return sum;
}

}  // namespace

int postures_read(const Predictor& p) {
  switch (p.kind) {
    case Predictor::Kind::hermite:
      return 2;
    case Predictor::Kind::past:
      return p.order + 1;
    case Predictor::Kind::taylor:
    case Predictor::Kind::automatic:
      return 1;
  }
  return 1;
}

int derivatives_read(const Predictor& p) {
  switch (p.kind) {
    case Predictor::Kind::hermite:
      return 2;
    case Predictor::Kind::taylor:
      return p.order;
    case Predictor::Kind::past:
    case Predictor::Kind::automatic:
      return 0;
  }
  return 0;
}

PredictionWeights prediction_weights(const Predictor& p, std::span<const double> times, double t) {
  const double h = t - times[0];
  switch (p.kind) {
    case Predictor::Kind::hermite: {
      if (times.size() < 2) return taylor(2, h);
      const PredictionWeights w = hermite(times[0], times[1], t);
      return amplification(w) > kMostAmplification ? taylor(2, h) : w;
    }
    case Predictor::Kind::past:
      for (std::size_t count = std::min(times.size(), static_cast<std::size_t>(p.order) + 1); count > 1; --count) {
        const PredictionWeights w = lagrange(times.first(count), t);
        if (amplification(w) <= kMostAmplification) return w;
      }
      return taylor(0, h);
    case Predictor::Kind::taylor:
    case Predictor::Kind::automatic:
      break;
  }
  return taylor(p.order, h);
}

const PredictionWeights& WeightsOfEqualSteps::at(const Predictor& predictor, std::span<const double> times, double t) {
  bool equal = count_ == times.size();
  double end = t;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double step = end - times[i];
    equal = equal && std::abs(step - step_[i]) <= kEqual * std::abs(step_[i]);
    end = times[i];
  }
  if (equal) return weights_;
  count_ = times.size();
  end = t;
  for (std::size_t i = 0; i < times.size(); ++i) {
    step_[i] = end - times[i];
    end = times[i];
  }
  return weights_ = prediction_weights(predictor, times, t);
}

}  // namespace assur
