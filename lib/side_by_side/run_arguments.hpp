// What a run is asked for, checked.
#pragma once

#include <span>

#include "assur/simulator.hpp"

namespace assur {

// Throws Error (input) if the times descend anywhere or are not finite.
void check_times(std::span<const double> times);

// Throws Error (input) for numbers that make no sense.
void check_limits(const StepLimits& limits);

// True if all steps are > 0 and equally long, but for the rounding of the times; of fewer than two steps always.
[[nodiscard]] bool evenly_spaced(std::span<const double> times);

}  // namespace assur
