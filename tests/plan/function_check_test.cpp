// Derivatives of functions compared with differences. Right ones are accepted, wrong ones are found.
#include "assur/derivatives.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace assur {
namespace {

using Arguments = std::span<const double>;
using Results = std::span<double>;

// A function with its gradient, and arguments to try: around `center` within `spread`.
struct Case {
  std::string name;
  int arguments = 0;
  double center = 0, spread = 1, unit = 1;
  std::function<double(Arguments)> value;
  std::function<void(Arguments, Results)> gradient;
  double found = 0;  // least share of wrong gradients that must be found; entries may nearly vanish
};

double noise(double x) {
  const double s = std::sin(x * 12.9898e8) * 43758.5453;
  return s - std::floor(s);
}

std::vector<Case> cases() {
  const auto distance = [](Arguments x) { return (x[0] - x[1]) * (x[0] - x[1]) + (x[2] - 1) * (x[2] - 1); };
  const auto of_distance = [](Arguments x, Results g) {
    g[0] = 2 * (x[0] - x[1]), g[1] = -g[0], g[2] = 2 * (x[2] - 1);
  };
  std::vector<Case> all;
  const auto add = [&](const char* name, int m, double center, double spread, auto value, auto gradient, double found) {
    all.push_back({name, m, center, spread, 1, value, gradient, found});
  };
  add("distance", 3, 0, 1, distance, of_distance, 0.95);
  add(
      "far from the origin", 3, 1e6, 1, distance,
      [](Arguments x, Results g) { g[0] = 2 * (x[0] - x[1]), g[1] = -g[0], g[2] = 2 * (x[2] - 1); }, 0);
  all.push_back({"tiny", 3, 0, 1e-6, 0x1p-20, [](Arguments x) { return x[0] * x[1] + x[2] * x[2] - 1e-12; },
                 [](Arguments x, Results g) { g[0] = x[1], g[1] = x[0], g[2] = 2 * x[2]; }, 0.95});
  for (const double w : {1.0, 30.0, 1e3, 1e5}) {
    add(
        "oscillation", 1, 0, 1, [w](Arguments x) { return std::sin(w * x[0]); },
        [w](Arguments x, Results g) { g[0] = w * std::cos(w * x[0]); }, w < 100 ? 0.9 : 0);
  }
  add(
      "degree 16", 2, 1, 0.5, [](Arguments x) { return std::pow(x[0], 16) - std::pow(x[1], 7); },
      [](Arguments x, Results g) { g[0] = 16 * std::pow(x[0], 15), g[1] = -7 * std::pow(x[1], 6); }, 0.5);
  add(
      "stiff", 2, 0, 1, [](Arguments x) { return std::expm1(300 * x[0]) + x[1]; },
      [](Arguments x, Results g) { g[0] = 300 * std::exp(300 * x[0]), g[1] = 1; }, 0.3);
  add(
      "close to the end of its domain", 2, 0, 2, [](Arguments x) { return std::acos(x[0] / 2) - x[1]; },
      [](Arguments x, Results g) { g[0] = -1 / std::sqrt(4 - x[0] * x[0]), g[1] = -1; }, 0.95);
  add(
      "close to a kink", 2, 0, 1e-4, [](Arguments x) { return std::abs(x[0]) + x[1]; },
      [](Arguments x, Results g) { g[0] = x[0] < 0 ? -1 : 1, g[1] = 1; }, 0.4);
  add(
      "at a kink", 1, 0, 0, [](Arguments x) { return std::abs(x[0]); }, [](Arguments, Results g) { g[0] = 1; }, 0);
  add(
      "a gradient by differences", 2, 0.5, 0.4, [](Arguments x) { return x[0] * std::sin(x[1]) - 0.3; },
      [](Arguments x, Results g) {
        const auto f = [](double a, double b) { return a * std::sin(b) - 0.3; };
        g[0] = (f(x[0] + 1e-8, x[1]) - f(x[0], x[1])) / 1e-8, g[1] = (f(x[0], x[1] + 1e-8) - f(x[0], x[1])) / 1e-8;
      },
      0.9);
  add(
      "in float", 2, 0, 2, [](Arguments x) { return double(std::sin(float(x[0])) * float(x[1])); },
      [](Arguments x, Results g) { g[0] = std::cos(x[0]) * x[1], g[1] = std::sin(x[0]); }, 0);
  add(
      "in float, far", 2, 1e3, 2, [](Arguments x) { return double(float(x[0]) - float(x[1])); },
      [](Arguments, Results g) { g[0] = 1, g[1] = -1; }, 0);
  for (const double size : {1e-12, 1e-9, 1e-6, 1e-3}) {
    add(
        "noise", 2, 0, 2, [size](Arguments x) { return x[0] * x[1] + size * noise(x[0] + 7 * x[1]); },
        [](Arguments x, Results g) { g[0] = x[1], g[1] = x[0]; }, size < 1e-10 ? 0.9 : 0);
  }
  add(
      "stationary", 2, 0, 0, [](Arguments x) { return x[0] * x[0] * x[0] + x[1] * x[1]; },
      [](Arguments x, Results g) { g[0] = 3 * x[0] * x[0], g[1] = 2 * x[1]; }, 0);
  return all;
}

// A callback of one equation, whose entry `wrong` (-1: none) has a relative error of 1e-4.
Callback callback(const Case& c, int wrong) {
  Callback out;
  for (int j = 0; j < c.arguments; ++j) out.coordinates.push_back("P" + std::to_string(j) + ".x");
  out.equations = 1;
  out.residual = [&c](Arguments x, Results phi) { phi[0] = c.value(x); };
  out.jacobian = [&c, wrong](Arguments x, Results j) {
    c.gradient(x, j);
    if (wrong >= 0) j[static_cast<std::size_t>(wrong)] *= 1 + 1e-4;
  };
  return out;
}

// The finding at x; "": none.
std::string found(const Case& c, const Callback& callback, const std::vector<double>& x) {
  const std::vector<double> units(x.size(), c.unit);
  const std::vector<Diagnostic> all = check_derivatives(callback, x, units);
  return all.empty() ? "" : all[0].what;
}

TEST(FunctionCheck, AcceptRightGradientsAndFindAWrongEntry) {
  constexpr int kTries = 500;
  std::mt19937_64 random(7);
  for (const Case& c : cases()) {
    std::uniform_real_distribution<double> around(c.center - c.spread, c.center + c.spread);
    int caught = 0, named = 0;
    for (int k = 0; k < kTries; ++k) {
      std::vector<double> x;
      for (int j = 0; j < c.arguments; ++j) x.push_back(around(random));
      const Callback right = callback(c, -1);
      EXPECT_EQ(found(c, right, x), "") << c.name << " at " << x[0];
      const Callback wrong = callback(c, k % c.arguments);
      const std::string accused = found(c, wrong, x);
      caught += accused.empty() ? 0 : 1;
      named += accused.rfind("jacobian[row 0, P" + std::to_string(k % c.arguments) + ".x]", 0) == 0 ? 1 : 0;
    }
    EXPECT_GE(caught, c.found * kTries) << c.name;
    EXPECT_EQ(named, caught) << c.name;
  }
}

// The curvature of x0 x1 x2 + x0^2, exact and with a relative error of 1e-4.
TEST(FunctionCheck, CheckTheCurvature) {
  Callback c;
  c.coordinates = {"P.x", "P.y", "P.z"};
  c.equations = 1;
  c.residual = [](Arguments x, Results phi) { phi[0] = x[0] * x[1] * x[2] + x[0] * x[0]; };
  c.jacobian = [](Arguments x, Results j) { j[0] = x[1] * x[2] + 2 * x[0], j[1] = x[0] * x[2], j[2] = x[0] * x[1]; };
  double factor = 1;
  c.curvature = [&factor](Arguments x, Arguments v, Results out) {
    out[0] = factor * 2 * (v[0] * v[0] + x[2] * v[0] * v[1] + x[1] * v[0] * v[2] + x[0] * v[1] * v[2]);
  };
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> any(-1, 1);
  int caught = 0;
  for (int k = 0; k < 500; ++k) {
    const std::vector<double> x = {any(random), any(random), any(random)};
    factor = 1;
    EXPECT_TRUE(check_derivatives(c, x).empty());
    factor = 1 + 1e-4;
    const std::vector<Diagnostic> found = check_derivatives(c, x);
    caught += !found.empty() && found[0].what.rfind("curvature[row 0] is ", 0) == 0 ? 1 : 0;
  }
  EXPECT_GE(caught, 475);  // the curvature may nearly vanish
}

// ---- laws

struct TimedLaw {
  std::string name;
  std::function<Motion(double)> motion;
  bool find = true;  // a wrong rate or acceleration must be found
};

std::vector<TimedLaw> laws() {
  const auto sine = [](double w) {
    return [w](double t) { return Motion{std::sin(w * t), w * std::cos(w * t), -w * w * std::sin(w * t)}; };
  };
  std::vector<TimedLaw> all = {
      {"slow", sine(0.7)},
      {"a turn in ten steps", sine(62.8)},
      {"fast", sine(1e4), false},
      {"ramp",
       [](double t) {
         return Motion{3 + 2 * t, 2, 0};
       }},
      {"small",
       [](double t) {
         return Motion{1e-6 * t * t, 2e-6 * t, 2e-6};
       },
       false},
      {"degree 12",
       [](double t) {
         return Motion{std::pow(t, 12), 12 * std::pow(t, 11), 132 * std::pow(t, 10)};
       }},
      // Starts at rest. The acceleration jumps at 0.5, the rate at 1.
      {"pieces",
       [](double t) {
         const double s = t - 0.5;
         return s < 0 ? Motion{0, 0, 0} : s < 0.5 ? Motion{s * s, 2 * s, 2} : Motion{0.25 + 3 * (s - 0.5), 3, 0};
       },
       false},
      {"by differences",
       [](double t) {
         const auto f = [](double s) { return std::sin(3 * s); };
         constexpr double h = 1e-4;
         return Motion{f(t), (f(t + h) - f(t - h)) / (2 * h), (f(t + h) - 2 * f(t) + f(t - h)) / (h * h)};
       }},
      {"samples in between",
       [](double t) {  // linear between points of a table with rounded values
         const auto f = [](double k) { return std::round(1e4 * std::sin(k / 50)) / 1e4; };
         const double k = std::floor(t * 50), u = t * 50 - k;
         return Motion{f(k) + u * (f(k + 1) - f(k)), (f(k + 1) - f(k)) * 50, 0};
       },
       false},
      {"a solver that goes on where it ended",
       [last = 1.0](double t) mutable {
         double x = last;
         for (int i = 0; i < 30 && std::abs(x * x - 2 - t) > 1e-10; ++i) x -= (x * x - 2 - t) / (2 * x);
         last = x;
         return Motion{x, 1 / (2 * x), -1 / (4 * x * x * x)};
       }},
      {"ends",
       [](double t) {
         if (t > 1.3) throw std::runtime_error("no more");
         return Motion{std::sqrt(1.3 - t), -0.5 / std::sqrt(1.3 - t), -0.25 * std::pow(1.3 - t, -1.5)};
       },
       false},
  };
  return all;
}

TEST(FunctionCheck, CheckRateAndAccelerationOfALaw) {
  for (const TimedLaw& l : laws()) {
    int missed = 0, steps = 0;
    for (const double step : {1e-3, 0.01, 0.1}) {
      for (int k = 0; k < 150; ++k) {
        const double from = 0.5 + k * 0.01, to = from + step;
        for (const Diagnostic& d : check_derivatives(Law::function(l.motion), from, to)) {
          ADD_FAILURE() << l.name << " from " << from << " to " << to << ": " << d.what;
        }
        if (!l.find) continue;
        for (const bool rate : {true, false}) {
          const Law wrong = Law::function([&, rate](double t) {
            Motion m = l.motion(t);
            // The error counts the scale of the motion, because rate and acceleration may pass through zero.
            (rate ? m.rate : m.acceleration) += 1e-3 * (1 + std::abs(rate ? m.rate : m.acceleration));
            return m;
          });
          ++steps;
          const std::vector<Diagnostic> found = check_derivatives(wrong, from, to);
          const bool is_named =
              found.size() == 1 && found[0].what.rfind(rate ? "the rate at t = " : "the acceleration at t = ", 0) == 0;
          missed += is_named ? 0 : 1;
        }
      }
    }
    EXPECT_LE(missed, steps / 20) << l.name;
  }
}

TEST(FunctionCheck, FindAFunctionThatIsNotRepeatable) {
  int calls = 0;
  const Law law = Law::function([&](double t) { return Motion{t + 1e-4 * (++calls % 7), 1, 0}; });
  const std::vector<Diagnostic> wrong = check_derivatives(Law::constant(3) + law, 0, 0.01);
  ASSERT_EQ(wrong.size(), 1u);
  EXPECT_NE(wrong[0].what.find(" when it is called again"), std::string::npos) << wrong[0].what;

  const Case line{"", 1, 0, 1, 1, [](Arguments x) { return x[0]; }, [](Arguments, Results g) { g[0] = 1; }};
  Callback c = callback(line, -1);
  c.residual = [&](Arguments x, Results phi) { phi[0] = x[0] + 1e-4 * (++calls % 7); };
  EXPECT_EQ(found(line, c, {0.3}).rfind("residual[row 0] is ", 0), 0u);
}

TEST(FunctionCheck, ToleranceDecides) {
  const Case wrong{"", 1, 0, 1, 1, [](Arguments x) { return x[0]; }, [](Arguments, Results g) { g[0] = 2; }};
  Callback c = callback(wrong, -1);
  EXPECT_EQ(found(wrong, c, {0.3}).rfind("jacobian[row 0, P0.x] is 2, but differences of the residual give 1 ", 0), 0u);
  c.tolerance = 0.6;
  EXPECT_EQ(found(wrong, c, {0.3}), "");
  c.tolerance = std::numeric_limits<double>::infinity();
  EXPECT_EQ(found(wrong, c, {0.3}), "");
}

TEST(FunctionCheck, NeedOneEntryForEachArgument) {
  const std::vector<Case> all = cases();
  Callback c = callback(all[0], -1);
  EXPECT_THROW((void)check_derivatives(c, std::vector<double>{1, 2}), Error);
  EXPECT_THROW((void)check_derivatives(c, std::vector<double>{1, 2, 3}, std::vector<double>{1}), Error);
  c.equations = 0;
  EXPECT_THROW((void)check_derivatives(c, std::vector<double>{1, 2, 3}), Error);
}

}  // namespace
}  // namespace assur
