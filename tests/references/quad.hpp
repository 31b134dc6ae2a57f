// Quadruple precision for references: 113 bits, with derivatives.
#pragma once

#include <array>

#include "assur/number.hpp"
#include "scene/jet.hpp"
#include "verification/quad.hpp"

namespace assur::references {

using assur::Quad;
using QuadJet = Jet<Quad>;  // value, rate, acceleration

template <class T>
using Vec = std::array<T, 3>;  // z = 0 in the plane

template <class T>
Vec<T> operator+(const Vec<T>& a, const Vec<T>& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
template <class T>
Vec<T> operator-(const Vec<T>& a, const Vec<T>& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
template <class T>
Vec<T> operator*(const T& s, const Vec<T>& a) {
  return {s * a[0], s * a[1], s * a[2]};
}
template <class T>
T dot(const Vec<T>& a, const Vec<T>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class T>
Vec<T> cross(const Vec<T>& a, const Vec<T>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
template <class T>
Vec<T> unit(const Vec<T>& a) {
  using std::sqrt;
  return (T{1} / sqrt(dot(a, a))) * a;
}

// Doubles are converted exactly.
template <class T>
Vec<T> exactly(const Triple& a) {
  return {T{a[0].value()}, T{a[1].value()}, T{a[2].value()}};
}

// In the plane: the point at distance p from P and q from Q, to the left of P -> Q.
template <class T>
Vec<T> intersect_circles(const Vec<T>& P, double p, const Vec<T>& Q, double q) {
  using std::sqrt;
  const Vec<T> d = Q - P;
  const T square = dot(d, d), pp = T{p} * T{p}, qq = T{q} * T{q};
  const T along = (square + pp - qq) / (T{2} * square);
  const T across = sqrt(pp / square - along * along);
  return P + along * d + across * Vec<T>{-d[1], d[0], T{0}};
}

}  // namespace assur::references
