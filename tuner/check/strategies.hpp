// Selects the strategies for a case.
#pragma once

#include <string>
#include <vector>

#include "check/case.hpp"

namespace assur::check {

struct Selection {
  std::vector<std::string> strategies;
  std::vector<std::string> left_out;  // "lapack, team in global: too slow, up to about 15 min for each run"
};

// The strategies that the case lists. By default: every backend that runs here, in double and in float, in 1 and 8
// lanes, plain and with +once, +refine, +reuse=step and +reuse=run, in each formulation; and every predictor with one
// backend in each formulation. Strategies that would take more than `seconds`, by operation counts without
// measurements, are left out. quick: each backend and precision once in each formulation (of three without `groups`),
// policies and predictors with one of them. Throws like group_equations().
[[nodiscard]] Selection select_strategies(const Case& c, const Scene& scene, double seconds, bool quick);

}  // namespace assur::check
