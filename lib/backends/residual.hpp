// Residuals and backward errors of interleaved systems, in double.
#pragma once

#include <span>

#include "assur/backend.hpp"

namespace assur {

// One right-hand side of a pack: values are nnz x lanes, x is n x lanes.
struct PackSystem {
  const Pattern& pattern;
  std::span<const double> values;
  int lanes;
  Transpose transpose;
};

// residual holds b and becomes b - A x, n x lanes; A' if transposed.
void subtract_product(const PackSystem& system, std::span<const double> x, std::span<double> residual);

// The same; weight, n x lanes, becomes |A| |x| + |b|.
void subtract_product(const PackSystem& system, std::span<const double> x, std::span<double> residual,
                      std::span<double> weight);

// norm[lane] = max |x_i|; NaN if one of them is not finite.
void norms(std::span<const double> x, std::span<double> norm);

// norm[lane] = max |x_i scale_i|.
void norms(std::span<const double> x, std::span<const double> scale, std::span<double> norm);

// Computes scales R and C such that the largest entries of every row and column of R A C are about 1. Scales of empty
// rows and columns are 1. row, column: n x lanes each.
void equilibrate(const PackSystem& system, std::span<double> row, std::span<double> column);

// norm[lane] = max_i sum_j |r_i a_ij c_j|, the maximum norm of R A C; NaN if a value is not finite. sum: n x lanes.
void matrix_norms(const PackSystem& system, std::span<const double> row, std::span<const double> column,
                  std::span<double> norm, std::span<double> sum);

// error[lane] = max_i |r_i| / weight_i, 0/0 = 0 (Oettli & Prager 1964); NaN if a residual is not finite.
void componentwise_errors(std::span<const double> residual, std::span<const double> weight, std::span<double> error);

// Raises weights of rows whose unknowns should be zero but have rounding errors: there r_i stays as large as weight_i,
// although both are small. Such a weight grows by max_j |a_ij| max |x| (Arioli, Demmel & Duff 1989, section 2), with
// the columns of A scaled to 1. column, row: workspace, n x lanes each.
void raise_vanishing_weights(const PackSystem& system, std::span<const double> x, std::span<double> weight,
                             std::span<double> column, std::span<double> row);

}  // namespace assur
