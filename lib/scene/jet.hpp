// Arithmetic on a value and its first two time derivatives. T is double or a multiprecision float: functions are
// found by argument-dependent lookup beside those of std.
#pragma once

#include <cmath>
#include <span>
#include <type_traits>

#include "assur/law.hpp"

namespace assur {

template <class T>
using Scalar = std::type_identity_t<T>;  // is not deduced, so that 2 * Jet<quad> works

template <class T>
Jet<T> operator+(const Jet<T>& a, const Jet<T>& b) {
  return {a.value + b.value, a.rate + b.rate, a.acceleration + b.acceleration};
}
template <class T>
Jet<T> operator-(const Jet<T>& a, const Jet<T>& b) {
  return {a.value - b.value, a.rate - b.rate, a.acceleration - b.acceleration};
}
template <class T>
Jet<T> operator-(const Jet<T>& a) {
  return {-a.value, -a.rate, -a.acceleration};
}
template <class T>
Jet<T> operator*(const Jet<T>& a, const Jet<T>& b) {
  return {a.value * b.value, a.rate * b.value + a.value * b.rate,
          a.acceleration * b.value + 2 * (a.rate * b.rate) + a.value * b.acceleration};
}
template <class T>
Jet<T> operator/(const Jet<T>& a, const Jet<T>& b) {
  const T value = a.value / b.value;  // from a = value * b, differentiated twice
  const T rate = (a.rate - value * b.rate) / b.value;
  const T acceleration = (a.acceleration - 2 * (rate * b.rate) - value * b.acceleration) / b.value;
  return {value, rate, acceleration};
}

template <class T>
Jet<T> operator+(const Jet<T>& a, const Scalar<T>& b) {
  return {a.value + b, a.rate, a.acceleration};
}
template <class T>
Jet<T> operator+(const Scalar<T>& a, const Jet<T>& b) {
  return b + a;
}
template <class T>
Jet<T> operator-(const Jet<T>& a, const Scalar<T>& b) {
  return {a.value - b, a.rate, a.acceleration};
}
template <class T>
Jet<T> operator-(const Scalar<T>& a, const Jet<T>& b) {
  return {a - b.value, -b.rate, -b.acceleration};
}
template <class T>
Jet<T> operator*(const Jet<T>& a, const Scalar<T>& b) {
  return {a.value * b, a.rate * b, a.acceleration * b};
}
template <class T>
Jet<T> operator*(const Scalar<T>& a, const Jet<T>& b) {
  return b * a;
}
template <class T>
Jet<T> operator/(const Jet<T>& a, const Scalar<T>& b) {
  return {a.value / b, a.rate / b, a.acceleration / b};
}
template <class T>
Jet<T> operator/(const Scalar<T>& a, const Jet<T>& b) {
  return Jet<T>{a} / b;
}

template <class T>
Jet<T>& operator+=(Jet<T>& a, const Jet<T>& b) {
  return a = a + b;
}
template <class T>
Jet<T>& operator-=(Jet<T>& a, const Jet<T>& b) {
  return a = a - b;
}

// Derivatives are not finite where value is 0.
template <class T>
Jet<T> sqrt(const Jet<T>& a) {
  using std::sqrt;
  const T root = sqrt(a.value);  // from a = root * root, differentiated twice
  const T rate = a.rate / (2 * root);
  const T acceleration = (a.acceleration / 2 - rate * rate) / root;
  return {root, rate, acceleration};
}

// Length of a vector. At zero it has a kink, and no derivatives (NaN) unless the vector is at rest. Elsewhere it is not
// computed as the root of a sum of squares, because its second derivative would cancel if the rate lies along a short
// vector.
template <class T>
Jet<T> length(std::span<const Jet<T>> of) {
  using std::sqrt;
  const auto norm = [&](T Jet<T>::*part) {
    T square = 0;
    for (const Jet<T>& x : of) square = square + x.*part * x.*part;
    return sqrt(square);
  };
  const T root = norm(&Jet<T>::value);
  if (!(root > T(0))) {
    if (!(norm(&Jet<T>::rate) > T(0))) return {T(0), T(0), norm(&Jet<T>::acceleration)};
    const T none = T(0) / T(0);
    return {T(0), none, none};
  }
  T along = 0, bent = 0;
  for (const Jet<T>& x : of) along = along + x.value * x.rate;
  const T rate = along / root;
  for (const Jet<T>& x : of) {
    const T across = x.rate - rate * x.value / root;
    bent = bent + x.value * x.acceleration + across * across;
  }
  return {root, rate, bent / root};
}

// cos and sin of an angle, at the cost of one pair.
template <class T>
struct CosSin {
  Jet<T> cosine, sine;
};
template <class T>
CosSin<T> cos_sin(const Jet<T>& a, const Scalar<T>& c, const Scalar<T>& s) {  // c and s: cosine and sine of the value
  return {{c, -s * a.rate, -s * a.acceleration - c * a.rate * a.rate},
          {s, c * a.rate, c * a.acceleration - s * a.rate * a.rate}};
}
template <class T>
CosSin<T> cos_sin(const Jet<T>& a) {
  using std::cos;
  using std::sin;
  return cos_sin(a, cos(a.value), sin(a.value));
}
template <class T>
Jet<T> sin(const Jet<T>& a) {
  return cos_sin(a).sine;
}
template <class T>
Jet<T> cos(const Jet<T>& a) {
  return cos_sin(a).cosine;
}

// Angle of (x, y) with this value. Derivatives are not finite at the origin.
template <class T>
Jet<T> angle_of(const Scalar<T>& value, const Jet<T>& y, const Jet<T>& x) {
  const T square = x.value * x.value + y.value * y.value;
  const T rate = (x.value * y.rate - y.value * x.rate) / square;
  const T radial = (x.value * x.rate + y.value * y.rate) / square;
  const T acceleration = (x.value * y.acceleration - y.value * x.acceleration) / square - 2 * (rate * radial);
  return {value, rate, acceleration};
}
// From +x in (-pi, pi].
template <class T>
Jet<T> atan2(const Jet<T>& y, const Jet<T>& x) {
  using std::atan2;
  return angle_of<T>(atan2(y.value, x.value), y, x);
}

}  // namespace assur
