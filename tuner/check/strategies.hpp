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

// What the case lists; else every backend that runs here, in double and in float, alone and in 8 lanes, plain and
// with +once, +refine, +reuse=step and +reuse=run, in each formulation; every predictor with one backend of each. Left
// out is what would take more than `seconds` by counts of operations, which know no machine. quick: each backend and
// precision once in each formulation (of three not in `groups`), policies and predictors with one. Throws as analyze().
[[nodiscard]] Selection select_strategies(const Case& c, const Scene& scene, double seconds, bool quick);

}  // namespace assur::check
