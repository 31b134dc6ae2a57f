// The common part of the dense backends: full matrices for the lanes of a pack, right-hand sides, figures. Each backend
// adds its elimination.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "assur/backend.hpp"
#include "backends/block.hpp"

namespace assur {

// LU factors with partial pivoting of one square matrix, in place.
template <class T>
class DenseLu {
 public:
  virtual ~DenseLu() = default;

  // Called before the first matrix of order n: allocates the memory for all calls.
  virtual void prepare(DenseIndex n) { (void)n; }

  // P a = L U, L with a unit diagonal; pivot: the row that was swapped with each row, counted from 1 as in LAPACK.
  // False if a pivot is zero; the caller tests for pivots that are not finite.
  [[nodiscard]] virtual bool factorize(const Block<T>& a, std::int32_t* pivot) = 0;

  // a x = x, or a' x = x. Without transposition, unknowns before first_wanted may be left undone.
  virtual void solve(const Block<T>& lu, const std::int32_t* pivot, const Block<T>& x, Transpose transpose,
                     DenseIndex first_wanted) = 0;
};

// T: double or float. Values beyond the range of float are treated as not finite; right-hand sides are scaled, so that
// they may exceed it.
template <class T>
[[nodiscard]] std::unique_ptr<LinearSolver> make_dense_solver(std::unique_ptr<DenseLu<T>> lu);

// ---- parts that solvers share which keep their factors elsewhere

// The place of each nonzero in a dense matrix with this many elements in a column.
[[nodiscard]] std::vector<DenseIndex> dense_places(const Pattern& pattern, DenseIndex stride);

// a[place[k]] = values[k * lanes]. Returns max |a|, or NaN if a value is not finite in T.
template <class T>
double spread(const double* values, DenseIndex lanes, std::span<const DenseIndex> place, T* a);

// x = b[0], b[step], ..., of n numbers. In float, x is scaled by 2^-e, so that it may exceed float; returns e.
template <class T>
int take_right_side(const double* b, DenseIndex step, DenseIndex n, T* x);

// The reverse: b[i * step] = x[i] 2^e for i from `first` on.
template <class T>
void give_solution(const T* x, DenseIndex n, int exponent, DenseIndex first, double* b, DenseIndex step);

// Figures of a matrix by its factors, n >= 1; pivot: counted from 1. largest: max |a| of the matrix.
template <class T>
[[nodiscard]] Figures dense_figures(const Block<T>& lu, const std::int32_t* pivot, double largest);

// The reason if dense factors of this order are too large; else "".
[[nodiscard]] std::string why_not_dense(const Shape& shape);

}  // namespace assur
