// Square systems by a solver for symmetric matrices. J x = b is the second half of K [u; x] = [b; 0] with the symmetric
//     K = [0 J; J' 0]   of order 2n,
// and J' y = c is the first half of K [y; v] = [0; c]. K is regular if J is, and its upper triangle has the nonzeros of
// J. Its determinant is +-det(J)^2, so that the sign of det J is unknown.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "assur/backend.hpp"

namespace assur {

// A library for one symmetric indefinite matrix; order >= 1, values finite.
class SymmetricSolver {
 public:
  virtual ~SymmetricSolver() = default;

  // row, column: the nonzeros of one triangle, from 1 on as Fortran counts; they outlive the solver.
  virtual void analyze(int order, std::span<int> row, std::span<int> column) = 0;
  virtual Code factorize(std::span<const double> values) = 0;  // ok or singular
  virtual void solve(std::span<double> b_to_x, int rhs) = 0;   // order x rhs
};

// A solver for square systems; each lane has a symmetric solver from make_symmetric. Figures have `ok` only.
[[nodiscard]] std::unique_ptr<LinearSolver> make_augmented(std::unique_ptr<SymmetricSolver> (*make_symmetric)());

}  // namespace assur
