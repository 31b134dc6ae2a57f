// Dense LU with partial pivoting on column-major blocks. The elimination is recursive (Toledo, SIAM J. Matrix Anal.
// Appl. 18, 1997): everything but a few columns is a matrix product, which Eigen does in tiles so small that its
// workspace stays on the stack. Eigen's own PartialPivLU takes memory from the heap in larger systems.
#pragma once

#include <Eigen/Core>

namespace assur::eigen {

using Index = Eigen::Index;

// A column-major block within a larger matrix.
struct Block {
  double* data;
  Index rows, columns, stride;

  double& operator()(Index i, Index j) const { return data[i + j * stride]; }
  double* column(Index j) const { return data + j * stride; }
  Block block(Index i, Index j, Index r, Index c) const { return {data + i + j * stride, r, c, stride}; }
};

// P a = L U in place, rows >= columns; pivot[k] >= k is the row that was swapped with row k. False at a pivot that is
// zero or not finite.
bool eliminate(const Block& a, Index* pivot);

// Triangular systems, in place of x; L has a unit diagonal, both stand in one matrix.
void solve_lower(const Block& l, const Block& x);               // L x = x
void solve_upper(const Block& u, const Block& x, Index first);  // U x = x, rows before `first` left out
void solve_upper_transposed(const Block& u, const Block& x);    // U' x = x
void solve_lower_transposed(const Block& l, const Block& x);    // L' x = x

}  // namespace assur::eigen
