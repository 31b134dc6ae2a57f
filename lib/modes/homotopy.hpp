// All isolated solutions of a few quadratic equations, by a homotopy over the complex numbers with as many paths as the
// product of the degrees (Sommese and Wampler, The Numerical Solution of Systems of Polynomials, 2005, chapters 2, 7
// and 10).
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <vector>

#include "modes/quadratics.hpp"

namespace assur {

// Most unknowns: 64 paths.
inline constexpr Eigen::Index kMostPolynomials = 6;

// The ends of all paths.
struct Solutions {
  struct Simple {
    Eigen::VectorXd z;
    double apart = 0;  // no other solution, real or complex, is nearer than this
  };
  std::vector<Simple> real;  // simple solutions
  int paths = 0;
  int complex = 0;                             // simple solutions that are not real
  int diverged = 0;                            // paths to infinity
  int multiple = 0;                            // paths to solutions that may be multiple: rounding hides the difference
  int lost = 0;                                // paths without an end; > 0: solutions may be missing
  std::vector<Eigen::VectorXd> real_multiple;  // real parts of multiple solutions that are real, each once
};

// Follows all paths at least twice, with different random constants, until two passes agree. The constants do not
// change from call to call. `system` is square with 1 to kMostPolynomials unknowns.
[[nodiscard]] Solutions solve(const Quadratics& system);

}  // namespace assur
