// Residuals and Jacobian of equations at a posture, dense or sparse, for the analysis of structures. The simulation
// uses programs instead (equations/program.hpp).
#pragma once

#include <Eigen/Dense>
#include <Eigen/SparseCore>
#include <span>
#include <vector>

#include "scene/system.hpp"

namespace assur {

// Least scale of an equation, internal units. Without it, C.y = 0 would have a relative residual of 1 at C.y = 1e-30.
inline constexpr double kLeastScale = 0x1p-10;

// A set of equations and unknowns.
class DenseBlock {
 public:
  // `column` is scratch shared by all blocks: one entry for each coordinate, all -1 between uses.
  DenseBlock(const System& system, std::span<const Index> equations, std::span<const Index> unknowns,
             std::vector<Index>& column)
      : system_(system), equations_(equations), unknowns_(unknowns), column_(column) {}

  [[nodiscard]] Eigen::Index rows() const { return static_cast<Eigen::Index>(equations_.size()); }
  [[nodiscard]] Eigen::Index columns() const { return static_cast<Eigen::Index>(unknowns_.size()); }

  [[nodiscard]] Eigen::VectorXd residuals(const std::vector<double>& q) const {
    Eigen::VectorXd phi(rows());
    for (Eigen::Index i = 0; i < rows(); ++i) {
      phi[i] = residual<double>(system_, equations_[static_cast<std::size_t>(i)], q);
    }
    return phi;
  }

  // max |Phi_i| / residual_scale(), the denominator at least kLeastScale
  [[nodiscard]] double relative_residual(const std::vector<double>& q) const {
    double worst = 0;
    for (const Index e : equations_) {
      const double scale = residual_scale(system_, e, q);
      const double phi = std::abs(residual<double>(system_, e, q));
      worst = std::max(worst, !(phi <= 1e300) ? HUGE_VAL : phi / std::max(scale, kLeastScale));
    }
    return worst;
  }

  [[nodiscard]] Eigen::MatrixXd jacobian(const std::vector<double>& q) const {
    Eigen::MatrixXd j = Eigen::MatrixXd::Zero(rows(), columns());
    entries(q, [&](Eigen::Index row, Eigen::Index column, double value) { j(row, column) += value; });
    return j;
  }

  [[nodiscard]] Eigen::SparseMatrix<double> sparse_jacobian(const std::vector<double>& q) const {
    std::vector<Eigen::Triplet<double>> triplets;
    entries(q, [&](Eigen::Index row, Eigen::Index column, double value) {
      triplets.emplace_back(static_cast<int>(row), static_cast<int>(column), value);
    });
    Eigen::SparseMatrix<double> j(rows(), columns());
    j.setFromTriplets(triplets.begin(), triplets.end());
    return j;
  }

 private:
  template <class Put>
  void entries(const std::vector<double>& q, Put&& put) const {
    for (std::size_t j = 0; j < unknowns_.size(); ++j)
      column_[static_cast<std::size_t>(unknowns_[j])] = static_cast<Index>(j);
    for (Eigen::Index i = 0; i < rows(); ++i) {
      gradient<double>(system_, equations_[static_cast<std::size_t>(i)], q, [&](Index c, double value) {
        const Index j = column_[static_cast<std::size_t>(c)];
        if (j >= 0) put(i, j, value);
      });
    }
    for (const Index u : unknowns_) column_[static_cast<std::size_t>(u)] = -1;
  }

  const System& system_;
  std::span<const Index> equations_, unknowns_;
  std::vector<Index>& column_;
};

}  // namespace assur
