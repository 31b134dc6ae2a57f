// The picture of `assur run --plot`, a separate file.
#pragma once

#include <string>

#include "assur/plan.hpp"
#include "assur/simulator.hpp"

namespace assur::pictures {

// A diagram for each quantity, one below the other, as an SVG file. If there are more than kMostDiagrams quantities,
// it has the first ones and names the others. `why_ended`: reason if the motion ended early, else "".
[[nodiscard]] std::string outputs_over_time(const Prepared& prepared, const Trajectory& trajectory,
                                            const std::string& why_ended);

inline constexpr std::size_t kMostDiagrams = 12;

}  // namespace assur::pictures
