// Assembles a block from a poor guess.
#pragma once

#include <string>
#include <vector>

#include "graph/blocks.hpp"
#include "numbers.hpp"

namespace assur {

inline constexpr double kSatisfied = 64 * kEps;  // relative residual of an equation that holds
// A posture within this distance of its guess, in internal units, is on the branch of the guess.
inline constexpr double kNearGuess = 0.25;

// The result of assemble().
struct BlockAssembly {
  enum class Mode : std::uint8_t {
    same,           // the assembly mode of the guess
    other,          // the Jacobian's determinant changed sign on the way
    not_decidable,  // the guess itself is near singular
  };
  bool converged = false;
  bool singular = false;  // the Jacobian at the assembled posture is numerically rank-deficient
  Mode mode = Mode::same;
};

// Moves the unknowns of one block in q, all others held, until its equations hold: damped Newton with the natural
// monotonicity test (Deuflhard, Newton Methods for Nonlinear Problems, 2004, section 3.3), Levenberg-Marquardt if the
// Jacobian is singular. `column` is scratch, see DenseBlock.
[[nodiscard]] BlockAssembly assemble(const System& system, std::span<const Index> equations,
                                     std::span<const Index> unknowns, std::vector<double>& q,
                                     std::vector<Index>& column);

// Moves q to a least-squares solution (Levenberg-Marquardt) of any number of equations, which may depend on each other.
// Returns the relative residual.
double fit(const System& system, std::span<const Index> equations, std::span<const Index> unknowns,
           std::vector<double>& q, std::vector<Index>& column);

}  // namespace assur
