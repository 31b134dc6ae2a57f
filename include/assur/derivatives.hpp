// Derivatives that functions of a program return, compared with differences. Needs the library assur::assur.
#pragma once

#include <span>
#include <vector>

#include "assur/law.hpp"
#include "assur/scene.hpp"
#include "assur/status.hpp"

namespace assur {

// Checks the derivatives of a callback at the arguments `at` (SI units), for tests of your own functions: `jacobian`
// against differences of `residual`, and `curvature` against differences of `jacobian` along one direction. Returns one
// finding for each derivative that is wrong by more than Callback::tolerance, and for a residual that is another one
// when it is called again; `where` is empty. A function that throws counts as undefined there. prepare() does the same
// at the start posture.
// units: the size of a typical change of each argument; empty: 1. Throws Error (input) if `at` or `units` has not one
// entry for each argument, or if the callback has no equation.
[[nodiscard]] std::vector<Diagnostic> check_derivatives(const Callback& callback, std::span<const double> at,
                                                        std::span<const double> units = {});

// Checks rate and acceleration of the functions in a law at a time between these two times, likewise. prepare() does
// the same in the first step and in seven others of the time grid.
[[nodiscard]] std::vector<Diagnostic> check_derivatives(const Law& law, double from, double to);

}  // namespace assur
