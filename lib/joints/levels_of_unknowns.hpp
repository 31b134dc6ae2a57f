// The order in which unknowns can be solved, from the pattern of their equations alone.
#pragma once

#include <vector>

#include "index.hpp"

namespace assur {

// Levels of unknowns by longest path: unknowns of one level depend, apart from each other, only on lower levels.
// equations: the unknowns of each equation. Where there are more equations than unknowns, some maximum matching decides
// which equations count; an unknown without an equation has level 0.
[[nodiscard]] std::vector<Index> levels_of_unknowns(Index unknowns, std::vector<std::vector<Index>> equations);

}  // namespace assur
