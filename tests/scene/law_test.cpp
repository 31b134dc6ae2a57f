#include "assur/law.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>

#include "assur/status.hpp"
#include "scene/motions.hpp"

namespace assur::test {
namespace {

std::string message(const std::function<void()>& misuse) {
  try {
    misuse();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::input);
    return error.what();
  }
  return "no error";
}

// ---- polynomials and harmonics

TEST(Law, DefaultIsConstantZero) {
  expect_near(Law()(3.0), {}, {});
  EXPECT_TRUE(Law().is_constant());
}

TEST(Law, PolynomialHasTwoDerivatives) {
  const Law law = Law::polynomial({1, -2, 3, 0.5});
  expect_near(law(2.0), {13, 16, 12}, {});  // small integers: exact
  expect_near(Law::polynomial({})(2.0), {}, {});
  expect_near(Law::constant(4)(1e9), {4, 0, 0}, {});
}

TEST(Law, HarmonicsHaveTwoDerivatives) {
  const Law law = Law::harmonics({{2, 0.5, 0.25}, {3, 2, -1}}, 7);
  const double t = 0.3, a = kTau * 0.5 * t + 0.25, b = kTau * 2 * t - 1, u = kTau * 0.5, v = kTau * 2;
  expect_near(law(t),
              {7 + 2 * std::sin(a) + 3 * std::sin(b), 2 * u * std::cos(a) + 3 * v * std::cos(b),
               -2 * u * u * std::sin(a) - 3 * v * v * std::sin(b)},
              {16 * kEps * 7, 16 * kEps * 44, 16 * kEps * 500});
}

TEST(Law, SumsShareTheirParts) {
  const Law a = Law::polynomial({1, 2}), b = Law::harmonics({{1, 1, 0}});
  const Law sum = a + b + a;
  EXPECT_EQ(sum.parts().size(), 3u);
  const Motion x = a(0.1), y = b(0.1), z = sum(0.1);
  expect_near(z, {2 * x.value + y.value, 2 * x.rate + y.rate, y.acceleration}, {4 * kEps, 16 * kEps, 100 * kEps});
}

TEST(Law, CallsTheFunctionAtItsTime) {
  const Law law = Law::function([](double t) { return Motion{t, 2 * t, 3 * t}; });
  expect_near(law(2.0), {2, 4, 6}, {});
  EXPECT_FALSE(law.is_constant());
}

// ---- tables

class TableDegree : public testing::TestWithParam<int> {};

// 2 points determine a line, 3 a parabola, 4 and more any cubic. Rounding of a value moves slopes by eps / h and second
// derivatives by eps / h^2. h is at least (end - begin) / (4 n), and the inverse of the spline matrix has a norm of at
// most 3.
TEST_P(TableDegree, ReproducesPolynomialsAndTheirDerivatives) {
  const int n = GetParam(), degree = std::min(n - 1, 3);
  std::vector<double> c{0.3, -1.2, 0.7, 0.4};
  c.resize(static_cast<std::size_t>(degree) + 1);
  const Law exact = Law::polynomial(c);
  const std::vector<double> knots = spread(n, -1, 2);
  const Law table = Law::table(knots, values(knots, [&](double t) { return exact(t).value; }));
  const double h = 3.0 / (4 * n), size = 4;
  const Motion tolerance{6 * kEps * size, 24 * kEps * size / h, 24 * kEps * size / (h * h)};
  for (int i = 0; i <= 100; ++i) {
    const double t = -1 + 0.03 * i;
    expect_near(table(t), exact(t), tolerance, "t = " + std::to_string(t));
  }
}
INSTANTIATE_TEST_SUITE_P(Points, TableDegree, testing::Values(2, 3, 4, 5, 6, 17, 100));

TEST(Table, PassesThroughItsPointsExactly) {
  const std::vector<double> knots = spread(50, 0, 3);
  const std::vector<double> v = values(knots, [](double t) { return std::exp(t); });
  const Law law = Law::table(knots, v);
  for (std::size_t i = 0; i < knots.size(); ++i) EXPECT_EQ(law(knots[i]).value, v[i]) << i;
}

// Between two points, a monotone table stays between their values; its slope is continuous, and its corners are flat.
TEST(Table, MonotoneTablesDoNotOvershoot) {
  for (const bool periodic : {false, true}) {
    const std::vector<double> knots = {0, 0.1, 0.5, 0.6, 1.3, 1.4, 2};
    const std::vector<double> v = {0, 0, 1, 1.01, 1.01, -2, 0};
    const Law law = Law::table(knots, v, periodic, true);
    EXPECT_NE(law, Law::table(knots, v, periodic));
    bool spline_overshoots = false;
    for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
      EXPECT_EQ(law(knots[i]).value, v[i]);
      const double low = std::min(v[i], v[i + 1]), high = std::max(v[i], v[i + 1]);
      for (int k = 0; k <= 50; ++k) {
        const double t = knots[i] + (knots[i + 1] - knots[i]) * k / 50, x = law(t).value;
        EXPECT_GE(x, low - 100 * kEps) << t;
        EXPECT_LE(x, high + 100 * kEps) << t;
        const double spline = Law::table(knots, v, periodic)(t).value;
        spline_overshoots = spline_overshoots || spline < low - 0.01 || spline > high + 0.01;
      }
      if (i == 0) continue;
      const Motion before = law(std::nextafter(knots[i], -1)), after = law(knots[i]);
      EXPECT_NEAR(before.rate, after.rate, 1e-12);
      // The harmonic mean of both slopes with the weights of Fritsch and Butland.
      const double h0 = knots[i] - knots[i - 1], h1 = knots[i + 1] - knots[i];
      const double s0 = (v[i] - v[i - 1]) / h0, s1 = (v[i + 1] - v[i]) / h1;
      const double mean = 3 * (h0 + h1) / ((2 * h1 + h0) / s0 + (h1 + 2 * h0) / s1);
      EXPECT_NEAR(after.rate, s0 * s1 > 0 ? mean : 0, 1e-12);
    }
    EXPECT_TRUE(spline_overshoots);
  }
  const Law line = Law::table({0, 2}, {1, 4}, false, true);
  EXPECT_NEAR(line(0.5).value, 1.75, 4 * kEps);
  EXPECT_EQ(line(0.5).rate, 1.5);
  const Law periodic = Law::table({0, 1, 2, 3}, {0, 1, 2, 0}, true, true);
  EXPECT_NEAR(periodic(0).rate, periodic(std::nextafter(3.0, 0)).rate, 1e-12);
}

// Both sides of each knot differ by rounding, and by the change of the law over one unit in the last place of t.
void expect_smooth(const Law& law, const std::vector<double>& knots, double h, double size) {
  for (std::size_t i = 1; i + 1 < knots.size(); ++i) {
    const Motion left = law(std::nextafter(knots[i], -1e9)), right = law(knots[i]);
    const double ulp = kEps * knots[i];
    expect_near(left, right,
                {8 * kEps * size + ulp * std::abs(right.rate),
                 24 * kEps * size / h + ulp * std::abs(right.acceleration), 24 * kEps * size / (h * h)},
                "knot " + std::to_string(i));
  }
}

TEST(Table, IsTwiceContinuouslyDifferentiable) {
  const std::vector<double> knots = spread(60, 0, 3);
  expect_smooth(Law::table(knots, values(knots, [](double t) { return std::sin(5 * t); })), knots, 3.0 / 240, 1);
}

TEST(Table, NotAKnotJoinsTheFirstTwoPiecesToOneCubic) {
  const std::vector<double> knots = spread(9, 0, 2);
  const Law law = Law::table(knots, values(knots, [](double t) { return std::exp(t); }));
  const auto third = [&](std::size_t k) {
    return (law(knots[k + 1]).acceleration - law(knots[k]).acceleration) / (knots[k + 1] - knots[k]);
  };
  const double h = 2.0 / 36, tolerance = 24 * kEps * std::exp(2) / (h * h * h);
  EXPECT_NEAR(third(0), third(1), tolerance);
  EXPECT_NEAR(third(6), third(7), tolerance);
  EXPECT_GT(std::abs(third(3) - third(4)), 0.01);
}

double sine_error(int n, bool periodic) {
  const std::vector<double> knots = spread(n, 0, 1);
  const Law law = Law::table(knots, values(knots, [](double t) { return std::sin(kTau * t); }), periodic);
  double worst = 0;
  for (int i = 0; i <= 10000; ++i) {
    const double t = i / 10000.0;
    worst = std::max(worst, std::abs(law(t).value - std::sin(kTau * t)));
  }
  return worst;
}

TEST(Table, SineIsOfFourthOrder) {
  for (bool periodic : {false, true}) {
    // The error in the interior is at most 5/384 h^4 max |f''''| (Hall & Meyer 1976), and the longest interval at most
    // 4 / n. Not-a-knot ends increase the error by a constant factor.
    for (int n : {33, 129, 513})
      EXPECT_LT(sine_error(n, periodic), 0.1 * std::pow(4.0 / n, 4) * std::pow(kTau, 4)) << n;
    const double order = std::log(sine_error(65, periodic) / sine_error(1025, periodic)) / std::log(16);
    EXPECT_NEAR(order, 4, 0.4);
  }
}

TEST(Table, PeriodicClosesWithTwoDerivatives) {
  for (int n : {2, 3, 4, 5, 30}) {
    const std::vector<double> knots = spread(n, 0.5, 2.5);
    const Law law = Law::table(
        knots, values(knots, [](double t) { return std::cos(kTau * (t - 0.5) / 2) + std::sin(kTau * (t - 0.5)); }),
        true);
    const double h = 2.0 / (4 * n);
    const Motion tolerance{8 * kEps * 2, 24 * kEps * 2 / h, 24 * kEps * 2 / (h * h)};
    expect_near(law(std::nextafter(2.5, 0)), law(2.5), tolerance, "n = " + std::to_string(n));
    expect_near(law(0.5), law(2.5), tolerance);
    expect_near(law(0.7 + 2 * 3), law(0.7), {64 * kEps, 1e3 * kEps / h, 1e3 * kEps / (h * h)});
    expect_near(law(0.7 - 2 * 3), law(0.7), {64 * kEps, 1e3 * kEps / h, 1e3 * kEps / (h * h)});
    expect_smooth(law, knots, h, 2);
  }
}

TEST(Table, IsNaNOutsideExceptForRounding) {
  const Law law = Law::table({0, 0.1, 0.3}, {1, 2, 4});
  EXPECT_TRUE(law.covers(3 * 0.1));  // 0.30000000000000004
  EXPECT_NEAR(law(3 * 0.1).value, 4, 64 * kEps);
  for (double t : {-1e-9, 0.3000001, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_FALSE(law.covers(t));
    EXPECT_TRUE(std::isnan(law(t).value));
    EXPECT_TRUE(std::isnan(law(t).rate));
    EXPECT_TRUE(std::isnan(law(t).acceleration));
  }
  EXPECT_FALSE((law + Law::constant(1)).covers(1));
  EXPECT_TRUE(Law::table({0, 1}, {2, 2}, true).covers(-7));
}

TEST(Table, HundredThousandKnotsTakeLinearTime) {
  const auto seconds = [](int n) {
    std::vector<double> knots, v;
    for (int i = 0; i < n; ++i) knots.push_back(i * 0.01), v.push_back(std::sin(i * 0.01));
    const auto start = std::chrono::steady_clock::now();
    const Law law = Law::table(std::move(knots), std::move(v));
    EXPECT_NEAR(law(5.432).value, std::sin(5.432), 1e-8);  // h^4 / 48 and less
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  seconds(1000);
  EXPECT_LT(seconds(100000), 1.0);  // takes milliseconds; a dense or quadratic method needs minutes
}

TEST(Law, KnowsWhetherItIsConstant) {
  EXPECT_TRUE(Law::constant(3).is_constant());
  EXPECT_TRUE(Law::polynomial({3, 0, 0}).is_constant());
  EXPECT_FALSE(Law::polynomial({3, 0, 1}).is_constant());
  EXPECT_TRUE(Law::harmonics({{0, 1, 0}, {1, 0, 1}}, 2).is_constant());
  EXPECT_FALSE(Law::harmonics({{1, 1, 0}}).is_constant());
  EXPECT_TRUE(Law::table({0, 1, 2}, {5, 5, 5}).is_constant());
  EXPECT_FALSE(Law::table({0, 1, 2}, {5, 5, 6}).is_constant());
  EXPECT_FALSE((Law::constant(3) + Law::polynomial({0, 1})).is_constant());
}

TEST(Law, RefusesBadInput) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto table = [](std::vector<double> t, std::vector<double> v, bool periodic = false) {
    return message([&] { (void)Law::table(t, v, periodic); });
  };
  EXPECT_EQ(table({0, 1}, {1}), "a table needs one value for each time, not 1 values for 2 times");
  EXPECT_EQ(table({0}, {1}), "a table needs at least 2 rows, not 1");
  EXPECT_EQ(table({0, 0.2, 0.2}, {1, 2, 3}), "the times of a table must ascend, but time[2] = 0.2 follows 0.2");
  EXPECT_EQ(table({0, nan}, {1, 2}), "time[1] of a law is not a finite number");
  EXPECT_EQ(table({0, 1}, {nan, 2}), "value[0] of a law is not a finite number");
  EXPECT_EQ(table({0, 1, 2}, {1, 2, 1.5}, true), "a periodic table must end with its first value, 1, not with 1.5");
  EXPECT_EQ(message([&] { (void)Law::polynomial({1, nan}); }), "polynomial[1] of a law is not a finite number");
  EXPECT_EQ(message([&] {
              (void)Law::harmonics({{1, nan, 0}});
            }),
            "harmonics[0] of a law has an amplitude, frequency or phase that is not a finite number");
  EXPECT_EQ(message([&] { (void)Law::function(nullptr); }), "the function of a law is empty");
  const auto rest = [](double) { return Motion{}; };
  EXPECT_EQ(message([&] { (void)Law::function(rest, -1); }),
            "the tolerance of a law is a relative error such as 1e-5, not -1");
  const std::string no_spline = "no spline in doubles goes through this table between time[0] and time[1]";
  EXPECT_EQ(message([&] { (void)Law::table({0, 1e-320, 1}, {0, 1, 0}); }).rfind(no_spline, 0), 0u);
  EXPECT_EQ(message([&] { (void)Law::table({0, 1, 2, 3}, {0, 1e308, -1e308, 1e308}); }).rfind(no_spline, 0), 0u);
  EXPECT_EQ(message([&] { (void)Law::table({0, 1e200}, {0, 1}); }).rfind(no_spline, 0), 0u);
}

}  // namespace
}  // namespace assur::test
