// A point P slides along a unit vector u whose coordinates are unknowns:
//   r - l u = 0,  |u|^2 = 1,  with r = P - E for a point E of the line, and l = lambda + constant.
#pragma once

#include <vector>

#include "equations/system.hpp"
#include "graph/blocks.hpp"

namespace assur {

// Replaces equations of slides by others with the same solutions, so that smaller groups are solved:
//   - in the plane, if lambda is unknown, by the components across and along u: u x r = 0 and l = u . r. Then the other
//     equations need no lambda.
//   - |u|^2 = 1 by |r|^2 = l^2 if u then follows from r and l alone, as the direction of a strut follows from its ends.
//     Then the group of the ends has no unknowns u. If l is 0, both sets of equations leave u undetermined.
// Updates `blocks`.
void decouple_slides(System& system, const std::vector<Index>& equations, const std::vector<Index>& unknowns,
                     Blocks& blocks);

}  // namespace assur
