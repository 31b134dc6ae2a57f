// Time of one kernel as a function of the shape: a sum of physical terms that is fitted to measurements, with a local
// correction by the nearest measured points.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "assur/performance.hpp"

namespace assur {

inline constexpr std::size_t kTerms = 5;  // counts in the sum
inline constexpr std::size_t kAxes = 4;   // on which shapes lie

// A shape for the fit.
struct FitPoint {
  std::array<double, kTerms> terms{};  // counts that the time grows with; unused ones are 0
  std::array<double, kAxes> place{};   // logarithms; points close to each other have similar deviations
};

// The fit for one kernel and solver.
class TimeFit {
 public:
  struct Measured {
    FitPoint at;
    double seconds = 0;
    double noise = 0;  // relative
  };

  // The fit is robust: coefficients >= 0 of the terms, least squares of relative deviations, outliers weigh less
  // (Huber 1964). At least one point; the order of the points does not matter beyond rounding.
  explicit TimeFit(const std::vector<Measured>& points);

  // otherwise: time that is expected without these points, s; its weight is larger if the point is far from all points,
  // or if they are few. 0: nothing is expected.
  [[nodiscard]] Prediction at(const FitPoint& point, double otherwise = 0) const;

  // Numbers of the points that contradict their neighbours so much that they must be measurements of something else, or
  // disturbed. at() ignores them.
  [[nodiscard]] const std::vector<std::size_t>& outliers() const { return outliers_; }

 private:
  // Deviations of the points from the fit, kBlock points side by side: before its first step, a program needs hundreds
  // of predictions among thousands of points. Floats are exact enough for times.
  static constexpr std::size_t kBlock = 8;
  struct Deviations {
    std::array<std::array<float, kBlock>, kAxes> place;
    std::array<float, kBlock> log_ratio;  // measured over fitted
    std::array<float, kBlock> weight;     // 0: no point
  };
  [[nodiscard]] double fitted(const FitPoint& point) const;
  [[nodiscard]] bool contradicts_neighbours(std::size_t i) const;
  void fit(const std::vector<Measured>& points);

  std::array<double, kTerms> coefficients_{};
  std::size_t points_ = 0;
  std::vector<Deviations> deviations_;
  std::vector<std::size_t> outliers_;
};

}  // namespace assur
