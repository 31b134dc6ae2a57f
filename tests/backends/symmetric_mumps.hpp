// A row that only tests know: MUMPS for symmetric matrices on the augmented matrix, which stands in for MA27.
#pragma once

#include "assur/backend.hpp"

namespace assur::test {

// Null if this build has no MUMPS.
const Backend* symmetric_mumps();

}  // namespace assur::test
