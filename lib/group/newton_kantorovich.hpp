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
// radii polynomials of Day, Lessard & Mischaikow, SIAM J. Numer. Anal. 45, 2007). Two solutions with |d|, |d'| would
// fulfil d - d' = (I - C J((x* + x*') / 2)) (d - d'), so there is no other one below R = (1 - Z1) / B - r. And what d
// is bounded by goes back into the formula, row by row: |d| <= y + Z |d| + |C Phi_xx(d, d) / 2|.
//
// All of this is computed in double, with bounds of what rounding loses: of a sum of k products at most gamma_k =
// k u / (1 - k u) times the sum of their magnitudes, in whatever order it is taken (Higham, Accuracy and Stability of
// Numerical Algorithms, 2002, section 3.1).
#pragma once

#include <Eigen/Dense>
#include <functional>

namespace assur {

// Holds every matrix that is within `radius` of `middle`, entry by entry.
struct BallMatrix {
  Eigen::MatrixXd middle, radius;
};

// Holds c x for every x in `x`.
[[nodiscard]] BallMatrix product(const Eigen::MatrixXd& c, const BallMatrix& x);

// n equations around a posture x and the middle of the box of their m inputs.
struct QuadraticEquations {
  BallMatrix residual;           // n x 1: Phi(x, h) at the middle of the box
  BallMatrix jacobian;           // n x n: J(x, h) for every h of the box
  BallMatrix by_inputs;          // n x m: Phi_h(x, h) for every h of the box
  Eigen::VectorXd input_radius;  // m: half the box
  // n upper bounds of |Phi_xx(d, e) / 2| for all |d|, |e| <= radius.
  std::function<Eigen::VectorXd(const Eigen::VectorXd& radius)> curvature;
};

struct SolutionProof {
  bool holds = false;
  Eigen::VectorXd radius;  // n: |x* - x|
  double uniqueness = 0;   // no other solution within, in the maximum norm
  // The figures of the conditions above; not finite if the Jacobian has no inverse.
  double correction = 0;  // Y
  double defect = 0;      // Z1
  double curvature = 0;   // B
};

[[nodiscard]] SolutionProof prove_solution(const QuadraticEquations& equations);

}  // namespace assur
