// Checks the derivatives that functions of the program (callbacks and laws) return, see assur/derivatives.hpp.
#pragma once

#include <string>
#include <vector>

#include "assur/derivatives.hpp"
#include "equations/system.hpp"

namespace assur {

// Checks every function of the scene: callbacks at a posture (all coordinates), laws in steps of the time grid, those
// of controlled drivers in the first one. `where` names the constraint or driver.
[[nodiscard]] std::vector<Diagnostic> find_wrong_functions(const System& s, const std::vector<double>& q,
                                                           const TimeGrid& time,
                                                           const std::vector<std::string>& controlled);

}  // namespace assur
