// Turns of the angles of drivers within a step.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "equations/system.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

inline constexpr double kStepOfDrivers = 1;  // rad

// Turn of the angles of drivers in one step, relative to the largest allowed one (kStepOfDrivers in all); more than 1:
// too far. bows: how far the angles may leave their chords, first of all laws. `together`: see angles_together(). With
// this limit, bodies that follow a driver may turn three times as fast without passing half a turn unnoticed. teeth:
// System::teeth, divides the largest turn.
[[nodiscard]] inline double turned(std::span<const double> from, std::span<const double> to,
                                   std::span<const double> bows, int together, int teeth) {
  double sum = 0, largest = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const double by = std::abs(to[i] - from[i]) + (bows.empty() ? 0 : bows[i]);
    sum += by;
    largest = std::max(largest, by);
  }
  return std::min(sum, together * largest) * teeth / kStepOfDrivers;
}

// The most driven angles that one coordinate depends on: the last link of an arm turns by the sum of its joints.
[[nodiscard]] int angles_together(const System& system, const GroupedSystem& structure);

}  // namespace assur
