// Conversion of times to another pace of the machine.
#pragma once

#include "assur/performance.hpp"

namespace assur {

// True if a time rises and falls with the pace of one core. Several threads take as long as the slowest core needs, and
// a GPU has a pace of its own: if their times are divided by the slowness of one core, they scatter more than before
// (16 cores and an H200: 1.8 instead of 1.1 between the largest and the smallest time of the same cell).
[[nodiscard]] bool follows_pace(const Strategy& strategy);

// A sample while the machine is `times` as slow.
[[nodiscard]] Sample slowed(Sample sample, double times);

}  // namespace assur
