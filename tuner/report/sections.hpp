// The sections about this machine, a file each.
#pragma once

#include "report/conditions.hpp"
#include "report/knowledge.hpp"
#include "report/section.hpp"

namespace assur::report {

// Which strategy is expected to win for how many groups of how many unknowns, and where another one begins to.
[[nodiscard]] Section winners(const Knowledge& knowledge, const Conditions& conditions);

// How long single steps take: their histogram.
[[nodiscard]] Section step_histogram(const Knowledge& knowledge, const Conditions& conditions);

}  // namespace assur::report
