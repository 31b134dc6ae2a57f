// A backend for tests only: MUMPS for symmetric matrices on the augmented matrix, as a substitute for MA27.
#pragma once

#include "assur/backend.hpp"

namespace assur::test {

// Null if this build has no MUMPS.
const Backend* symmetric_mumps();

}  // namespace assur::test
