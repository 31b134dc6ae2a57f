// Bricard's mechanism on the edges of a cube (IFToMM benchmark A04): six unit rods, each at right angles to the hinge
// axes at both its ends, which are at right angles to each other.
#pragma once

#include <string>

#include "assur/scene.hpp"

namespace assur {

// Rod 5 and its axes stand still; the hinge at P0 is driven by 0.5 sin t from the cube. 21 unknowns, 22 equations.
inline Scene bricard() {
  const Triple at[6] = {{0, 0, 0}, {1, 0, 0}, {1, -1, 0}, {1, -1, 1}, {0, -1, 1}, {0, 0, 1}};
  const Triple axis[6] = {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}};
  const auto named = [](const char* name, int i) { return name + std::to_string(i % 6); };
  SceneBuilder b("bricard", 3);
  for (int i = 0; i < 6; ++i) {
    const bool fixed = i == 5 || i == 0;
    b.add(Point{named("P", i), at[i], fixed}).add(Vector{named("u", i), axis[i], fixed, true});
  }
  for (int i = 0; i < 5; ++i) {
    const Direction rod(named("P", i), named("P", i + 1));
    b.constrain(named("rod", i), Distance{rod.first, rod.second, 1.0});
    if (i > 0) b.constrain(named("near", i), Dot{rod, named("u", i), 0.0});  // of rod 0 the driver sees to it
    b.constrain(named("far", i), Dot{rod, named("u", i + 1), 0.0});
    b.constrain(named("twist", i), Dot{named("u", i), named("u", i + 1), 0.0});
  }
  b.drive("hinge", PointAngle{"P0", "P1", "u0", Law::harmonics({{0.5, 1 / 6.283185307179586, 0}})});
  return b.time(0, 2, 0.02).build();
}

}  // namespace assur
