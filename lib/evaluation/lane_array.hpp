// Arrays [slot][lane].
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "parallel/cache_line.hpp"

namespace assur {

using LaneArray = std::vector<double, LineAllocator<double>>;

// The first index from `at` on at which a vector of W lanes, or of a full cache line, crosses no cache line.
[[nodiscard]] constexpr std::size_t lane_place(std::size_t at, std::size_t lanes) {
  const std::size_t apart = std::min(lanes, kLineBytes / sizeof(double));
  return (at + apart - 1) / apart * apart;
}

}  // namespace assur
