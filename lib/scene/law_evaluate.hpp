// Evaluates a law in the arithmetic of T (double, or quad for the reference), from the same double parameters.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <span>
#include <variant>

#include "assur/law.hpp"
#include "numbers.hpp"
#include "scene/jet.hpp"

namespace assur {
namespace law_detail {

inline double plain(double x) { return x; }
inline double plain(const Number& x) { return x.value(); }

// c0 + c1 t + c2 t^2 + ...
template <class N, class T>
Jet<T> horner(std::span<const N> coefficients, const T& t) {
  T value = 0, rate = 0, half_acceleration = 0;  // Horner's rule, differentiated twice
  for (std::size_t i = coefficients.size(); i-- > 0;) {
    half_acceleration = half_acceleration * t + rate;
    rate = rate * t + value;
    value = value * t + plain(coefficients[i]);
  }
  return {value, rate, 2 * half_acceleration};
}
template <class T>
Jet<T> evaluate(const Law::Polynomial& polynomial, const T& t) {
  return horner(std::span(polynomial.coefficients), t);
}

// The fractional part of frequency * t, without the rounding error of a large product.
inline double cycles(double frequency, double t) {
  const double product = frequency * t;
  const double lost = std::fma(frequency, t, -product);
  return (product - std::nearbyint(product)) + (lost - std::nearbyint(lost));
}
template <class T>
T cycles(double frequency, const T& t) {
  using std::floor;
  const T product = frequency * t;  // exact in quad for a t that is a double
  const T fraction = product - floor(product);
  return fraction > 0.5 ? T(fraction - 1) : fraction;
}

template <class T>
T two_pi() {
  using std::atan2;
  static const T value = 2 * atan2(T(0), T(-1));
  return value;
}
template <>
inline double two_pi<double>() {
  return 6.283185307179586476925286766559;
}

template <class T>
Jet<T> evaluate(const Law::Harmonics& harmonics, const T& t) {
  using std::cos;
  using std::sin;
  Jet<T> sum{T(harmonics.offset.value()), T(0), T(0)};
  for (const Harmonic& term : harmonics.terms) {
    const T omega = two_pi<T>() * term.frequency.value();
    const T angle = two_pi<T>() * cycles(term.frequency.value(), t) + term.phase.value();
    const T s = term.amplitude.value() * sin(angle);
    const T c = term.amplitude.value() * cos(angle);
    sum += Jet<T>{s, omega * c, -(omega * omega) * s};
  }
  return sum;
}

// Times of a grid are rounded, so a time this little outside a table is taken as its end.
inline double slack(const Law::Spline& spline) {
  return 4 * kEps * std::max(std::abs(spline.time.front()), std::abs(spline.time.back()));
}

template <class T>
bool covers(const Law::Spline& spline, const T& t) {
  if (spline.periodic) return true;
  return t >= spline.time.front() - slack(spline) && t <= spline.time.back() + slack(spline);
}

// What rounding takes from last - first (two-sum of Knuth, TAOCP 2, 4.2.2).
inline double lost_period(double first, double last) {
  const double period = last - first, back = last - period;
  return (last - (back + period)) + (back - first);
}

// t minus whole periods, within the table. The period is a double plus its rounding error, so that a thousand periods
// add no error.
template <class T>
T wrap(const Law::Spline& spline, const T& t) {
  using std::floor;
  const T first = spline.time.front(), last = spline.time.back();
  const T period = last - first;
  const T count = floor((t - first) / period);
  if constexpr (std::same_as<T, double>) {
    return std::fma(-count, period, t) - count * lost_period(first, last);
  } else {
    return t - count * period;
  }
}

// The interval k that contains t: time[k] <= t < time[k + 1]; the first and last one include times that rounding put
// outside.
template <class T>
std::size_t interval(const Law::Spline& spline, const T& t) {
  const auto inner = std::upper_bound(spline.time.begin() + 1, spline.time.end() - 1, t);
  return static_cast<std::size_t>(inner - spline.time.begin()) - 1;
}

template <class T>
Jet<T> evaluate(const Law::Spline& spline, const T& time) {
  if (!covers(spline, time)) {
    const T nan = std::numeric_limits<T>::quiet_NaN();
    return {nan, nan, nan};
  }
  const T t = spline.periodic ? wrap(spline, time) : time;
  const std::size_t k = interval(spline, t);
  const T begin = spline.time[k], end = spline.time[k + 1];
  const T y0 = spline.value[k], y1 = spline.value[k + 1];
  const auto [left, right] = spline.bends(k);
  const T m0 = left, m1 = right;
  const T h = end - begin;
  const T a = (end - t) / h, b = (t - begin) / h;
  return {a * y0 + b * y1 - a * b * h * h / 6 * ((1 + a) * m0 + (1 + b) * m1),  // exact at both knots
          (y1 - y0) / h + h / 6 * ((3 * b * b - 1) * m1 - (3 * a * a - 1) * m0), a * m0 + b * m1};
}

template <class T>
Jet<T> evaluate(const Law::Function& function, const T& t) {
  const Motion motion = function.motion(static_cast<double>(t));
  return {T(motion.value), T(motion.rate), T(motion.acceleration)};
}

}  // namespace law_detail

// Value and two derivatives at t; NaN outside the range of a table. A Function part is evaluated in double.
// Allocates nothing if T does not.
template <class T>
Jet<T> evaluate(const Law& law, const T& t) {
  Jet<T> sum{T(0), T(0), T(0)};
  for (const Law::Part& part : law.parts()) {
    sum += std::visit([&](const auto& p) { return law_detail::evaluate(p, t); }, part);
  }
  return sum;
}

}  // namespace assur
