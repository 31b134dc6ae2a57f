// Posture and rates of a pack that stands on a change point.
#pragma once

#include <array>

#include "evaluation/lane_array.hpp"

namespace assur {

// The limits of a motion on both sides of the change point.
struct ChangePointPosture {
  LaneArray values;                // derivatives 0 to 3 x unknowns x W; empty: the pack is not at a change point
  std::array<double, 3> errors{};  // of posture, rates and accelerations, estimated

  [[nodiscard]] bool exists() const { return !values.empty(); }
};

}  // namespace assur
