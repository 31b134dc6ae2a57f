// What linear solvers are timed on.
#pragma once

#include <cstdint>
#include <vector>

#include "assur/backend.hpp"
#include "assur/structure.hpp"

namespace assur::measure {

// Of one pattern; the values differ as those of a class's groups do.
struct Matrices {
  Pattern pattern;
  std::vector<std::vector<double>> values;  // matrices x nnz, at least one
};

// Jacobians of the first groups of a class, `most` at most, at the start posture.
[[nodiscard]] Matrices jacobians(const Structure& structure, std::int32_t group_class, int most);

// Random entries in `per_row` places of each column, or everywhere if there are fewer, and a permuted diagonal twice as
// large as the spectral radius of what is beside it is expected to be: well conditioned at every size.
[[nodiscard]] Matrices random_matrices(std::int32_t n, int per_row, int count);

}  // namespace assur::measure
