// A four-bar whose crank cannot make a full turn.
#pragma once

#include <cmath>

#include "assur/scene.hpp"

namespace assur::test {

// Crank 1, coupler 1, rocker 1.2, ground 2; the crank starts at 0.5 rad. At cos(angle) = 0.04, where |B A1| = 2.2,
// coupler and rocker are in line and the crank cannot go further.
inline SceneBuilder limited_four_bar(Law law) {
  SceneBuilder builder("limited", 2);
  builder.fixed_point("A0", {0, 0, 0}).fixed_point("A1", {2, 0, 0});
  builder.point("B", {std::cos(0.5), std::sin(0.5), 0}).point("C", {1.7, 1.1, 0});
  builder.constrain("crank", Distance{"A0", "B", 1.0});
  builder.constrain("coupler", Distance{"B", "C", 1.0});
  builder.constrain("rocker", Distance{"A1", "C", 1.2});
  builder.drive("motor", PointAngle{"A0", "B", "", std::move(law)});
  return builder;
}

}  // namespace assur::test
