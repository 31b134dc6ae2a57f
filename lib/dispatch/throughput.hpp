// Lanes and chunks of Mode::throughput.
#pragma once

#include <cstdint>

#include "assur/strategy.hpp"

namespace assur {

inline constexpr std::int32_t kThroughputLanes = 8;  // W of `auto`: a register of AVX-512; scaling_bench --only lanes
inline constexpr std::int64_t kLeastSteps =
    50;  // of a chunk, which pay for finding its start; scaling_bench --only chunks

// Number of chunks for a time grid of `steps` steps. They fill lanes and threads evenly, or fill them twice if the grid
// is long enough, and have kLeastSteps or more each. 1 if the grid is too short for two chunks.
[[nodiscard]] std::int32_t chunks_for(std::int32_t lanes, std::int32_t threads, std::int64_t steps);

}  // namespace assur
