// The vector algebra of start postures.
#pragma once

#include <cmath>

#include "assur/scene.hpp"
#include "numbers.hpp"
#include "scene/triple.hpp"

namespace assur::samples {

inline Triple operator+(const Triple& a, const Triple& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Triple operator-(const Triple& a, const Triple& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Triple operator*(double s, const Triple& a) { return {s * a[0], s * a[1], s * a[2]}; }

using triple::cross;
using triple::dot;
using triple::norm;
inline Triple unit(const Triple& a) { return (1 / norm(a)) * a; }

// Horizontal unit vector in direction `azimuth` (from x towards y).
inline Triple heading(double azimuth) { return {std::cos(azimuth), std::sin(azimuth), 0}; }

// In the plane: the point at distance p from P and q from Q, to the left of P -> Q. NaN if the circles do not meet.
inline Triple meet(const Triple& P, double p, const Triple& Q, double q) {
  const Triple d = Q - P;
  const double square = dot(d, d);
  const double along = (square + p * p - q * q) / (2 * square);
  const double across = std::sqrt(p * p / square - along * along);
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
inline Law wave(double amplitude, double omega, double phase, double offset = 0) {
  return Law::harmonics({{amplitude, omega / kTurn, phase}}, offset);
}

}  // namespace assur::samples
