// Time of one kernel over shapes: a sum of physical terms fitted to what was measured, and what the neighbours say
// beyond it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "assur/performance.hpp"

namespace assur {

inline constexpr std::size_t kTerms = 5;
inline constexpr std::size_t kAxes = 4;

// Where a time was, or is to be, measured.
struct FitPoint {
  std::array<double, kTerms> terms{};  // counts that the time grows with; unused ones are 0
  std::array<double, kAxes> place{};   // logarithms: points close to each other have like deviations
};

class Curve {
 public:
  struct Measured {
    FitPoint at;
    double seconds = 0;
    double noise = 0;  // relative
  };

  // The fit is robust: coefficients >= 0 of the terms, least squares of relative deviations, outliers weigh less
  // (Huber 1964). At least one point; the order of the points does not matter beyond rounding.
  explicit Curve(const std::vector<Measured>& points);

  [[nodiscard]] Prediction at(const FitPoint& point) const;

 private:
  // How the points deviate from the fit, kBlock of them side by side: a program asks for hundreds of times among
  // thousands of points before its first step. No time is known to more digits than a float has.
  static constexpr std::size_t kBlock = 8;
  struct Deviations {
    std::array<std::array<float, kBlock>, kAxes> place;
    std::array<float, kBlock> log_ratio;  // measured over fitted
    std::array<float, kBlock> weight;     // 0: there is no point
  };
  [[nodiscard]] double fitted(const FitPoint& point) const;
  void fit(const std::vector<Measured>& points);

  std::array<double, kTerms> coefficients_{};
  std::size_t points_ = 0;
  std::vector<Deviations> deviations_;
};

}  // namespace assur
