// Eigen's decompositions of matrices of doubles, compiled once for all files (decompositions.cpp): each takes seconds.
#pragma once

#include <Eigen/Dense>
#include <Eigen/SparseLU>
#include <cstddef>

namespace assur {

// Unknowns of the largest matrix that is factored dense. Measured with five entries a row, factorisation and solution:
// dense 21 us and sparse 28 us at 64 unknowns, 57 and 54 at 96, 143 and 61 at 128.
inline constexpr Eigen::Index kLargestDenseLu = 96;
// Rows or columns of the largest matrix with dense decompositions that show its rank. Measured: 0.03 s each at 400,
// 0.14 s at 600, 0.37 s at 800; a study makes some tens.
inline constexpr std::size_t kLargestDenseRank = 600;

}  // namespace assur

extern template class Eigen::PartialPivLU<Eigen::MatrixXd>;
extern template class Eigen::FullPivLU<Eigen::MatrixXd>;
extern template class Eigen::HouseholderQR<Eigen::MatrixXd>;
extern template class Eigen::ColPivHouseholderQR<Eigen::MatrixXd>;
extern template class Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>;
extern template class Eigen::JacobiSVD<Eigen::MatrixXd>;
extern template class Eigen::SparseLU<Eigen::SparseMatrix<double>>;
