// Checks of the arguments of a run.
#pragma once

#include <span>

#include "assur/simulator.hpp"
#include "program/needs.hpp"

namespace assur {

// Throws Error (input) if the times descend anywhere or are not finite.
void check_times(std::span<const double> times);

// Throws Error (input) if a limit is negative, or if most_iterations is 0.
void check_settings(const StepSettings& settings);

[[nodiscard]] Needs needs_of(const StepSettings& settings);

// True if all steps are > 0 and equally long, except for the rounding of times. Always true for fewer than two steps.
[[nodiscard]] bool evenly_spaced(std::span<const double> times);

}  // namespace assur
