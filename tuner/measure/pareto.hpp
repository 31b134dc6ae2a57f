// Which of several results nobody beats: error against run time.
#pragma once

#include <span>
#include <vector>

namespace assur::measure {

struct Trade {
  double seconds = 0, error = 0;  // NaN: not known
};

// For each: true if no other one is as fast and as exact, and better in one of the two. Equal ones stand or fall
// together; what is not known or not finite is never on the front.
[[nodiscard]] std::vector<bool> pareto_front(std::span<const Trade> all);

}  // namespace assur::measure
