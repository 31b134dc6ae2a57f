// Shares packs of unequal cost among threads: each pack, the longest first, goes to the thread with the least work. The
// result takes at most 4/3 - 1/(3 threads) times as long as the best possible one (Graham 1969, theorem 2).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace assur {

// Packs of each thread.
struct Shares {
  std::vector<std::int32_t> pack;   // packs of thread 0, then of thread 1, ..., each in the order of work
  std::vector<std::int32_t> start;  // threads + 1: index of the first pack of each thread
  double makespan = 0;              // cost of the thread with the most work

  [[nodiscard]] std::span<const std::int32_t> of(int thread) const {
    const auto t = static_cast<std::size_t>(thread);
    return std::span(pack).subspan(static_cast<std::size_t>(start[t]),
                                   static_cast<std::size_t>(start[t + 1] - start[t]));
  }
};

// cost: of each pack, in any unit. The same costs always give the same shares: packs of equal cost keep their order;
// among threads with equal work, the thread with the fewest packs takes the next pack, else the first thread. Throws
// Error (input) if threads < 1, or if a cost is negative or not finite.
[[nodiscard]] Shares longest_first(std::span<const double> cost, int threads);

}  // namespace assur
