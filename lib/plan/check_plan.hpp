// Check of a plan that was read from a file: the conditions that plans of prepare() satisfy by construction.
#pragma once

#include "plan/preparation.hpp"

namespace assur {

// Throws Error (input) that names the place, for an index out of range, sizes that differ, groups that are not in
// solving order, or outputs of coordinates that are not computed. Other numbers may have any value: a run then ends
// with a status.
void check_plan(const Preparation& prepared);

}  // namespace assur
