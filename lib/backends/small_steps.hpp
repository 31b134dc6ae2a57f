// Steps in registers, which the backend `lanes` without options uses for groups of two or three unknowns.
#pragma once

#include "assur/strategy.hpp"
#include "backends/backends.hpp"

namespace assur {

// True if a strategy allows such steps: each factorisation is fresh and in double.
[[nodiscard]] inline bool has_small_steps(const SolverSettings& s) {
  return s.backend == kLanes.id && !s.single && !s.refine && !s.once && !s.separate && s.reuse == Reuse::fresh;
}

}  // namespace assur
