// An independent choice among the rows of a dense matrix.
#pragma once

#include <span>
#include <vector>

#include "decompositions.hpp"

namespace assur {

inline constexpr double kMostCoefficient = 1.5;  // a combination with a larger one exchanges rows

// Scales rows, then columns, to unit length. Rows that nearly vanish stay small: an equation whose gradient is only the
// error of a direction is not independent.
[[nodiscard]] Eigen::MatrixXd scaled_rows(Eigen::MatrixXd jacobian);

using RowQr = Eigen::ColPivHouseholderQR<Eigen::MatrixXd>;
// Its rank is that of the matrix, if its rows and columns have length 1.
[[nodiscard]] RowQr factored(const Eigen::MatrixXd& matrix);

// All rows of a scaled matrix of this rank: first independent ones, such that the others are combinations of them with
// coefficients of at most kMostCoefficient; then the others in ascending order. rows: the transposed matrix, factored.
// rather_last: the choice begins with these others, if there are as many as needed.
[[nodiscard]] std::vector<Eigen::Index> independent_first(const Eigen::MatrixXd& scaled, const RowQr& rows,
                                                          Eigen::Index rank,
                                                          std::span<const Eigen::Index> rather_last = {});

}  // namespace assur
