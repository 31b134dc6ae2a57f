// Where a step starts from: a linear combination of earlier postures and their derivatives. The weights depend on the
// times only, so one set serves every coordinate.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "assur/strategy.hpp"

namespace assur {

inline constexpr int kMostPostures = 6;  // past:5

struct PredictionWeights {
  int postures = 0;
  std::array<std::array<double, 3>, kMostPostures> weight{};  // [posture, newest first][derivative]
};

// Postures and highest derivative that a predictor reads.
[[nodiscard]] int postures_read(const Predictor& predictor);
[[nodiscard]] int derivatives_read(const Predictor& predictor);

// Weights at time t. `times`: newest first, distinct. With too few postures, or an older one so near that extrapolation
// would amplify its errors, a lower order is taken.
[[nodiscard]] PredictionWeights prediction_weights(const Predictor& predictor, std::span<const double> times, double t);

// The same, computed anew only where the steps differ from those of the last time. Steps of a grid are equal but for
// the rounding of its times, which moves a prediction far less than its own error is.
class WeightsOfEqualSteps {
 public:
  [[nodiscard]] const PredictionWeights& at(const Predictor& predictor, std::span<const double> times, double t);
  void clear() { count_ = 0; }

 private:
  PredictionWeights weights_;
  std::size_t count_ = 0;                     // postures they are for; 0: none
  std::array<double, kMostPostures> step_{};  // newest first
};

}  // namespace assur
