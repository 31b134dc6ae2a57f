// Small groups, of two or three unknowns, take their whole step in registers: what `lanes` means without more.
#pragma once

#include "assur/strategy.hpp"
#include "backends/backends.hpp"

namespace assur {

// Registers factorise afresh and in double.
[[nodiscard]] inline bool has_small_steps(const SolverSettings& s) {
  return s.backend == kLanes.id && !s.single && !s.refine && !s.once && !s.separate && s.reuse == Reuse::fresh;
}

}  // namespace assur
