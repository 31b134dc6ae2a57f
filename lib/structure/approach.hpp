// From a posture with other values of the drivers to the values that their laws have at the start, along the branch of
// that posture.
#pragma once

#include <vector>

#include "structure/blocks.hpp"

namespace assur {

// The values of all drivers, [input][law].
using DriverValues = std::vector<std::vector<double>>;

// How far an angle goes round.
enum class Way : std::uint8_t { shorter, longer };

// May the branch change on the way? If so, singular postures are passed to any posture beyond them.
enum class Branch : std::uint8_t { same, any };

// Moves the drivers from `from` to `to` in steps of at most some tenths of a radian, and assembles the blocks, which
// are square, at each: q is a posture at `from` first, one at `to` then. way: one for each input. False, and q is of no
// use, if a step finds no posture nearby, if an auxiliary that must stay > 0 does not, or if the determinant of a block
// changes its sign and the branch may not change.
[[nodiscard]] bool approach(const System& system, const Blocks& blocks, const DriverValues& from,
                            const DriverValues& to, const std::vector<Way>& way, Branch branch, std::vector<double>& q,
                            std::vector<Index>& column);

}  // namespace assur
