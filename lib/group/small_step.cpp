#include "group/small_step.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "index.hpp"
#include "program/group_step.hpp"

namespace assur {

// Rows k and i > k are swapped before column k where swaps[...] is positive. Each pivot is then the largest entry of
// its column, relative to its row.
void choose_pivots(const Workspace& work, Pack& pack, std::span<const std::uint8_t> lanes) {
  const std::size_t w = idx(work.lanes), n = idx(work.program.n);
  for (LaneArray* swaps : {&pack.swaps, &pack.kept.swaps}) swaps->resize(pivots_of_group_step(work.group_class) * w);
  const Pattern& pattern = work.program.pattern;
  for (std::size_t lane = 0; lane < w; ++lane) {
    if (!lanes.empty() && lanes[lane] == 0) continue;
    std::array<std::array<double, 3>, 3> row{};
    for (std::size_t column = 0; column < n; ++column) {
      for (std::int32_t k = pattern.column_start[column]; k < pattern.column_start[column + 1]; ++k) {
        row[idx(pattern.row[idx(k)])][column] = work.jacobian[idx(k) * w + lane];
      }
    }
    std::array<double, 3> size{};  // squares
    for (std::size_t i = 0; i < n; ++i) {
      for (const double x : row[i]) size[i] += x * x;
    }
    double* swaps = pack.swaps.data() + lane;
    for (std::size_t k = 0; k < n; ++k) {
      for (std::size_t i = k + 1; i < n; ++i, swaps += w) {
        *swaps = row[i][k] * row[i][k] * size[k] - row[k][k] * row[k][k] * size[i];
        if (!(*swaps > 0)) continue;
        std::swap(row[i], row[k]);
        std::swap(size[i], size[k]);
      }
      for (std::size_t i = k + 1; i < n; ++i) {
        const double factor = row[i][k] / row[k][k];
        for (std::size_t j = k + 1; j < n; ++j) row[i][j] -= factor * row[k][j];
      }
    }
  }
}

}  // namespace assur
