// Comparison of structures.
#pragma once

#include "assur/structure.hpp"
#include "scene/system.hpp"

namespace assur {

// True if one plan and one tile can serve both: groups, equations and known coordinates are equal; constants may
// differ. Callbacks cannot be compared, so that structures with callbacks must be copies of each other.
[[nodiscard]] bool same_structure(const Structure& a, const Structure& b);

}  // namespace assur
