// A proof that n quadratic equations Phi(x, h) = 0 have exactly one solution x* near a posture x, for every h of a box.
//
// With d = x* - x and any matrix C (here: an approximate inverse of the Jacobian J = Phi_x(x, h)), Taylor's formula,
// which ends with the second derivative, says
//     d = -C Phi(x, h) + (I - C J(x, h)) d - C Phi_xx(d, d) / 2.
// Let y >= |C Phi(x, h)|, Z >= |I - C J(x, h)| (componentwise, for every h) and b >= |C Phi_xx(d, e) / 2| for all |d|,
// |e| <= 1. If Y = |y|, Z1 = |Z| and B = |b| in the maximum norm fulfil, for some r,
//     Y + Z1 r + B r^2 <= r   and   Z1 + 2 B r < 1,
// then T(x + d) = x + d - C Phi(x + d, h) maps the ball |d| <= r into itself and contracts, and as Z1 < 1 makes C
// regular, its only fixed point is x* (Kantorovich 1948; with C in place of the exact inverse: Krawczyk 1969, and the
// radii polynomials of Day, Lessard & Mischaikow, SIAM J. Numer. Anal. 45, 2007). Two solutions x* and x*' with d and
// d' would satisfy d - d' = (I - C J((x* + x*') / 2)) (d - d'), so that there is no other solution within R = (1 - Z1)
// / B - r. The formula, with the bound of d on its right-hand side, then gives a bound for each row: |d| <= y + Z |d| +
// |C Phi_xx(d, d) / 2|.
//
// All of this is computed in double, with bounds for rounding: the error of a sum of k products is at most gamma_k = k
// u / (1 - k u) times the sum of their magnitudes, in any order of summation (Higham, Accuracy and Stability of
// Numerical Algorithms, 2002, section 3.1).
#pragma once

#include <Eigen/Dense>
#include <functional>

namespace assur {

// The set of all matrices whose entries are within `radius` of those of `middle`.
struct BallMatrix {
  Eigen::MatrixXd middle, radius;
};

// A set that holds c X for every matrix X in `x`.
[[nodiscard]] BallMatrix product(const Eigen::MatrixXd& c, const BallMatrix& x);

// n equations around a posture x and the middle of the box of their m inputs.
struct ProofEquations {
  BallMatrix residual;           // n x 1: Phi(x, h) at the middle of the box
  BallMatrix jacobian;           // n x n: J(x, h) for every h of the box
  BallMatrix by_inputs;          // n x m: Phi_h(x, h) for every h of the box
  Eigen::VectorXd input_radius;  // m: half the box
  // n upper bounds of |Phi_xx(d, e) / 2| for all |d|, |e| <= radius.
  std::function<Eigen::VectorXd(const Eigen::VectorXd& radius)> curvature;
};

// The result of the proof.
struct SolutionProof {
  bool holds = false;
  Eigen::VectorXd radius;  // n: bounds of |x* - x|
  double uniqueness = 0;   // there is no other solution within this distance, maximum norm
  // The figures of the conditions above; not finite if the Jacobian has no inverse.
  double correction = 0;  // Y
  double defect = 0;      // Z1
  double curvature = 0;   // B
};

// Tries to prove that there is exactly one solution.
[[nodiscard]] SolutionProof prove_solution(const ProofEquations& equations);

}  // namespace assur
