// Prediction of the next posture: a linear combination of earlier postures and their derivatives. The weights depend on
// the times only, so that all coordinates share them.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "assur/strategy.hpp"
#include "program/step_program.hpp"

namespace assur {

inline constexpr int kMostPostures = 6;                 // past:5
inline constexpr std::size_t kMostWeights = kMostPast;  // of past:5, or of two postures with two derivatives

struct PredictionWeights {
  int postures = 0;
  std::array<std::array<double, 3>, kMostPostures> weight{};  // [posture, newest first][derivative]
};

// Number of postures, and highest derivative, that a predictor reads.
[[nodiscard]] int postures_read(const Predictor& predictor);
[[nodiscard]] int derivatives_read(const Predictor& predictor);

// Weights for time t. `times`: of the postures, newest first, distinct. The order is lower if there are too few
// postures, or if an older posture is so near that extrapolation would amplify its errors.
[[nodiscard]] PredictionWeights prediction_weights(const Predictor& predictor, std::span<const double> times, double t);

// Computes weights again only if the steps differ from those of the last call. Steps of a grid are equal except for the
// rounding of times, which changes a prediction far less than its own error.
class WeightsOfEqualSteps {
 public:
  [[nodiscard]] const PredictionWeights& at(const Predictor& predictor, std::span<const double> times, double t);
  void clear() { count_ = 0; }

 private:
  PredictionWeights weights_;
  std::size_t count_ = 0;                     // postures that the weights are for; 0: none
  std::array<double, kMostPostures> step_{};  // newest first
};

}  // namespace assur
