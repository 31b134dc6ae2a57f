// The vector algebra of start postures.
#pragma once

#include <cmath>

#include "assur/scene.hpp"
#include "numbers.hpp"
#include "scene/triple.hpp"

namespace assur::samples {

inline Triple operator+(const Triple& a, const Triple& b) { return triple::add(a, b); }
inline Triple operator-(const Triple& a, const Triple& b) { return triple::subtract(a, b); }
inline Triple operator*(const Number& s, const Triple& a) { return triple::scale(s, a); }

using triple::cross;
using triple::dot;
using triple::norm;
using triple::unit;

// Horizontal unit vector in direction `azimuth` (from x towards y).
inline Triple heading(double azimuth) { return {std::cos(azimuth), std::sin(azimuth), 0}; }

// In the plane: the point at distance p from P and q from Q, to the left of P -> Q. NaN if the circles do not meet.
inline Triple meet(const Triple& P, const Number& p, const Triple& Q, const Number& q) {
  const Triple d = Q - P;
  const Number square = triple::dot(d, d);
  const Number along = (square + p * p - q * q) / (2 * square);
  const Number across = sqrt(p * p / square - along * along);
  return {P[0] + along * d[0] - across * d[1], P[1] + along * d[1] + across * d[0], 0};
}

// Columns of R = Rz(psi) Ry(theta) Rx(phi).
struct Axes {
  Triple u, v, w;
};
inline Axes euler_zyx(double psi, double theta, double phi) {
  const double cp = std::cos(psi), sp = std::sin(psi), ct = std::cos(theta), st = std::sin(theta);
  const double cf = std::cos(phi), sf = std::sin(phi);
  return {{cp * ct, sp * ct, -st},
          {cp * st * sf - sp * cf, sp * st * sf + cp * cf, ct * sf},
          {cp * st * cf + sp * sf, sp * st * cf - cp * sf, ct * cf}};
}

// offset + amplitude * sin(omega t + phase)
inline Law wave(const Number& amplitude, const Number& omega, double phase, const Number& offset = 0) {
  return Law::harmonics({{amplitude, omega / kTurn, phase}}, offset);
}

}  // namespace assur::samples
