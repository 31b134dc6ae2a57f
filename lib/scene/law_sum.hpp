// The sum of many laws.
#pragma once

#include <span>

#include "assur/law.hpp"

namespace assur {

// Adds the two halves, recursively: each addition copies all parts, so that adding one law after another would take
// quadratic time.
[[nodiscard]] inline Law sum_of(std::span<const Law> laws) {
  if (laws.empty()) return {};
  if (laws.size() == 1) return laws.front();
  const std::size_t half = laws.size() / 2;
  return sum_of(laws.first(half)) + sum_of(laws.subspan(half));
}

}  // namespace assur
