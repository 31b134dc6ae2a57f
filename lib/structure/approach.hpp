// Moves a posture from other values of the drivers to the values of their laws at the start, along the branch of the
// posture.
#pragma once

#include <vector>

#include "structure/blocks.hpp"

namespace assur {

// The values of all drivers, [input][law].
using DriverValues = std::vector<std::vector<double>>;

// Direction in which an angle turns.
enum class Way : std::uint8_t { shorter, longer };

// same: the branch must not change on the way; any: it may, and singular postures are passed to any posture beyond.
enum class Branch : std::uint8_t { same, any };

// Moves the drivers from `from` to `to` in steps of at most some tenths of a radian, and assembles the blocks, which
// must be square, at each step. q is a posture at `from` and becomes one at `to`. way: one for each input. False, with
// q unspecified, if a step finds no posture nearby, if an auxiliary unknown that must be > 0 is not, or if the
// determinant of a block changes its sign although the branch must not change.
[[nodiscard]] bool approach(const System& system, const Blocks& blocks, const DriverValues& from,
                            const DriverValues& to, const std::vector<Way>& way, Branch branch, std::vector<double>& q,
                            std::vector<Index>& column);

}  // namespace assur
