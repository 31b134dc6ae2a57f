// Matrices that test linear solvers, alone or as the equations of a callback.
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

// Solves for a known solution with every backend that can: plain, "+float", "+refine" and both, or with the strategies
// of the case. If the forward error of the solution exceeds the required accuracy, the verdict is "inaccurate" if
// figures() show it, else "wrong".
[[nodiscard]] Result run_matrix(const Case& c, const std::function<bool()>& stop);

}  // namespace assur::check
