// The Pareto front of error and run time.
#pragma once

#include <span>
#include <vector>

namespace assur::measure {

struct Trade {
  double seconds = 0, error = 0;  // NaN: unknown
};

// For each result, true if it is on the front: no other result is at least as fast and as exact, and better in one of
// the two. Equal results are both on the front or both not; results with unknown or infinite figures are not.
[[nodiscard]] std::vector<bool> pareto_front(std::span<const Trade> all);

}  // namespace assur::measure
