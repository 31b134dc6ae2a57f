// Laws and jets in quad precision, and their errors in double.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <span>

#include "scene/law_evaluate.hpp"
#include "scene/motions.hpp"
#include "verification/quad.hpp"

namespace assur::test {
namespace {

Motion rounded(const Jet<Quad>& jet) {
  return {static_cast<double>(jet.value), static_cast<double>(jet.rate), static_cast<double>(jet.acceleration)};
}

// ---- jets: a composed expression against central differences in quad, error O(h^2) with h = 1e-10

template <class T>
Jet<T> composed(const T& t) {
  const Jet<T> time{t, T(1), T(0)};
  const Jet<T> a = 2 + sin(time * 3) * cos(1 - time), b = sqrt(time * time + 1) / a - 5;
  Jet<T> sum = atan2(-b, a / 2) + 1 / (b - 3) - a * b;
  sum += 3 - a;
  sum -= time;
  return sum;
}

TEST(Jet, DerivativesOfEveryOperationAgreeWithDifferences) {
  for (double t : {-1.3, 0.0, 0.4, 2.5}) {
    const Quad h = 1e-10;
    const Jet<Quad> here = composed(Quad(t)), before = composed(Quad(t - h)), after = composed(Quad(t + h));
    const Quad rate = (after.value - before.value) / (2 * h);
    const Quad acceleration = (after.rate - before.rate) / (2 * h);
    EXPECT_LT(abs(here.rate - rate), 1e-16) << t;  // third derivatives of order 100 times h^2 / 6
    EXPECT_LT(abs(here.acceleration - acceleration), 1e-16) << t;
    expect_near(composed(t), rounded(here), {200 * kEps, 200 * kEps, 2000 * kEps});
  }
}

// The length is not computed as the root of a sum of squares, whose error eps rate^2 / length is unbounded.
TEST(Jet, ComputesTheLengthOfAShortGrowingVector) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> any(-1, 1), exponent(-8, 0);
  for (int i = 0; i < 1000; ++i) {
    const double size = std::pow(10, exponent(random)), growth = any(random);
    Jet<double> x[3];
    Jet<Quad> exact[3];
    double rates = 0;
    for (int k = 0; k < 3; ++k) {
      const double along = any(random);
      x[k] = {size * along, growth * along + size * any(random), size * any(random)};
      exact[k] = {x[k].value, x[k].rate, x[k].acceleration};
      rates += std::abs(x[k].rate);
    }
    const Quad value = sqrt(exact[0] * exact[0] + exact[1] * exact[1] + exact[2] * exact[2]).value;
    const Motion expected = rounded(length(std::span<const Jet<Quad>>(exact)));
    EXPECT_EQ(expected.value, static_cast<double>(value));
    // The component across the vector has an error of eps |rate|. It enters as a square and is at most a few times
    // `size`.
    const double across = 16 * kEps * (rates + size) * size / expected.value;
    expect_near(length(std::span<const Jet<double>>(x)), expected,
                {4 * kEps * expected.value, 8 * kEps * rates, across});
  }
}

// ---- laws

TEST(Law, HarmonicsKeepTheirPhaseAfterManyTurns) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> exponent(-3, 12);
  for (int i = 0; i < 1000; ++i) {
    const double frequency = std::pow(10, exponent(random) / 4), t = std::pow(10, exponent(random));
    const Law law = Law::harmonics({{1, frequency, 0.5}});
    const double w = kTau * frequency;
    expect_near(law(t), rounded(evaluate(law, Quad(t))), {4 * kEps, 8 * kEps * w, 12 * kEps * w * w});
  }
}

TEST(Law, QuadUsesTheSameParametersWithMoreDigits) {
  const Law law = Law::harmonics({{1, 0.1, 0}}) + Law::polynomial({0, 0.1});
  const Quad t = 1;
  const Quad angle = 2 * boost::math::constants::pi<Quad>() * Quad(0.1);
  EXPECT_LT(abs(evaluate(law, t).value - (sin(angle) + Quad(0.1))), 1e-32);
  EXPECT_LT(abs(evaluate(law, t).rate - (2 * boost::math::constants::pi<Quad>() * Quad(0.1) * cos(angle) + Quad(0.1))),
            1e-32);
}

TEST(Table, ThousandsOfPeriodsAddNoError) {
  std::vector<double> knots = spread(20, 0.1, 0.7);  // 0.7 - 0.1 is not a double
  const Law law = Law::table(knots, values(knots, [](double t) { return std::sin(kTau * (t - 0.1) / 0.6); }), true);
  for (double t : {77.123, -3456.7, 1e6 + 0.3, 12345678.9}) {
    const Motion exact = rounded(evaluate(law, Quad(t)));  // |rate| <= 11, |acceleration| <= 120, third <= 1500
    expect_near(law(t), exact, {32 * kEps, 512 * kEps, 8192 * kEps}, std::to_string(t));
  }
}

TEST(Law, QuadIsNaNOutsideATableAndTakesFunctionsInDouble) {
  EXPECT_TRUE(isnan(evaluate(Law::table({0, 1}, {1, 2}), Quad(1.5)).value));
  EXPECT_EQ(evaluate(Law::function([](double t) { return Motion{t, 2 * t, 3 * t}; }), Quad(2)).rate, 4);
}

}  // namespace
}  // namespace assur::test
