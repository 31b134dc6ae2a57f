// Assembles a posture with fixed drivers, and studies its equations.
#pragma once

#include "start/other_postures.hpp"
#include "start/start.hpp"

namespace assur {

// Finds the equations to solve at the posture of the problem and their blocks, without parts that no output needs.
void divide(const System& system, Problem& problem, StartFindings& out);

// The same; then assembles the blocks, and chooses independent equations of the parts that are not regular. Sets the
// redundant and undetermined ones in `out`, and a reason if the posture cannot be assembled. Returns those parts.
[[nodiscard]] DoubtfulParts study_posture(const System& system, Problem& problem, StartFindings& out);

}  // namespace assur
