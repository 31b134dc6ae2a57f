// Checks of time grids.
#pragma once

#include <vector>

#include "assur/scene.hpp"

namespace assur {

// What is wrong with a time grid, at places such as "/time/step"; empty: nothing. Three zeros are no grid, which is
// right.
[[nodiscard]] std::vector<Diagnostic> wrong_grid(const TimeGrid& time);

}  // namespace assur
