// Parts of a mechanism that may move on their own: a wheel on an axle without a driver, a body that slides freely.
#pragma once

#include <span>
#include <vector>

#include "equations/system.hpp"
#include "graph/blocks.hpp"

namespace assur {

// Unknowns that have more freedoms than equations, and their equations. No output and no driver depends on them.
struct IdleParts {
  std::vector<Index> unknowns, equations;  // ascending
  std::vector<Diagnostic> notes;           // one for each body that spins, and for the rest of each part
};

// Finds the idle parts among the structurally underdetermined unknowns of `blocks`. The equations of all other unknowns
// mention none of these, so that idle parts can be left out. Parts that an output or the equation of a driver mentions,
// or that belong to a declared group, are not idle.
[[nodiscard]] IdleParts find_idle_parts(const System& system, const Blocks& blocks);

// Removes terms with the coefficient 0 of unknowns that are idle without these terms; false: there are none. For
// example, a member on the axis of a strut has such a term of a mark beside the axis, and seems to depend on the turn
// of the strut.
[[nodiscard]] bool separate_idle_parts(System& system, std::span<const Index> unknowns);

}  // namespace assur
