// Closed forms of the planar samples: the motion at time t in quad, from the doubles of the scene.
// They return the moving points (and scalars) by name; add the fixed ones by at_guess.
#pragma once

#include <numbers>
#include <string>

#include "references/posture.hpp"

namespace assur::references {

inline Vec<QuadJet> on_circle(const Vec<QuadJet>& centre, double radius, const QuadJet& angle) {
  return centre + QuadJet{radius} * Vec<QuadJet>{cos(angle), sin(angle), QuadJet{}};
}

inline Vec<QuadJet> at_rest(double x, double y) { return {QuadJet{x}, QuadJet{y}, QuadJet{}}; }

// sample("four_bar:LOOPS"): B0, B1, ...; omega is the speed of the crank, rad/s.
inline Posture<QuadJet> four_bar_chain(int loops, double t, double omega = 2 * std::numbers::pi) {
  Posture<QuadJet> posture;
  Vec<QuadJet> b = on_circle(at_rest(0, 0), 0.8, {Quad(omega) * t, omega, 0});
  posture["B0"] = b;
  for (int i = 1; i <= loops; ++i) {
    b = intersect_circles(b, i == 1 ? 1.8 : 2.0, at_rest(2 * i, 0), 1.3);
    posture["B" + std::to_string(i)] = b;
  }
  return posture;
}

// sample("n_four_bar:LOOPS"): B_i = (i + cos f, sin f), f = pi/2 + 1.2 sin t
inline Posture<QuadJet> n_four_bar(int loops, double t) {
  const Law f = Law::harmonics({{1.2, 1 / (2 * std::numbers::pi), 0}}, std::numbers::pi / 2);
  Posture<QuadJet> posture;
  for (int i = 0; i <= loops; ++i) {
    posture["B" + std::to_string(i)] = on_circle(at_rest(i, 0), 1, evaluate<Quad>(f, Quad(t)));
  }
  return posture;
}

// sample("parallelograms:LOOPS"): B_i = (2i + cos f, sin f), f = pi/2 + 1.2 sin t
inline Posture<QuadJet> parallelograms(int loops, double t) {
  const Law f = Law::harmonics({{1.2, 1 / (2 * std::numbers::pi), 0}}, std::numbers::pi / 2);
  Posture<QuadJet> posture;
  for (int i = 0; i <= loops; ++i) {
    posture["B" + std::to_string(i)] = on_circle(at_rest(2 * i, 0), 1, evaluate<Quad>(f, Quad(t)));
  }
  return posture;
}

// sample("almost_parallelogram:delta=DELTA"), delta > 0: B0 (crank), B1 (rocker). B0, B1 and the rocker's centre are
// never in line, so B1 stays on the left of B0 -> A1, where it starts: the only continuous branch.
inline Posture<QuadJet> almost_parallelogram(double delta, double t) {
  const Law turn = Law::polynomial({std::numbers::pi / 2, 2 * std::numbers::pi});
  const Vec<QuadJet> crank = on_circle(at_rest(0, 0), 1, evaluate<Quad>(turn, Quad(t)));
  return {{"B0", crank}, {"B1", intersect_circles(crank, 2, at_rest(2, 0), 1 + delta)}};
}

// sample("slider_crank:offset=OFFSET,crank_length=CRANK,rod_length=ROD"): B, C, slide.lambda
inline Posture<QuadJet> slider_crank(double offset, double t, double crank = 0.1, double rod = 0.3) {
  const double omega = 2 * std::numbers::pi;
  const Vec<QuadJet> b = on_circle(at_rest(0, 0), crank, {Quad(omega) * t, omega, 0});
  const QuadJet rise = b[1] - offset;
  const QuadJet x = b[0] + sqrt(Quad(rod) * Quad(rod) - rise * rise);
  return {{"B", b}, {"C", {x, QuadJet{offset}, QuadJet{}}}, {"slide.lambda", {x, QuadJet{}, QuadJet{}}}};
}

}  // namespace assur::references
