#include "start/assembly.hpp"

#include <Eigen/SparseCholesky>
#include <cmath>
#include <limits>

#include "decompositions.hpp"
#include "equations/dense_block.hpp"
#include "numbers.hpp"

namespace assur {
namespace {
constexpr int kAssemblySteps = 60;    // the tests of structures take 12 at most, and 6 of kPolishSteps
constexpr int kFitSteps = 400;        // a choice: contradictory equations can take as many as are allowed
constexpr double kWellDamped = 1e-3;  // internal units; the squared condition is then at most 1e6
constexpr double kLeastGain = 1e-4;   // of a step of least squares, as a part of the sum of squares
constexpr int kPolishSteps = 10;      // of Newton's method, after least squares
constexpr double kStuck = 1e-8;       // relative residual, a choice: least squares that end above it found no posture
constexpr double kNudge = 0.1;        // internal units, a choice: typical lengths are 1

// A direct solution with its condition and the sign of the determinant.
class Linearization {
 public:
  explicit Linearization(const DenseBlock& block, const std::vector<double>& q) {
    if (block.rows() <= kLargestDenseLu) {
      const Eigen::MatrixXd j = block.jacobian(q);
      // Rows are scaled to unit length, so that rank and condition do not depend on the units of an equation.
      scale_ = j.rowwise().norm().cwiseMax(std::numeric_limits<double>::min()).cwiseInverse();
      dense_.compute(scale_.asDiagonal() * j);
      const auto u = dense_.matrixLU().diagonal().cwiseAbs();
      rcond_ = u.size() == 0 ? 1 : u.minCoeff() / u.maxCoeff();
      if (rcond_ > 0 && std::isfinite(rcond_)) rcond_ = std::min(rcond_, dense_.rcond());
      sign_ = dense_.determinant() < 0 ? -1 : 1;
      is_dense_ = true;
    } else {
      Eigen::SparseMatrix<double> j = block.sparse_jacobian(q);
      j.makeCompressed();
      sparse_.compute(j);
      rcond_ = sparse_.info() == Eigen::Success && std::isfinite(sparse_.logAbsDeterminant()) ? 1 : 0;
      if (rcond_ > 0) sign_ = sparse_.signDeterminant() < 0 ? -1 : 1;
    }
    if (!std::isfinite(rcond_)) rcond_ = 0;
  }
  [[nodiscard]] double rcond() const { return rcond_; }
  [[nodiscard]] int sign() const { return sign_; }
  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& b) const {
    if (is_dense_) return dense_.solve(scale_.asDiagonal() * b);
    return sparse_.solve(b);
  }

 private:
  bool is_dense_ = false;
  Eigen::VectorXd scale_;
  Eigen::PartialPivLU<Eigen::MatrixXd> dense_;
  Eigen::SparseLU<Eigen::SparseMatrix<double>> sparse_;
  double rcond_ = 0;
  int sign_ = 1;
};

Eigen::VectorXd gather(std::span<const Index> unknowns, const std::vector<double>& q) {
  Eigen::VectorXd x(static_cast<Eigen::Index>(unknowns.size()));
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = q[static_cast<std::size_t>(unknowns[static_cast<std::size_t>(i)])];
  return x;
}
void scatter(std::span<const Index> unknowns, const Eigen::VectorXd& x, std::vector<double>& q) {
  for (Eigen::Index i = 0; i < x.size(); ++i) q[static_cast<std::size_t>(unknowns[static_cast<std::size_t>(i)])] = x[i];
}

// Levenberg-Marquardt down to a stationary point of the sum of squares.
void descend(const DenseBlock& block, std::span<const Index> unknowns, std::vector<double>& q) {
  double mu = 1e-3;
  double best = block.residuals(q).squaredNorm();
  for (int step = 0; step < kFitSteps; ++step) {
    if (block.relative_residual(q) <= 4 * kEps) break;
    const Eigen::SparseMatrix<double> j = block.sparse_jacobian(q);
    const Eigen::VectorXd phi = block.residuals(q), x = gather(unknowns, q);
    const Eigen::VectorXd g = j.transpose() * phi;
    const bool is_dense = block.columns() <= kLargestDenseLu;
    bool improved = false;
    for (int attempt = 0; attempt < 40 && !improved; ++attempt) {
      // min |J p + phi|^2 + mu^2 |p|^2. J^T J squares the condition, so that it serves only well damped steps.
      Eigen::VectorXd p;
      if (is_dense && mu >= kWellDamped) {
        Eigen::MatrixXd damped(j.transpose() * j);
        damped.diagonal().array() += mu * mu;
        p = damped.llt().solve(-g);
      } else if (is_dense) {
        Eigen::MatrixXd a(block.rows() + block.columns(), block.columns());
        a << Eigen::MatrixXd(j), mu * Eigen::MatrixXd::Identity(block.columns(), block.columns());
        Eigen::VectorXd b = Eigen::VectorXd::Zero(a.rows());
        b.head(block.rows()) = -phi;
        p = a.householderQr().solve(b);
      } else {
        Eigen::SparseMatrix<double> identity(block.columns(), block.columns());
        identity.setIdentity();
        Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> damped(j.transpose() * j + mu * mu * identity);
        p = damped.solve(-g);
      }
      scatter(unknowns, x + p, q);
      const double now = block.residuals(q).squaredNorm();
      if (p.allFinite() && now < best) {
        if (mu <= 1 && now > best * (1 - kLeastGain)) return;  // as good as stationary
        improved = true;
        best = now;
        mu = std::max(mu / 10, 1e-14);
      } else {
        scatter(unknowns, x, q);
        mu *= 4;
        if (mu > 1e8) return;
      }
    }
    if (!improved) break;
  }
}

// Moves along the direction in which the equations change least. A guess on a line of symmetry leads to a stationary
// point on that line, which is not a solution.
void leave_saddle(const DenseBlock& block, std::span<const Index> unknowns, std::vector<double>& q) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(block.jacobian(q), Eigen::ComputeFullV);
  scatter(unknowns, gather(unknowns, q) + kNudge * svd.matrixV().rightCols(1), q);
}

// Undamped Newton converges to the posture of a good guess even if that posture is badly conditioned; damping may lead
// to another one nearby. False, with q unchanged, if it does not converge within kNearGuess of the guess.
bool polish(const DenseBlock& block, std::span<const Index> unknowns, std::vector<double>& q) {
  const Eigen::VectorXd guess = gather(unknowns, q);
  for (int step = 0; step < kPolishSteps; ++step) {
    if (block.relative_residual(q) <= kSatisfied) return true;
    const Linearization j(block, q);
    if (!(j.rcond() > kEps)) break;
    const Eigen::VectorXd x = gather(unknowns, q) - j.solve(block.residuals(q));
    if (!((x - guess).lpNorm<Eigen::Infinity>() <= kNearGuess)) break;
    scatter(unknowns, x, q);
  }
  if (block.relative_residual(q) <= kSatisfied) return true;
  scatter(unknowns, guess, q);
  return false;
}

}  // namespace

BlockAssembly assemble(const System& s, std::span<const Index> equations, std::span<const Index> unknowns,
                       std::vector<double>& q, std::vector<Index>& column) {
  const DenseBlock block(s, equations, unknowns, column);
  BlockAssembly out;
  int first_sign = 0;
  bool decidable = true;
  bool fitted = false;
  for (int step = 0; step < kAssemblySteps; ++step) {
    const double residual_now = block.relative_residual(q);
    if (!(residual_now < HUGE_VAL)) break;
    const Linearization j(block, q);
    if (step == 0) {
      first_sign = j.sign();
      decidable = j.rcond() > 1e-8;
      if (residual_now > kSatisfied && polish(block, unknowns, q)) continue;
    } else if (j.rcond() > 1e-8) {
      out.mode = j.sign() == first_sign ? BlockAssembly::Mode::same : BlockAssembly::Mode::other;
    }
    if (residual_now <= kSatisfied) {
      out.converged = true;
      out.singular = j.rcond() < 16 * kEps * static_cast<double>(unknowns.size());
      if (!out.singular) {  // one more correction to the rounding level
        const Eigen::VectorXd x = gather(unknowns, q);
        scatter(unknowns, x - j.solve(block.residuals(q)), q);
        if (!(block.relative_residual(q) <= std::max(residual_now, 4 * kEps))) scatter(unknowns, x, q);
      }
      break;
    }
    const Eigen::VectorXd x = gather(unknowns, q);
    bool accepted = false;
    if (j.rcond() > kEps) {
      const Eigen::VectorXd p = -j.solve(block.residuals(q));
      for (double alpha = 1; alpha > 1e-4 && p.allFinite(); alpha /= 2) {
        scatter(unknowns, x + alpha * p, q);
        const Eigen::VectorXd next = j.solve(block.residuals(q));
        // Second test: at the rounding level of a badly conditioned block, no correction contracts.
        if (next.allFinite() &&
            (next.norm() <= (1 - alpha / 4) * p.norm() || block.relative_residual(q) <= kSatisfied)) {
          accepted = true;
          break;
        }
      }
    }
    if (!accepted) {
      scatter(unknowns, x, q);
      if (fitted) break;
      fitted = true;
      fit(s, equations, unknowns, q, column);
    }
  }
  if (!out.converged) return out;
  if (!decidable && (first_sign != 0) && fitted) {
    out.mode = BlockAssembly::Mode::not_decidable;
  } else if (!decidable) {
    out.mode = out.singular ? BlockAssembly::Mode::same : BlockAssembly::Mode::not_decidable;
  }
  return out;
}

double fit(const System& s, std::span<const Index> equations, std::span<const Index> unknowns, std::vector<double>& q,
           std::vector<Index>& column) {
  const DenseBlock block(s, equations, unknowns, column);
  descend(block, unknowns, q);
  const double reached = block.relative_residual(q);
  if (reached <= kStuck || std::max(block.rows(), block.columns()) > kLargestDenseLu) return reached;
  const Eigen::VectorXd x = gather(unknowns, q);
  leave_saddle(block, unknowns, q);
  descend(block, unknowns, q);
  if (!(block.relative_residual(q) < reached)) scatter(unknowns, x, q);
  return block.relative_residual(q);
}

}  // namespace assur
