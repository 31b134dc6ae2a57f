// `assur run --plot`: a picture that stands alone.
#pragma once

#include <string>

#include "assur/plan.hpp"
#include "assur/simulator.hpp"

namespace assur::pictures {

// A diagram for each quantity, one below the other, as an SVG file of its own; with more than kMostDiagrams the first
// ones, and what is left out in words. `why_ended`: of a motion that ended early, else empty.
[[nodiscard]] std::string outputs_over_time(const Prepared& prepared, const Trajectory& trajectory,
                                            const std::string& why_ended);

inline constexpr std::size_t kMostDiagrams = 12;

}  // namespace assur::pictures
