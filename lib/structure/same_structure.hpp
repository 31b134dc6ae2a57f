// Comparison of structures.
#pragma once

#include "assur/structure.hpp"
#include "equations/system.hpp"

namespace assur {

// True if one plan and one tile can serve both: groups, equations and known coordinates are equal; constants may
// differ. Functions cannot be compared, so that structures with callbacks that are no gears must be copies of each
// other.
[[nodiscard]] bool same_structure(const Structure& a, const Structure& b);

}  // namespace assur
