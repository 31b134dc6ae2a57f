#include "groups/newton_kantorovich.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "decompositions.hpp"
#include "groups/ball.hpp"
#include "numbers.hpp"

namespace assur {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
constexpr double kTiny = std::numeric_limits<double>::min();
constexpr double kSpare = 0x1p-40;  // relative margin of the radius that is tried, for the rounding of its verification
constexpr int kRefinements = 2;     // each one gains a factor Z1^2; further ones change no shown digit

double count(Eigen::Index i) { return static_cast<double>(i); }

// Upper bound of a number >= 0 that was computed, with at most k roundings, from numbers >= 0 without subtraction.
// (1 - u)^-k <= 1 + 2 k u, and kTiny exceeds the loss by an underflow.
double raised(double x, Eigen::Index k) { return x * (1 + 2 * count(k) * kEps) + count(k) * kTiny; }
MatrixXd raised(const MatrixXd& x, Eigen::Index k) {
  return (x.array() * (1 + 2 * count(k) * kEps) + count(k) * kTiny).matrix();
}

// Upper bounds of |x| for all matrices x in the ball.
MatrixXd magnitude(const BallMatrix& x) { return raised(x.middle.cwiseAbs() + x.radius, 1); }

// NaN if an element is NaN.
double largest(const VectorXd& x) {
  double most = 0;
  for (const double v : x) {
    if (!(v <= most)) most = v;
  }
  return most;
}

}  // namespace

BallMatrix product(const MatrixXd& c, const BallMatrix& x) {
  const Eigen::Index k = c.cols();
  const double gamma = count(k) * kEps;  // >= k u / (1 - k u)
  const MatrixXd entry = raised(x.radius + gamma * x.middle.cwiseAbs(), 2);
  return {c * x.middle, raised(c.cwiseAbs() * entry, k + 1)};
}

SolutionProof prove_solution(const ProofEquations& e) {
  const Eigen::Index n = e.jacobian.middle.rows(), m = e.input_radius.size();
  SolutionProof proof;
  const MatrixXd c = e.jacobian.middle.partialPivLu().inverse();
  if (!c.allFinite()) {
    proof.defect = kInfinity;
    return proof;
  }

  VectorXd y = magnitude(product(c, e.residual));
  if (m > 0) y = raised(y + magnitude(product(c, e.by_inputs)) * e.input_radius, m + 1);
  BallMatrix defect = product(c, e.jacobian);
  defect.middle = MatrixXd::Identity(n, n) - defect.middle;
  const MatrixXd z = raised(magnitude(defect), 1);  // one more rounding, by the subtraction
  const MatrixXd c_magnitude = c.cwiseAbs();
  const auto curvature = [&](const VectorXd& d) -> VectorXd { return raised(c_magnitude * e.curvature(d), n + 1); };

  proof.correction = largest(y);
  proof.defect = largest(raised(z.rowwise().sum(), n));
  proof.curvature = largest(curvature(VectorXd::Ones(n)));

  // The smaller root of Y - (1 - Z1) r + B r^2. Its rounding does not matter, because the next lines verify it.
  const double slope = 1 - proof.defect;
  const double root = std::sqrt(slope * slope - 4 * proof.curvature * proof.correction);
  const double r = 2 * proof.correction / (slope + root) * (1 + kSpare) + kTiny / kSpare;
  const double reached = raised(proof.correction + proof.defect * r + proof.curvature * r * r, 5);
  if (!(reached <= r && raised(proof.defect + 2 * proof.curvature * r, 4) < 1)) return proof;
  proof.holds = true;

  proof.radius = VectorXd::Constant(n, r);
  for (int k = 0; k < kRefinements; ++k) {
    proof.radius = proof.radius.cwiseMin(raised(y + z * proof.radius + curvature(proof.radius), n + 2));
  }
  proof.uniqueness = down(down(down(slope) / proof.curvature) - r);  // infinite for linear equations
  return proof;
}

}  // namespace assur
