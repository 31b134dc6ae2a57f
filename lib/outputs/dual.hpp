// Dual numbers: a value with its derivative along a direction. Arithmetic on them differentiates, exact up to rounding.
#pragma once

#include <cmath>
#include <type_traits>

namespace assur {

// N: double, or a value of a step program.
template <class N>
struct DualOf {
  N value{}, slope{};

  DualOf() = default;
  DualOf(const N& v, const N& s) : value(v), slope(s) {}
  DualOf(double v)  // NOLINT(google-explicit-constructor): a number like any other
      requires std::is_same_v<N, double> : value(v) {}

  friend DualOf operator-(const DualOf& a) { return {-a.value, -a.slope}; }
  friend DualOf operator+(const DualOf& a, const DualOf& b) { return {a.value + b.value, a.slope + b.slope}; }
  friend DualOf operator-(const DualOf& a, const DualOf& b) { return {a.value - b.value, a.slope - b.slope}; }
  friend DualOf operator*(const DualOf& a, const DualOf& b) {
    return {a.value * b.value, a.slope * b.value + a.value * b.slope};
  }
  friend DualOf operator*(double a, const DualOf& b) { return {a * b.value, a * b.slope}; }
  friend DualOf operator/(const DualOf& a, const DualOf& b) {
    const N quotient = a.value / b.value;
    return {quotient, (a.slope - quotient * b.slope) / b.value};
  }
  friend bool operator<(const DualOf& a, const DualOf& b) { return a.value < b.value; }
  friend bool operator>(const DualOf& a, const DualOf& b) { return a.value > b.value; }
};
using Dual = DualOf<double>;

inline Dual sqrt(const Dual& a) {
  const double root = std::sqrt(a.value);
  return {root, a.slope == 0 ? 0 : a.slope / (2 * root)};
}
// The slope of atan2.
template <class N>
N slope_of_angle(const DualOf<N>& y, const DualOf<N>& x) {
  const N square = x.value * x.value + y.value * y.value;
  return (x.value * y.slope - y.value * x.slope) / square;
}
inline Dual atan2(const Dual& y, const Dual& x) { return {std::atan2(y.value, x.value), slope_of_angle(y, x)}; }

}  // namespace assur
