// The vector algebra of start postures. What depends on options is computed in Numbers, so that a tape records it.
#pragma once

#include <cmath>

#include "assur/scene.hpp"
#include "numbers.hpp"
#include "scene/recorded.hpp"
#include "scene/triple.hpp"

namespace assur::samples {

inline Triple operator+(const Triple& a, const Triple& b) { return recorded::add(a, b); }
inline Triple operator-(const Triple& a, const Triple& b) { return recorded::subtract(a, b); }
inline Triple operator*(const Number& s, const Triple& a) { return recorded::scale(s, a); }

using triple::cross;
using triple::dot;
using triple::norm;
inline Triple unit(const Triple& a) { return (1 / recorded::norm(a)) * a; }

// Horizontal unit vector in direction `azimuth` (from x towards y).
inline Triple heading(double azimuth) { return {std::cos(azimuth), std::sin(azimuth), 0}; }

// In the plane: the point at distance p from P and q from Q, to the left of P -> Q. NaN if the circles do not meet.
inline Triple meet(const Triple& P, const Number& p, const Triple& Q, const Number& q) {
  const Numbers from = numbers(P), d = numbers(Q - P);
  const Number square = recorded::dot(d, d);
  const Number along = (square + p * p - q * q) / (2 * square);
  const Number across = sqrt(p * p / square - along * along);
  return values({from[0] + along * d[0] - across * d[1], from[1] + along * d[1] + across * d[0], 0});
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
  return Law::harmonics({{amplitude.value(), (omega / kTurn).value(), phase}}, offset.value());
}

}  // namespace assur::samples
