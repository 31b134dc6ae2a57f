// Random planar mechanisms on their way to a singular posture, which they miss by a distance drawn between 1 and 1e-16.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "simulation/random_mechanisms.hpp"

namespace assur::test {

inline double small_number(Draw& draw) { return std::pow(10.0, draw.real(-16, 0)); }

// A crank about A that carries B, a dyad B-C-D: coupler and rocker are in line, outstretched or folded, at the end.
inline Scene dyad_at_its_fold(Draw& draw, int steps) {
  const bool outstretched = draw.maybe();
  const double crank = draw.real(0.3, 1.5), ground = crank + draw.real(0.3, 2), last = draw.real(0.5, 2.5);
  const double span = std::hypot(crank * std::cos(last) - ground, crank * std::sin(last));
  const double missed = small_number(draw), share = draw.real(0.2, 0.8);
  const double coupler = outstretched ? span * (1 + missed) * share : span * (1 - missed / 2) + share;
  const double rocker = outstretched ? span * (1 + missed) * (1 - share) : share;
  // |B - D| grows with the angle of the crank: towards the outer fold forwards, towards the inner one backwards.
  const double first = last + (outstretched ? -1 : 1) * draw.real(0.1, 0.45);
  const Triple B = {crank * std::cos(first), crank * std::sin(first), 0};
  const double from = std::hypot(ground - B[0], B[1]);
  const double along = (coupler * coupler - rocker * rocker + from * from) / (2 * from);
  const double beside = (draw.maybe() ? 1 : -1) * std::sqrt(std::max(coupler * coupler - along * along, 0.0));
  const double ux = (ground - B[0]) / from, uy = -B[1] / from;
  SceneBuilder b("fold", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("D", {ground, 0, 0}).point("B", B);
  b.point("C", {B[0] + along * ux - beside * uy, B[1] + along * uy + beside * ux, 0});
  b.constrain("crank", Distance{"A", "B", crank});
  b.constrain("coupler", Distance{"B", "C", coupler}).constrain("rocker", Distance{"C", "D", rocker});
  b.drive("motor", PointAngle{"A", "B", "", Law::polynomial({first, last - first})});
  b.measure("angle", AbsoluteAngle{"D", "C"});
  return b.time(0, 1, 1.0 / steps).build();
}

// A parallelogram but for the length of its rocker: two branches that nearly cross when all bars are in line.
inline Scene almost_parallelogram(Draw& draw, int steps) {
  const double scale = draw.real(0.3, 3), crank = scale * draw.real(0.3, 0.8), ground = scale * draw.real(1, 2);
  const double rocker = crank * (1 + small_number(draw));
  const double first = draw.real(0.3, 2.8), span = draw.real(3.3, 6);
  const Triple B = {crank * std::cos(first), crank * std::sin(first), 0};
  SceneBuilder b("almost", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("D", {ground, 0, 0});
  b.point("B", B).point("C", {B[0] + ground, B[1], 0});
  b.constrain("crank", Distance{"A", "B", crank});
  b.constrain("coupler", Distance{"B", "C", ground}).constrain("rocker", Distance{"C", "D", rocker});
  b.drive("motor", PointAngle{"A", "B", "", Law::polynomial({first, span})});
  return b.time(0, 1, 1.0 / steps).build();
}

// A platform on three legs of given length, whose lines meet in one point at the end, or nearly.
inline Scene three_legs_that_meet(Draw& draw, int steps) {
  const double missed = small_number(draw), turn = draw.real(-0.2, 0.2);
  const Triple meet = {draw.real(-0.4, 0.4), draw.real(-0.4, 0.4), 0};
  const Triple shift = {draw.real(-0.15, 0.15), draw.real(-0.15, 0.15), 0};
  SceneBuilder b("three_legs", 2);
  std::array<Triple, 3> at;
  for (int i = 0; i < 3; ++i) {
    const std::string k = std::to_string(i);
    const double azimuth = 2 * std::numbers::pi * i / 3 + draw.real(-0.4, 0.4), radius = draw.real(0.3, 0.6);
    const Triple P = {radius * std::cos(azimuth), radius * std::sin(azimuth), 0};
    const double reach = draw.real(1.5, 3);
    const Triple A = {meet[0] + reach * (P[0] - meet[0]) + missed * draw.real(-1, 1),
                      meet[1] + reach * (P[1] - meet[1]) + missed * draw.real(-1, 1), 0};
    at[static_cast<std::size_t>(i)] = {std::cos(turn) * P[0] - std::sin(turn) * P[1] + shift[0],
                                       std::sin(turn) * P[0] + std::cos(turn) * P[1] + shift[1], 0};
    const Triple& Q = at[static_cast<std::size_t>(i)];
    const double first = std::hypot(Q[0] - A[0], Q[1] - A[1]), last = std::hypot(P[0] - A[0], P[1] - A[1]);
    b.fixed_point("A" + k, A).point("P" + k, Q);
    b.drive("leg" + k, DrivenDistance{"A" + k, "P" + k, Law::polynomial({first, last - first})});
  }
  add_sides(b);
  return b.time(0, 1, 1.0 / steps).build();
}

inline Scene near_singular(Draw& draw) {
  const int steps = 5 + static_cast<int>(draw.below(30));
  switch (draw.below(3)) {
    case 0:
      return dyad_at_its_fold(draw, steps);
    case 1:
      return almost_parallelogram(draw, steps);
    default:
      return three_legs_that_meet(draw, steps);
  }
}

}  // namespace assur::test
