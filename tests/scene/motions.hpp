// Helpers of the tests of laws.
#pragma once

#include <gtest/gtest.h>

#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "assur/law.hpp"
#include "numbers.hpp"

namespace assur::test {

inline constexpr double kTau = 2 * std::numbers::pi;

inline void expect_near(const Motion& actual, const Motion& expected, const Motion& tolerance,
                        const std::string& where = "") {
  EXPECT_NEAR(actual.value, expected.value, tolerance.value) << where;
  EXPECT_NEAR(actual.rate, expected.rate, tolerance.rate) << where;
  EXPECT_NEAR(actual.acceleration, expected.acceleration, tolerance.acceleration) << where;
}

// n knots from begin to end whose spacing varies by a factor of up to 4.
inline std::vector<double> spread(int n, double begin, double end) {
  std::mt19937 random(static_cast<unsigned>(n));
  std::uniform_real_distribution<double> step(0.5, 2.0);
  std::vector<double> knots{0};
  for (int i = 1; i < n; ++i) knots.push_back(knots.back() + step(random));
  const double scale = knots.back();
  for (double& knot : knots) knot = begin + (end - begin) * (knot / scale);
  return knots;
}

template <class F>
std::vector<double> values(const std::vector<double>& knots, F f) {
  std::vector<double> v;
  for (double t : knots) v.push_back(f(t));
  return v;
}

}  // namespace assur::test
