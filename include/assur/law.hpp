// Laws: scalar functions of time with two derivatives. Units are SI, angles are in rad.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "assur/number.hpp"

namespace assur {

// A value with its first and second time derivative.
template <class T>
struct Jet {
  T value{};         // in the unit of the quantity
  T rate{};          // in that unit per s
  T acceleration{};  // in that unit per s^2
};
// The motion of one scalar at one time.
using Motion = Jet<double>;

// amplitude * sin(2 pi frequency t + phase)
struct Harmonic {
  Number amplitude = 0;  // in the unit of the law
  Number frequency = 0;  // Hz
  Number phase = 0;      // rad
  friend bool operator==(const Harmonic&, const Harmonic&) = default;
};

// Default tolerance for the derivatives that functions of the program return, which check_derivatives() and prepare()
// compare with differences (docs/accuracy.md). The tolerated error is this fraction of the derivative, plus a tenth of
// this fraction of the largest related number: of a Jacobian and a curvature the largest entry of the row of the
// Jacobian, of a law the value or rate divided by 100 time steps.
inline constexpr double kDerivativeTolerance = 1e-5;

// A function of time, made of parts that are added: Law::constant(1) + Law::harmonics({...}). A law does not
// change, so any number of threads may use it; copies share their parts.
class Law {
 public:
  // The part c0 + c1 t + c2 t^2 + ...
  struct Polynomial {
    std::vector<Number> coefficients;  // c0, c1, c2, ...; t is absolute time
    friend bool operator==(const Polynomial&, const Polynomial&) = default;
  };
  // The part offset + sum of harmonics.
  struct Harmonics {
    std::vector<Harmonic> terms;  // any number, also none
    Number offset = 0;            // in the unit of the law
    friend bool operator==(const Harmonics&, const Harmonics&) = default;
  };
  // The part that interpolates a table by cubics: a C2 spline, either periodic or with not-a-knot ends (2 knots give a
  // line, 3 knots a parabola); or a monotone one, which is C1: its acceleration jumps at knots.
  struct Spline {
    std::vector<double> time;    // knots: s, ascending, at least 2
    std::vector<double> value;   // same size; a periodic spline ends with its first value
    std::vector<double> second;  // second derivatives: at the knots; of a monotone one at both ends of each interval
    bool periodic = false;       // true: defined at any time; false: between first and last knot
    bool monotone = false;       // true: between two knots it stays between their values

    // Second derivatives at both ends of the interval between knots k and k + 1.
    [[nodiscard]] std::array<double, 2> bends(std::size_t k) const {
      return monotone ? std::array{second[2 * k], second[2 * k + 1]} : std::array{second[k], second[k + 1]};
    }
    friend bool operator==(const Spline&, const Spline&) = default;
  };
  // The part that a function of the program computes, see Law::function().
  struct Function {
    std::function<Motion(double)> motion;     // t in s -> value, rate and acceleration
    double tolerance = kDerivativeTolerance;  // of its derivatives; infinite: not checked
  };
  // One addend of a law.
  using Part = std::variant<Polynomial, Harmonics, Spline, Function>;

  Law() = default;  // constant zero
  // The law that is `value` at all times. Throws Error (input) if the value is not finite.
  [[nodiscard]] static Law constant(const Number& value);
  // The law c0 + c1 t + c2 t^2 + ... with absolute time t. Throws Error (input) if a coefficient is not finite.
  [[nodiscard]] static Law polynomial(std::vector<Number> coefficients);
  // The same from doubles.
  template <std::same_as<double> T>
  [[nodiscard]] static Law polynomial(const std::vector<T>& coefficients) {
    return polynomial(std::vector<Number>(coefficients.begin(), coefficients.end()));
  }
  // The law offset + sum of the terms. Throws Error (input) if a number is not finite.
  [[nodiscard]] static Law harmonics(std::vector<Harmonic> terms, const Number& offset = 0);
  // A cubic spline through the points (time[i], value[i]), see Spline. Throws Error (input) for fewer than 2 points,
  // for sizes that differ, for numbers that are not finite, for times that do not ascend, for points so close or so
  // large that the spline overflows, and for a periodic table that does not end with its first value (within a relative
  // 1e-12).
  [[nodiscard]] static Law table(std::vector<double> time, std::vector<double> value, bool periodic = false);
  // The same. The C2 spline overshoots at corners of a table; a monotone one stays between the values of neighbouring
  // points (Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5, 1984), but its acceleration jumps at the points.
  [[nodiscard]] static Law table(std::vector<double> time, std::vector<double> value, bool periodic, bool monotone);
  // A law that `motion` computes. assur may call it at any time of the run, repeatedly, and on several threads at once
  // (Simulator, Ensemble); the same time must give the same answer. Exceptions that it throws propagate through the
  // call that needed the law. assur trusts the value and checks rate and acceleration (docs/accuracy.md). Raise
  // `tolerance` if the derivatives are approximations, e.g. of a fit to measurements; an infinite one switches the
  // check off. Throws Error (input) if `motion` is empty or if `tolerance` is negative or NaN.
  [[nodiscard]] static Law function(std::function<Motion(double)> motion, double tolerance = kDerivativeTolerance);

  // The sum of two laws.
  friend Law operator+(const Law& a, const Law& b);

  // The motion at time t (s). NaN outside the range of a table; 4 units in the last place beyond its ends count as
  // inside, because times of a grid are rounded.
  [[nodiscard]] Motion operator()(double t) const;

  // True if no part depends on time; false if there is a function of the program. A driver with a constant law moves
  // nothing.
  [[nodiscard]] bool is_constant() const;

  // True if t lies within the range of every table that is not periodic.
  [[nodiscard]] bool covers(double t) const;

  // True if both laws have equal parts. Functions of the program are equal only in a law and its copy.
  friend bool operator==(const Law& a, const Law& b);

  // The parts that are added; none: constant zero. Valid as long as the law or a copy of it.
  [[nodiscard]] const std::vector<Part>& parts() const { return *parts_; }

 private:
  friend class Recipe;
  explicit Law(std::vector<Part> parts) : parts_(std::make_shared<const std::vector<Part>>(std::move(parts))) {}
  std::shared_ptr<const std::vector<Part>> parts_ = std::make_shared<const std::vector<Part>>();
};

}  // namespace assur
