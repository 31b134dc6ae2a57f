// Shares packs of unequal cost among threads: the longest first, each to the thread with the least to do. At most
// 4/3 - 1/(3 threads) times as long as the best of all shares (Graham 1969, theorem 2).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace assur {

struct Shares {
  std::vector<std::int32_t> pack;   // packs of thread 0, then of thread 1, ..., each thread's in the order of its work
  std::vector<std::int32_t> start;  // threads + 1: where the packs of each thread start
  double makespan = 0;              // cost of the thread with the most to do

  [[nodiscard]] std::span<const std::int32_t> of(int thread) const {
    const auto t = static_cast<std::size_t>(thread);
    return std::span(pack).subspan(static_cast<std::size_t>(start[t]),
                                   static_cast<std::size_t>(start[t + 1] - start[t]));
  }
};

// cost: of each pack, in any unit, predicted or measured. The same costs always give the same shares: of equal packs
// the first goes first, of threads with as much to do that with fewer packs takes it, else the first. Throws Error
// (input) if threads < 1 or if a cost is negative or not finite.
[[nodiscard]] Shares longest_first(std::span<const double> cost, int threads);

}  // namespace assur
