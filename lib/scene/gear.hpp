// The equation of a gear or rack between two coordinates of joints.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "assur/scene.hpp"

namespace assur {

// A coordinate of a joint. An angle turns direction `from` into `to` about `axis`, which is empty in the plane; a
// displacement is a scalar.
struct GearSide {
  bool is_angle = true;
  std::string from, to, axis;  // names of unit vectors
  std::string displacement;    // "NAME.lambda"
};

// Whole numbers n, m <= 1000 with |n / m - ratio| <= 1e-9; empty: there are none.
[[nodiscard]] std::optional<std::pair<int, int>> whole_ratio(double ratio);

// Both coordinates are 0 in the posture as written.
//   two angles:              sin(m b - n a) = 0 with the ratio n / m
//   an angle and a distance: sin(angle - distance / radius) = 0
//   two distances:           b - ratio a = 0
// A posture gives angles up to whole turns, and all these equations hold after whole turns of both wheels. They also hold
// at other teeth: Callback::teeth makes steps short enough, and the residual is NaN if the wheels are farther than about
// 1 rad of their phase, m b - n a, out of mesh.
[[nodiscard]] Callback gear_equation(const GearSide& a, const GearSide& b, double ratio);

}  // namespace assur
