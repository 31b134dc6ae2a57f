// Random closed chains whose driver makes one full turn: many reach a limit, and many come close to another branch.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "properties/small_random_scenes.hpp"

namespace assur::test {

// A crank about the origin that makes one turn in time 1, from a random angle.
inline Triple turning_crank(SceneBuilder& b, Draw& draw) {
  const double radius = draw.real(0.3, 1.2), first = draw.real(-3, 3), turn = 2 * std::numbers::pi;
  const Triple at = {radius * std::cos(first), radius * std::sin(first), 0};
  b.fixed_point("A", {0, 0, 0}).point("B", at).constrain("crank", Distance{"A", "B", radius});
  b.drive("motor", PointAngle{"A", "B", "", Law::polynomial({first, draw.maybe() ? turn : -turn})});
  return at;
}

inline Triple somewhere(Draw& draw, double size) { return {draw.real(-size, size), draw.real(-size, size), 0}; }

// A dyad B-C-D with two bars, or with a bar and a rail.
inline Scene chain_with_dyad(Draw& draw, int steps) {
  SceneBuilder b("dyad", 2);
  turning_crank(b, draw);
  b.point("C", somewhere(draw, 2)).fixed_point("D", somewhere(draw, 2));
  b.constrain("coupler", Distance{"B", "C", std::nullopt});
  if (draw.below(3) == 0) {
    const double direction = draw.real(-3, 3);
    b.fixed_vector("rail", {std::cos(direction), std::sin(direction), 0});
    // The rail goes through the start position of C.
    b.constrain("guide", Dot{Direction("D", "C"), "rail", std::nullopt});
  } else {
    b.constrain("rocker", Distance{"C", "D", std::nullopt});
  }
  return b.time(0, 1, 1.0 / steps).build();
}

// A triangle on three bars, one to the crank and two to fixed points.
inline Scene chain_with_triad(Draw& draw, int steps) {
  SceneBuilder b("triad", 2);
  turning_crank(b, draw);
  for (int i = 0; i < 3; ++i) {
    const std::string k = std::to_string(i);
    b.point("P" + k, somewhere(draw, 1.5));
    if (i > 0) b.fixed_point("D" + k, somewhere(draw, 2.5));
    b.constrain("bar" + k, Distance{i > 0 ? "D" + k : "B", "P" + k, std::nullopt});
  }
  add_sides(b);
  return b.time(0, 1, 1.0 / steps).build();
}

// A triangle on three legs with oscillating lengths (3-RPR).
inline Scene three_legs(Draw& draw, int steps) {
  SceneBuilder b("three_legs", 2);
  for (int i = 0; i < 3; ++i) {
    const std::string k = std::to_string(i);
    const Triple A = somewhere(draw, 2), P = somewhere(draw, 1);
    const double length = std::hypot(P[0] - A[0], P[1] - A[1]), phase = draw.real(0, 2 * std::numbers::pi);
    const double amplitude = 0.5 * length * draw.real(0, 1);
    b.fixed_point("A" + k, A).point("P" + k, P);
    b.drive("leg" + k, DrivenDistance{"A" + k, "P" + k,
                                      Law::harmonics({{amplitude, 1, phase}}, length - amplitude * std::sin(phase))});
  }
  add_sides(b);
  return b.time(0, 1, 1.0 / steps).build();
}

inline Scene closed_chain(Draw& draw) {
  const int steps = 30 + static_cast<int>(draw.below(90));
  switch (draw.below(3)) {
    case 0:
      return chain_with_dyad(draw, steps);
    case 1:
      return chain_with_triad(draw, steps);
    default:
      return three_legs(draw, steps);
  }
}

}  // namespace assur::test
