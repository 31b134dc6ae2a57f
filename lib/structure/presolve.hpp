// Presolve: each equation that is linear with constant coefficients eliminates one unknown.
#pragma once

#include <vector>

#include "equations/system.hpp"

namespace assur {

// Rewrites the forms of `system`, which items, measures and equations use, so that eliminated unknowns are affine in
// the others. Removes the eliminated ones from `equations` and `unknowns`. Returns their number.
Index presolve(System& system, std::vector<Index>& equations, std::vector<Index>& unknowns);

}  // namespace assur
