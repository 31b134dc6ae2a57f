// The parts of the time that the backend `cusolver` takes.
#pragma once

#include <span>

#include "assur/backend.hpp"

namespace assur::cusolver {

// Seconds of one call: copies to and from the device and computation by the clock of the device; whole: by the clock of
// this computer. What remains is for launches, for waiting, and for the work of the processor.
struct CallTimes {
  double upload = 0, compute = 0, download = 0, whole = 0;
};

struct Breakdown {
  CallTimes factorize, solve;  // solve: one right-hand side
  double backward_error = 0;   // of the solution, maximum norms
};

// Medians over `calls` factorisations and solutions of one matrix in double, after a first one. why_not() must be "".
// Throws Error (numerical) if the matrix cannot be factorised.
[[nodiscard]] Breakdown break_down(const Pattern& pattern, std::span<const double> values, int calls);

}  // namespace assur::cusolver
