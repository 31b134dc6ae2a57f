// Twins: the same mechanism in another unit must give the same bits.
#pragma once

#include <string>

#include "assur/simulator.hpp"

namespace assur::check {

// The first row and column whose numbers differ, apart from a power of two that the whole column shares; "": none.
[[nodiscard]] std::string other_bits(const Trajectory& a, const Trajectory& b);

}  // namespace assur::check
