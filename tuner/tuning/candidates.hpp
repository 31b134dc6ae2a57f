// What is worth a try: the strategies that are measured against each other.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "assur/backend.hpp"
#include "assur/strategy.hpp"

namespace assur::tuning {

// Whose solvers, on how many threads.
struct Field {
  std::span<const Backend> table;
  ThreadBudget budget;
  // Why a strategy is not to be tried, beyond what its backend says of itself; "": it is.
  std::function<std::string(const Strategy&)> why_not = [](const Strategy&) { return std::string(); };
};

// Linear solvers for matrices of one shape, which fill up to `most_lanes` lanes: backend, W, precision, q;
// the rest is default. Those that most is expected of and one of each backend come first: time may be short.
[[nodiscard]] std::vector<Strategy> linear_solvers(const Field& field, const Shape& shape, int most_lanes);

// Strategies for whole steps of a pack, for a class of so many groups on one level: the linear solvers in double on one
// thread, and if `policies` most of them with +once and +separate, too.
[[nodiscard]] std::vector<Strategy> pack_strategies(const Field& field, Formulation formulation, const Shape& shape,
                                                    bool policies);

}  // namespace assur::tuning
