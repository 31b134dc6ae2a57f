// Rank of a large sparse Jacobian. Redundancy is local: the rank follows from a sparse QR, and each redundant row as a
// combination of independent ones from the blocks that it depends on.
#pragma once

#include <Eigen/SparseCore>
#include <span>
#include <vector>

#include "equations/system.hpp"

namespace assur {

inline constexpr double kLeastOfNullVector = 1e-8;  // smaller entries, relative to the largest, are zero

using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

// The result of sparse_rank(). Rows and columns: of the matrices.
struct SparseRank {
  std::vector<Eigen::Index> kept;                       // independent rows
  std::vector<Eigen::Index> dropped;                    // the others
  std::vector<std::vector<Eigen::Index>> combinations;  // for each dropped row: the kept rows that combine to it
  std::vector<Eigen::Index> undetermined;               // columns that take part in the null space
};

// The rank of a matrix; the columns of its transpose are examined.
[[nodiscard]] Eigen::Index rank_of(const SparseRows& rows);

// `postures`: Jacobians with rows and columns of length 1; the one with the number `best` has the largest rank.
[[nodiscard]] SparseRank sparse_rank(const System& system, std::span<const Index> equations,
                                     std::span<const Index> unknowns, const std::vector<SparseRows>& postures,
                                     std::size_t best);

}  // namespace assur
