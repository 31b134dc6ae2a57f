// The same mechanism in another unit: the same bits.
#pragma once

#include <string>

#include "assur/simulator.hpp"

namespace assur::check {

// Which column of which row differs by more than a power of two that is the same for the whole column; "": none does.
[[nodiscard]] std::string other_bits(const Trajectory& a, const Trajectory& b);

}  // namespace assur::check
