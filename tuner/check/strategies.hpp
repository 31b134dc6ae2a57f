// Which strategies a case goes through.
#pragma once

#include <string>
#include <vector>

#include "check/case.hpp"

namespace assur::check {

struct Selection {
  std::vector<std::string> strategies;
  std::vector<std::string> left_out;  // "lapack, team in global: hopeless, some 900 s for 4,000 unknowns"
};

// Every backend that can run here, in double and in float, with the lanes that its classes fill, plain and with +once,
// +refine, +reuse=step and +reuse=run, in each formulation; every predictor with one backend of each formulation. Left
// out is what would take more than `seconds` by counts of operations, which know no machine. quick: each backend and
// precision once in each formulation, and the policies and predictors with one of them. Throws what analyze() does.
[[nodiscard]] Selection select_strategies(const Case& c, const Scene& scene, double seconds, bool quick);

}  // namespace assur::check
