// The start posture from a poor guess, block after block.
#pragma once

#include <string>
#include <vector>

#include "structure/blocks.hpp"

namespace assur {

struct BlockAssembly {
  enum class Mode : std::uint8_t {
    same,           // the assembly mode of the guess
    other,          // the Jacobian's determinant changed sign on the way
    not_decidable,  // the guess itself is near singular
  };
  bool converged = false;
  bool singular = false;  // the Jacobian at the assembled posture is numerically rank-deficient
  Mode mode = Mode::same;
  Index worst_equation = -1;  // if not converged: the most violated one
  double violation = 0;       // |Phi| / |grad Phi|, internal units
};

// Moves the unknowns of one block in q, all others held, until its equations hold: damped Newton with the natural
// monotonicity test (Deuflhard, Newton Methods for Nonlinear Problems, 2004, section 3.3), Levenberg-Marquardt where
// the Jacobian is singular. `column` is scratch, see DenseBlock.
[[nodiscard]] BlockAssembly assemble(const System& system, std::span<const Index> equations,
                                     std::span<const Index> unknowns, std::vector<double>& q,
                                     std::vector<Index>& column);

// One small step along a branch: undamped Newton from a posture nearby. False, and q as it was, if it does not converge
// within a quarter of a typical length, or if the Jacobian's determinant changes its sign on the way; `sign` is that of
// the step before, 0 if there is none.
[[nodiscard]] bool follow(const System& system, std::span<const Index> equations, std::span<const Index> unknowns,
                          std::vector<double>& q, int& sign, std::vector<Index>& column);

// Least-squares posture of equations that may be more or fewer than the unknowns, or dependent: Levenberg-Marquardt.
// Returns the relative residual reached.
double fit(const System& system, std::span<const Index> equations, std::span<const Index> unknowns,
           std::vector<double>& q, std::vector<Index>& column);

}  // namespace assur
