// Bare matrices that test linear solvers: bare, or as the equations of a callback group.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "check/case.hpp"
#include "check/result.hpp"

namespace assur::check {

using Dense = std::vector<std::vector<double>>;  // rows

// "wilkinson" (n), "graded" (n, factor), "hilbert" (n), "kahan" (n, angle), "repeated_row" (n), "zero_row" (n), "nan"
// (n), "tiny" (n), "huge" (n), "random" (n). Throws Error (input) for another name.
[[nodiscard]] Dense matrix(const std::string& name, const Parameters& set);

// Solves with every backend that can, plain (""), "+float", "+refine" and both, or those of them that are the case's
// strategies, for a known solution. The forward error is that of the solution; where it is more than asked,
// figures() must tell: "inaccurate", else "wrong".
[[nodiscard]] Result run_matrix(const Case& c, const std::function<bool()>& stop);

}  // namespace assur::check
