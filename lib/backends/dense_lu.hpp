// Dense LU with partial pivoting on column-major blocks, in double or float. The elimination is recursive (Toledo, SIAM
// J. Matrix Anal. Appl. 18, 1997): except for a few columns, it consists of matrix products. Eigen computes them in
// tiles so small that its workspace stays on the stack; its own PartialPivLU allocates memory for larger systems.
#pragma once

#include <cstdint>

#include "assur/backend.hpp"
#include "backends/block.hpp"

namespace assur::eigen {

// P a = L U in place, rows >= columns; pivot[k] >= k is the row that was swapped with row k. False at a pivot that is
// zero or not finite.
template <class T>
bool eliminate(const Block<T>& a, std::int32_t* pivot);

// Solve triangular systems; x is overwritten. L has a unit diagonal; L and U are stored in one matrix.
template <class T>
void solve_lower(const Block<T>& l, const Block<T>& x);  // L x = x
template <class T>
void solve_upper(const Block<T>& u, const Block<T>& x, DenseIndex first);  // U x = x, rows before `first` left out
template <class T>
void solve_upper_transposed(const Block<T>& u, const Block<T>& x);  // U' x = x
template <class T>
void solve_lower_transposed(const Block<T>& l, const Block<T>& x);  // L' x = x

// a x = x, or a' x = x, by the factors P a = L U. pivot: as LAPACK counts, from 1. Without transposition, unknowns
// before first_wanted are left undone.
template <class T>
void solve_factored(const Block<T>& lu, const std::int32_t* pivot, const Block<T>& x, Transpose transpose,
                    DenseIndex first_wanted);

}  // namespace assur::eigen
