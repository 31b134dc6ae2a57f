// What a simulator takes for granted of a plan that the library made, and of one that was read must be looked at.
#pragma once

#include "assur/plan.hpp"

namespace assur {

// Throws Error (input) that says where, for an index out of range, sizes that differ, groups that are not in solving
// order or outputs of coordinates that nothing computes. Numbers may be any: what they do to a motion is a Status.
void check_plan(const Prepared& prepared);

}  // namespace assur
