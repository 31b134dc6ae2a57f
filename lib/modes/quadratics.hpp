// The equations of a group as quadratic polynomials in few unknowns: linear equations are eliminated first.
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <span>
#include <vector>

#include "equations/system.hpp"

namespace assur {

// m polynomials in m unknowns z. The unknowns x of the group are x = origin + basis z.
struct Quadratics {
  enum class Kind : std::uint8_t {
    square,         // as many polynomials as unknowns; no linear combination of them is linear
    contradictory,  // linear equations contradict each other: there is no solution, real or complex
    dependent,      // fewer polynomials than unknowns: solutions are not isolated
  };
  Kind kind = Kind::square;
  // m symmetric matrices of order m + 1: the polynomial is (1, z)^T form (1, z). Their Frobenius norm is 1.
  std::vector<Eigen::MatrixXd> forms;
  Eigen::VectorXd origin;  // unknowns of the group
  Eigen::MatrixXd basis;   // unknowns of the group x m, orthonormal columns

  [[nodiscard]] Eigen::Index size() const { return basis.cols(); }
};

// The equations at the known values in q (all coordinates), expanded about the values of the unknowns in q. The
// equations must have no callbacks.
[[nodiscard]] Quadratics quadratics(const System& system, std::span<const Index> equations,
                                    std::span<const Index> unknowns, const std::vector<double>& q);

}  // namespace assur
