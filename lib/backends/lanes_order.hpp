// Pivot order of a sparse matrix by Markowitz cost (Management Science 3, 1957) among the entries that are large enough
// in their row, in several instances of the matrix at once.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "assur/backend.hpp"

namespace assur::lanes {

// Which entries may be pivots. `threshold`: not smaller than this times the largest of its row, among what is left of
// the matrix; with `rook` not smaller than any other of its row and of its column.
struct PivotRule {
  double threshold = 0.1;
  bool rook = false;
};

struct Order {
  std::vector<std::int32_t> row, column;  // pivot k stands in row[k], column[k]; fewer than n: no pivot was left
  std::uint32_t served = 0;               // bit l: the rule holds for every pivot in lane l

  [[nodiscard]] bool complete(std::int32_t n) const { return row.size() == static_cast<std::size_t>(n); }
};

// values: nnz x lanes, interleaved; at most 32 lanes. wanted: bit l: lane l takes part; its values must be finite.
// Where the lanes have no pivot in common, the entry that serves most of them is taken and the others are given up.
// Takes memory and, for sparse matrices, time of about that of a hundred factorisations.
[[nodiscard]] Order markowitz_order(const Pattern& pattern, std::span<const double> values, int lanes,
                                    std::uint32_t wanted, PivotRule rule);

}  // namespace assur::lanes
