// Moves a posture to other values of the drivers, along the branch of the posture.
#pragma once

#include <vector>

#include "structure/blocks.hpp"

namespace assur {

// The values of all drivers, [input][law].
using DriverValues = std::vector<std::vector<double>>;

// same: the branch must not change on the way; any: it may, and singular postures are passed to any posture beyond.
enum class Branch : std::uint8_t { same, any };

// Moves the drivers from `from` by `change` in steps of at most some tenths of a radian, shorter if there are gears,
// and assembles the blocks at each step. q is a posture at `from` and becomes one at `from` + `change`. False, with q
// unspecified, if a step finds no posture nearby, if an auxiliary unknown that must be > 0 is not, if the determinant
// of a block changes its sign although the branch must not change, or if that takes more than kMostApproachSteps.
[[nodiscard]] bool approach(const System& system, const Blocks& blocks, const DriverValues& from,
                            const DriverValues& change, Branch branch, std::vector<double>& q,
                            std::vector<Index>& column);

inline constexpr int kMostApproachSteps = 300000;

}  // namespace assur
