// Matrices for timing linear solvers.
#pragma once

#include <cstdint>
#include <vector>

#include "assur/backend.hpp"
#include "structure/grouped_system.hpp"

namespace assur::measure {

// Matrices of one pattern with different values, like those of the groups of a class.
struct Matrices {
  Pattern pattern;
  std::vector<std::vector<double>> values;  // matrices x nnz, at least one
};

// Jacobians of the first groups of a class, `most` at most, at the start posture.
[[nodiscard]] Matrices jacobians(const GroupedSystem& structure, std::int32_t group_class, int most);

// Matrices with random entries in `per_row` places of each column (full if n is smaller), and a permuted diagonal of
// twice the expected spectral radius of the other entries, so that they are well conditioned at every size.
[[nodiscard]] Matrices random_matrices(std::int32_t n, int per_row, int count);

}  // namespace assur::measure
