// Equations that are linear with constant coefficients eliminate one unknown each.
#pragma once

#include <vector>

#include "scene/system.hpp"

namespace assur {

// Rewrites the forms of `system` so that the eliminated unknowns are affine in the others (items, measures and
// equations see through them). `equations` and `unknowns` lose what is eliminated. Returns how many.
Index presolve(System& system, std::vector<Index>& equations, std::vector<Index>& unknowns);

}  // namespace assur
