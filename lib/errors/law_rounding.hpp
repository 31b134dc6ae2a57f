// Rounding errors that the evaluation of laws makes.
#pragma once

#include "assur/law.hpp"

namespace assur {

// Bounds, to first order and in units of epsilon / 2, of the rounding errors of a law's value, rate and acceleration at
// time t as DriveProgram computes them: rounding of the sum of its parts, of the powers of t and their sum, of angles
// of harmonics (whole cycles are exact), and of the places and values of tables. The numbers of the law are exact, and
// so is a part that is a function of the program; its value counts in the sum if now is true, which calls the function.
[[nodiscard]] Jet<double> rounding(const Law& law, double t, bool now);

}  // namespace assur
