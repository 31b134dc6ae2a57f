// What the dense backends share: the lanes of a pack spread into full matrices, right-hand sides, figures. Each brings
// its own elimination.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "assur/backend.hpp"
#include "backends/block.hpp"

namespace assur {

// LU factors with partial pivoting of one square matrix, in place.
template <class T>
class DenseLu {
 public:
  virtual ~DenseLu() = default;

  // Before the first matrix of order n: takes the memory that the others need.
  virtual void prepare(DenseIndex n) { (void)n; }

  // P a = L U, L with a unit diagonal; pivot: the row that was swapped with each row, both counted from 1 as LAPACK
  // does. False at a pivot that is zero; one that is not finite may be left to the caller.
  [[nodiscard]] virtual bool factorize(const Block<T>& a, std::int32_t* pivot) = 0;

  // a x = x, or a' x = x. Without transposition, unknowns before first_wanted may be left undone.
  virtual void solve(const Block<T>& lu, const std::int32_t* pivot, const Block<T>& x, Transpose transpose,
                     DenseIndex first_wanted) = 0;
};

// T: double or float. In float, values beyond its range are not finite; right-hand sides are scaled, so that their
// range does not matter.
template <class T>
[[nodiscard]] std::unique_ptr<LinearSolver> make_dense_solver(std::unique_ptr<DenseLu<T>> lu);

// "" unless dense factors of this order are too large.
[[nodiscard]] std::string why_not_dense(const Shape& shape);

}  // namespace assur
