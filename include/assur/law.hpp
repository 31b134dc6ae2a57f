// Laws: scalars as functions of time with two derivatives. SI units and rad.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace assur {

// A value with its first and second time derivative.
template <class T>
struct Jet {
  T value{};
  T rate{};
  T acceleration{};
};
using Motion = Jet<double>;

// offset + sum amplitude * sin(2 pi frequency t + phase)
struct Harmonic {
  double amplitude = 0;
  double frequency = 0;  // Hz
  double phase = 0;      // rad
  friend bool operator==(const Harmonic&, const Harmonic&) = default;
};

// Derivatives that a program's functions give are held against differences, now and then, in scenes and along runs;
// they may be off by this much, relative to themselves, and by a tenth of it relative to the largest derivative beside
// them.
inline constexpr double kDerivativeTolerance = 1e-5;

// A value; copies share their parts. Laws add up: Law::constant(1) + Law::harmonics({...}).
class Law {
 public:
  struct Polynomial {
    std::vector<double> coefficients;  // c0 + c1 t + c2 t^2 + ..., absolute t
    friend bool operator==(const Polynomial&, const Polynomial&) = default;
  };
  struct Harmonics {
    std::vector<Harmonic> terms;
    double offset = 0;
    friend bool operator==(const Harmonics&, const Harmonics&) = default;
  };
  // C2 cubic spline: not-a-knot ends (2 points: a line, 3 points: a parabola), or periodic with the last value
  // equal to the first.
  struct Spline {
    std::vector<double> time;    // ascending, at least 2
    std::vector<double> value;   // same size
    std::vector<double> second;  // second derivative at the knots
    bool periodic = false;
    friend bool operator==(const Spline&, const Spline&) = default;
  };
  struct Function {
    std::function<Motion(double)> motion;
    double tolerance = kDerivativeTolerance;
  };
  using Part = std::variant<Polynomial, Harmonics, Spline, Function>;

  Law() = default;  // constant zero
  // All of these throw Error (input) for a number that is not finite.
  [[nodiscard]] static Law constant(double value);
  [[nodiscard]] static Law polynomial(std::vector<double> coefficients);
  [[nodiscard]] static Law harmonics(std::vector<Harmonic> terms, double offset = 0);
  // Throws Error (input) for under 2 rows, sizes that differ, times that do not ascend, a period that does not close.
  [[nodiscard]] static Law table(std::vector<double> time, std::vector<double> value, bool periodic = false);
  // t -> {value, rate, acceleration}; must be callable at any time of the run, and again after a rejected step, with
  // the same answer. What it throws passes through the step that asked. The value is trusted; its rate and acceleration
  // are checked (see docs/accuracy.md). `tolerance`: how far they may be off, for laws made of measurements
  // whose derivatives are those of another fit; infinite: nothing is checked. Throws Error (input) if it is negative.
  [[nodiscard]] static Law function(std::function<Motion(double)> motion, double tolerance = kDerivativeTolerance);

  friend Law operator+(const Law& a, const Law& b);

  // NaN outside the range of a table (4 units in the last place more count as inside: times of a grid are rounded).
  [[nodiscard]] Motion operator()(double t) const;

  // True if value does not depend on time: a driver with such a law does not move anything.
  [[nodiscard]] bool is_constant() const;

  // True if t lies within every (non-periodic) table.
  [[nodiscard]] bool covers(double t) const;

  // True if both are surely the same: parts with equal numbers, or (with functions of the program) a law and its copy.
  friend bool operator==(const Law& a, const Law& b);

  [[nodiscard]] const std::vector<Part>& parts() const { return *parts_; }

 private:
  explicit Law(std::vector<Part> parts) : parts_(std::make_shared<const std::vector<Part>>(std::move(parts))) {}
  std::shared_ptr<const std::vector<Part>> parts_ = std::make_shared<const std::vector<Part>>();
};

}  // namespace assur
