// A random mechanism of one of the random families, with a random step, and variants of it with other lengths.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>

#include "properties/near_singular.hpp"
#include "properties/random_chains.hpp"
#include "properties/small_random_scenes.hpp"

namespace assur::test {

// A rod between a crank and a rocker with skew axes (RSSR), and a slider connected to the rocker.
inline Scene skew_loop(Draw& draw, int steps) {
  SceneBuilder b("rssr", 3);
  const double crank = draw.real(0.2, 0.7), first = draw.real(-3, 3), rocker = draw.real(0.8, 1.6);
  const Triple B = {crank * std::cos(first), crank * std::sin(first), 0};
  const Triple D = {draw.real(0.6, 1.4), draw.real(-1, 1), draw.real(-0.3, 0.3)};
  const double lean = draw.real(-0.6, 0.6), tilt = draw.real(-0.4, 0.4);
  b.fixed_point("A", {0, 0, 0}).fixed_point("D", D).fixed_vector("z", {0, 0, 1}).fixed_vector("x", {1, 0, 0});
  b.fixed_vector("hinge", {std::cos(tilt), std::sin(tilt), 0});
  const Triple C = {D[0] - rocker * std::sin(lean) * std::sin(tilt), D[1] + rocker * std::sin(lean) * std::cos(tilt),
                    D[2] + rocker * std::cos(lean)};
  b.point("B", B).point("C", C);
  b.constrain("crank", Distance{"A", "B", std::nullopt})
      .constrain("plane", Dot{Direction("A", "B"), "z", std::nullopt});
  b.constrain("rod", Distance{"B", "C", std::nullopt}).constrain("rocker", Distance{"D", "C", std::nullopt});
  b.constrain("swing", Dot{Direction("D", "C"), "hinge", std::nullopt});
  const double turn = 2 * std::numbers::pi;
  b.drive("motor", RelativeAngle{"x", Direction("A", "B"), "z", Law::polynomial({first, draw.maybe() ? turn : -turn})});
  b.measure("angle", AngleBetween{"z", Direction("D", "C"), "hinge"});
  if (draw.maybe()) {
    const double reach = draw.real(1.8, 3);
    const Triple T = {C[0] + reach * 0.8, C[1] + 0.1, C[2] - reach * 0.6};
    b.point("T", T).fixed_point("Q", {0, T[1], T[2]});
    b.constrain("second_rod", Distance{"C", "T", std::nullopt}).constrain("slide", OnLine{"T", "Q", "x"});
    b.measure("along", MeasuredCoordinate{"slide.lambda"});
  }
  return b.time(0, 1, 1.0 / steps).build();
}

// A planar four-bar modelled in space, with redundant equations that keep its links in the plane.
inline Scene plane_in_space(Draw& draw, int steps) {
  SceneBuilder b("redundant", 3);
  const double crank = draw.real(0.3, 0.8), ground = draw.real(1.5, 2.2), first = draw.real(-3, 3);
  const Triple B = {crank * std::cos(first), crank * std::sin(first), 0};
  const Triple C = {draw.real(0.8, 1.8), draw.real(0.8, 1.6), 0};
  b.fixed_point("A", {0, 0, 0})
      .fixed_point("D", {ground, 0, 0})
      .fixed_vector("z", {0, 0, 1})
      .fixed_vector("x", {1, 0, 0});
  b.point("B", B).point("C", C);
  b.constrain("crank", Distance{"A", "B", std::nullopt}).constrain("flat0", Dot{Direction("A", "B"), "z", 0.0});
  b.constrain("coupler", Distance{"B", "C", std::nullopt}).constrain("flat1", Dot{Direction("B", "C"), "z", 0.0});
  b.constrain("rocker", Distance{"D", "C", std::nullopt}).constrain("flat2", Dot{Direction("D", "C"), "z", 0.0});
  b.drive("motor", RelativeAngle{"x", Direction("A", "B"), "z", Law::polynomial({first, 2 * std::numbers::pi})});
  b.measure("angle", AngleBetween{"x", Direction("D", "C"), "z"});
  return b.time(0, 1, 1.0 / steps).build();
}

inline Scene any_mechanism(Draw& draw) {
  const std::size_t kind = draw.below(10);
  const int steps = 10 + static_cast<int>(draw.below(80));
  const auto make = [&] {
    switch (kind) {
      case 0:
      case 1:
        return planar_mechanism(draw);
      case 2:
        return spatial_mechanism(draw);
      case 3:
        return near_singular(draw);
      case 4:
      case 5:
        return skew_loop(draw, steps);
      case 6:
        return plane_in_space(draw, steps);
      case 7:
        return sample("stewart", {{"omega", draw.real(0.3, 2)}});
      default:
        return closed_chain(draw);
    }
  };
  const Scene scene = make();
  const TimeGrid t = scene.time();
  const auto wanted = kind == 7 ? steps : draw.below(3) > 0 ? t.steps() : std::max<std::int64_t>(t.steps() / 4, 3);
  const double length = kind == 7 ? draw.real(1, 6) : t.end - t.start;
  return scene.with_time({t.start, t.start + length, length / static_cast<double>(wanted)});
}

}  // namespace assur::test
