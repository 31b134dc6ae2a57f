// Random planar mechanisms that approach a singular posture up to a random distance between 1 and 1e-16.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "properties/small_random_scenes.hpp"

namespace assur::test {

inline double small_number(Draw& draw) { return std::pow(10.0, draw.real(-16, 0)); }

// A crank about A with its end B, and a dyad B-C-D. At the end, coupler and rocker are in line, stretched or folded.
inline Scene dyad_at_its_fold(Draw& draw, int steps) {
  const bool outstretched = draw.maybe();
  const double crank = draw.real(0.3, 1.5), ground = crank + draw.real(0.3, 2), last = draw.real(0.5, 2.5);
  const double span = std::hypot(crank * std::cos(last) - ground, crank * std::sin(last));
  const double missed = small_number(draw), share = draw.real(0.2, 0.8);
  const double coupler = outstretched ? span * (1 + missed) * share : span * (1 - missed / 2) + share;
  const double rocker = outstretched ? span * (1 + missed) * (1 - share) : share;
  // |B - D| grows with the angle of the crank, so the crank turns forwards to the outer fold and backwards to the inner
  // one.
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

// A parallelogram except for the length of its rocker: two branches nearly cross when all bars are in line.
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

// A platform on three legs of given length, whose lines nearly meet in one point at the end.
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

// A platform on six legs with oscillating lengths: forward kinematics with folds and nearly singular postures.
inline Scene six_legs(Draw& draw, int steps) {
  SceneBuilder b("six_legs", 3);
  Body platform{"platform", "O", {"u", "v", "w"}, {}, {}, {}};
  const Triple O = {draw.real(-0.2, 0.2), draw.real(-0.2, 0.2), draw.real(0.8, 1.2)};
  const double psi = draw.real(-0.6, 0.6), theta = draw.real(-0.5, 0.5), phi = draw.real(-0.5, 0.5);
  const double c1 = std::cos(psi), s1 = std::sin(psi), c2 = std::cos(theta), s2 = std::sin(theta), c3 = std::cos(phi),
               s3 = std::sin(phi);
  const Triple u = {c1 * c2, s1 * c2, -s2}, v = {c1 * s2 * s3 - s1 * c3, s1 * s2 * s3 + c1 * c3, c2 * s3},
               w = {c1 * s2 * c3 + s1 * s3, s1 * s2 * c3 - c1 * s3, c2 * c3};
  b.point("O", O).vector("u", u).vector("v", v).vector("w", w);
  for (int i = 0; i < 6; ++i) {
    const std::string k = std::to_string(i);
    const double below = 2 * std::numbers::pi * i / 6 + draw.real(-0.4, 0.4);
    const double above = 2 * std::numbers::pi * i / 6 + draw.real(-0.4, 0.4);
    const Triple G = {std::cos(below), std::sin(below), draw.real(-0.1, 0.1)};
    const Triple p = {0.5 * std::cos(above), 0.5 * std::sin(above), draw.real(-0.07, 0.07)};
    double square = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      const double leg = O[j] + p[0] * u[j] + p[1] * v[j] + p[2] * w[j] - G[j];
      square += leg * leg;
    }
    const double length = std::sqrt(square), amplitude = draw.real(0, 0.25), phase = draw.real(0, 6.28);
    b.fixed_point("G" + k, G);
    platform.points.push_back({"P" + k, p});
    const double frequency = draw.real(0.1, 0.5);
    b.drive("leg" + k,
            DrivenDistance{"G" + k, "P" + k,
                           Law::harmonics({{amplitude, frequency, phase}}, length - amplitude * std::sin(phase))});
  }
  b.add(std::move(platform));
  return b.time(0, 2, 2.0 / steps).build();
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
