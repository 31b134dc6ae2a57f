// Candidates: the strategies that are measured in a cell.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "assur/backend.hpp"
#include "assur/strategy.hpp"

namespace assur::tuning {

// Solvers and threads of a tuning run.
struct Field {
  std::span<const Backend> table;
  ThreadBudget budget;
  // Further reason why a strategy must not be tried, beyond Backend::why_not; "": it may be tried.
  std::function<std::string(const Strategy&)> why_not = [](const Strategy&) { return std::string(); };
};

// Linear solvers for matrices of one shape, with up to `most_lanes` lanes: backend, W, precision and Q; other settings
// are defaults. The most promising ones and one of each backend come first, because time may run out.
[[nodiscard]] std::vector<Strategy> linear_solvers(const Field& field, const Shape& shape, int most_lanes);

// Strategies for whole steps of a pack, for a class with shape.groups groups on one level: linear solvers in double on
// one thread; with `policies` most of them also with +once.
[[nodiscard]] std::vector<Strategy> pack_strategies(const Field& field, Formulation formulation, const Shape& shape,
                                                    bool policies);

// The strategies with +together, for every W that does not leave half of the lanes of all `groups` idle.
[[nodiscard]] std::vector<Strategy> together_strategies(const Field& field, Formulation formulation,
                                                        std::int32_t groups);

}  // namespace assur::tuning
