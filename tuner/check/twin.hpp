// Twins: the same mechanism in another unit must give the same bits.
#pragma once

#include <string>

#include "assur/simulator.hpp"

namespace assur::check {

// The first row and column that differ by more than a power of two that is common to the column; "": none.
[[nodiscard]] std::string other_bits(const Trajectory& a, const Trajectory& b);

}  // namespace assur::check
