// Decorators over any solver: iterative refinement with residuals in double, float with double behind it, and the bare
// residual check.
#pragma once

#include <memory>

#include "assur/backend.hpp"

namespace assur {

// The solver of a strategy: backend, +float (binary32), +refine. Call only if backend.why_not() is "".
//
// +refine: every solution is improved until its componentwise backward error max_i |b - A x|_i / (|A| |x| + |b|)_i
//   (Oettli & Prager 1964) is 2 eps, or refinement has ceased to halve it (Skeel 1980: mostly after one step).
// +float: factorised in float and improved in double until the normwise backward error |b - A x| / (|A| |x| + |b|) of
//   the equilibrated system, maximum norms, is that of a solution in double. A lane that does not get there, or whose
//   factorisation in float fails, is factorised in double by the same backend (Effort::in_double) until it changes.
// Both: in float, improved componentwise.
//
// A solution that refinement cannot bring within its bound is a Status {not_converged, lane, its error}; the best
// that was found is left in place. Refinement needs whole solutions: first_wanted saves nothing.
//
// Throws Error (environment) if the backend has no float and binary32 is asked for.
[[nodiscard]] std::unique_ptr<LinearSolver> make_solver(const Backend& backend, ThreadBudget budget,
                                                        Precision precision, bool refine);

// Residual check without refinement: a solution whose normwise backward error (as above) exceeds 10 n eps, which every
// backend keeps on matrices without large growth, is a Status {not_converged, lane, its error}.
[[nodiscard]] std::unique_ptr<LinearSolver> checked(std::unique_ptr<LinearSolver> solver);

}  // namespace assur
