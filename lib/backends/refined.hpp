// Decorators of solvers: iterative refinement with residuals in double, factors in float with a fallback to double, and
// a test of residuals.
#pragma once

#include <memory>

#include "assur/backend.hpp"

namespace assur {

// Makes the solver of a strategy: backend, +float (binary32), +refine. Call it only if backend.why_not() is "".
//
// +refine: improves every solution until its componentwise backward error max_i |b - A x|_i / (|A| |x| + |b|)_i is
//   2 eps (Oettli & Prager 1964), or until refinement no longer halves it (Skeel 1980: mostly after one step).
// +float: factorises in float and improves in double until the normwise backward error |b - A x| / (|A| |x| + |b|) of
//   the equilibrated system, maximum norms, is that of a solution in double. If a lane misses this, or if its
//   factorisation in float fails, the same backend factorises it in double (Effort::in_double).
// Both: factorises in float and improves the componentwise error.
//
// If a solution misses its bound, the status is {not_converged, lane, its error}, and the best solution that was found
// is returned. Refinement needs whole solutions, so that first_wanted saves nothing.
//
// Throws Error (environment) if binary32 is requested and the backend has no float.
[[nodiscard]] std::unique_ptr<LinearSolver> make_solver(const Backend& backend, ThreadBudget budget,
                                                        Precision precision, bool refine);

// Adds a test of residuals: if the normwise backward error of a solution (as above) exceeds 10 n eps, the status is
// {not_converged, lane, its error}. Without large growth, every backend stays below this bound.
[[nodiscard]] std::unique_ptr<LinearSolver> checked(std::unique_ptr<LinearSolver> solver);

}  // namespace assur
