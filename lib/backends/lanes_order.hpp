// Pivot order of a sparse matrix by Markowitz cost (Management Science 3, 1957) among the entries that are large enough
// in their row, in several instances of the matrix at once.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "assur/backend.hpp"

namespace assur::lanes {

inline constexpr std::int64_t kMostProducts = 10'000'000;  // of one elimination; written down it takes 80 MB

// Which entries may be pivots. `threshold`: not smaller than this times the largest of its row, among what is left of
// the matrix; with `rook` not smaller than any other of its row and of its column. Of entries that cost the same the
// one that waits for the fewest others is taken if `shallow` (less fill on rings, more to do side by side), else the
// largest against its row (less growth).
struct PivotRule {
  double threshold = 0.1;
  bool shallow = false;
  bool rook = false;
};

struct Order {
  std::vector<std::int32_t> row, column;  // pivot k stands in row[k], column[k]; fewer than n: no pivot was left
  std::uint32_t served = 0;               // bit l: the rule holds for every pivot in lane l

  [[nodiscard]] bool complete(std::int32_t n) const { return row.size() == static_cast<std::size_t>(n); }
};

// values: nnz x lanes, interleaved; at most 32 lanes. wanted: bit l: lane l takes part; its values must be finite.
// Where the lanes have no such pivot in common, the largest in its worst lane is taken, and where that is next to
// nothing, the one that serves most lanes: the others are given up. Takes memory and, for sparse matrices, the time of
// a few hundred factorisations. Throws Error (environment) if there are more than kMostProducts.
[[nodiscard]] Order markowitz_order(const Pattern& pattern, std::span<const double> values, int lanes,
                                    std::uint32_t wanted, PivotRule rule);

}  // namespace assur::lanes
