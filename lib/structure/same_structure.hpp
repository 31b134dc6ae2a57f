// Comparison of structures.
#pragma once

#include "equations/system.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

// True if one plan and one tile can serve both: groups, equations and known coordinates are equal; constants may
// differ. Functions cannot be compared, so that structures with callbacks that are no gears must be copies of each
// other.
[[nodiscard]] bool same_structure(const GroupedSystem& a, const GroupedSystem& b);

}  // namespace assur
