// Directions that drivers and measures need in the start posture.
#pragma once

#include <span>
#include <string>

#include "equations/system.hpp"

namespace assur {

// The first driver whose angle is undefined in the posture q, with the reason; "": all are defined. Angles need
// directions that have a length and are not parallel to the axis; else they drive nothing.
[[nodiscard]] std::string undefined_driver(const System& system, std::span<const double> q);

// The first signed angle in space whose axis is not a unit vector in the posture q; "": all axes are.
[[nodiscard]] std::string wrong_axis(const System& system, std::span<const double> q);

}  // namespace assur
