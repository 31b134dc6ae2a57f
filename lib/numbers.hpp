// Numbers that are needed everywhere.
#pragma once

#include <limits>
#include <numbers>

namespace assur {

inline constexpr double kEps = std::numeric_limits<double>::epsilon();
inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kTurn = 2 * std::numbers::pi;  // rad

}  // namespace assur
