// Pivot order of a sparse matrix by Markowitz cost (Management Science 3, 1957) among the entries that are large enough
// in their row, in several instances of the matrix at once.
#pragma once

#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "assur/backend.hpp"

namespace assur::lanes {

inline constexpr std::int64_t kMostProducts = 10'000'000;  // products of one elimination; their list takes 80 MB

// Conditions for pivots. `threshold`: a pivot is at least this times the largest entry of its row in the remaining
// matrix. `rook`: it is the largest entry of its row and of its column. Among entries of equal cost, `shallow` takes
// the entry that waits for the fewest others (less fill on rings, more independent work); else the largest one relative
// to its row is taken (less growth).
struct PivotRule {
  double threshold = 0.1;
  bool shallow = false;
  bool rook = false;
};

// Pivots of matrices with at most so many unknowns are chosen in memory that is reserved (PivotMemory).
inline constexpr std::int32_t kMostReserved = 24;

// A pivot order.
struct Order {
  std::pmr::vector<std::int32_t> row, column;  // pivot k is at row[k], column[k]; fewer than n if no pivot was left
  std::uint32_t served = 0;                    // bit l: the rule holds for every pivot in lane l

  [[nodiscard]] bool complete(std::int32_t n) const { return row.size() == static_cast<std::size_t>(n); }
};

// Chooses a pivot order. values: nnz x lanes, interleaved; at most 32 lanes. wanted: bit l is set if lane l takes part;
// its values must be finite. If the lanes have no common pivot that satisfies the rule, the entry that is largest in
// its worst lane is taken; if it is almost zero, the entry that serves most lanes, and the other lanes are given up.
// Takes memory from `memory`, and the time of a few hundred factorisations of a sparse matrix. Throws Error
// (environment) if there are more than kMostProducts.
[[nodiscard]] Order markowitz_order(const Pattern& pattern, std::span<const double> values, int lanes,
                                    std::uint32_t wanted, PivotRule rule,
                                    std::pmr::memory_resource* memory = std::pmr::get_default_resource());

}  // namespace assur::lanes
