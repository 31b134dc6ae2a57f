// Residuals and Jacobian of equations at a posture, dense or sparse, for the analysis of structures. The simulation
// uses programs instead (evaluation/coefficients.hpp).
#pragma once

#include <Eigen/Dense>
#include <Eigen/SparseCore>
#include <span>
#include <vector>

#include "equations/system.hpp"

namespace assur {

// Least scale of an equation, internal units. Without it, C.y = 0 would have a relative residual of 1 at C.y = 1e-30.
inline constexpr double kLeastScale = 0x1p-10;
// The same for residuals: the coefficients of an equation with small terms are often differences of larger numbers.
inline constexpr double kLeastTerms = 0.25;

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
      phi[i] = residual<double>(system_, equation(i), q);
    }
    return phi;
  }

  // max |Phi_i| / residual_scale(), the denominator at least kLeastTerms
  [[nodiscard]] double relative_residual(const std::vector<double>& q) const {
    double worst = 0;
    for (const Index e : equations_) {
      const double scale = residual_scale(system_, e, q);
      const double phi = std::abs(residual<double>(system_, e, q));
      worst = std::max(worst, !(phi <= 1e300) ? HUGE_VAL : phi / std::max(scale, kLeastTerms));
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

  // The second derivatives of all equations by the unknowns, each times a weight, in one sum: without functions of the
  // program.
  [[nodiscard]] Eigen::SparseMatrix<double> weighted_curvature(const Eigen::VectorXd& weights) const {
    std::vector<Eigen::Triplet<double>> triplets;
    number_columns();
    for (Eigen::Index i = 0; i < rows(); ++i) {
      for (const Product& p : system_.products_of(system_.equations[static_cast<std::size_t>(equation(i))])) {
        for (const Term& a : system_.form(p.a)) {
          for (const Term& b : system_.form(p.b)) {
            const Index row = column_of(a.coordinate), column = column_of(b.coordinate);
            if (row < 0 || column < 0) continue;
            const double value = weights[i] * constant(p.constant) * constant(a.constant) * constant(b.constant);
            triplets.emplace_back(row, column, value);
            triplets.emplace_back(column, row, value);
          }
        }
      }
    }
    forget_columns();
    Eigen::SparseMatrix<double> sum(columns(), columns());
    sum.setFromTriplets(triplets.begin(), triplets.end());
    return sum;
  }

 private:
  [[nodiscard]] Index equation(Eigen::Index row) const { return equations_[static_cast<std::size_t>(row)]; }
  [[nodiscard]] double constant(Index c) const { return system_.constants[static_cast<std::size_t>(c)]; }
  [[nodiscard]] Index column_of(Index coordinate) const { return column_[static_cast<std::size_t>(coordinate)]; }
  void number_columns() const {
    for (std::size_t j = 0; j < unknowns_.size(); ++j)
      column_[static_cast<std::size_t>(unknowns_[j])] = static_cast<Index>(j);
  }
  void forget_columns() const {
    for (const Index u : unknowns_) column_[static_cast<std::size_t>(u)] = -1;
  }

  template <class Put>
  void entries(const std::vector<double>& q, Put&& put) const {
    number_columns();
    for (Eigen::Index i = 0; i < rows(); ++i) {
      gradient<double>(system_, equation(i), q, [&](Index c, double value) {
        const Index j = column_of(c);
        if (j >= 0) put(i, j, value);
      });
    }
    forget_columns();
  }

  const System& system_;
  std::span<const Index> equations_, unknowns_;
  std::vector<Index>& column_;
};

}  // namespace assur
