#include "modes/homotopy.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace assur {
namespace {

// Polynomials in z, each given as a function of its matrix of coefficients: entry (i, j) belongs to z_i z_j, z_0 = 1.
Quadratics made(Eigen::Index m, const std::vector<Eigen::MatrixXd>& forms) {
  Quadratics q;
  for (const Eigen::MatrixXd& f : forms) q.forms.push_back((f + f.transpose()) / (f + f.transpose()).norm());
  q.origin = Eigen::VectorXd::Zero(m);
  q.basis = Eigen::MatrixXd::Identity(m, m);
  return q;
}

int ends(const Solutions& s) { return static_cast<int>(s.real.size()) + s.complex + s.diverged + s.multiple + s.lost; }

// Katsura's equations of a magnet with u_0 ... u_n: the linear one gives u_0. They have 2^n solutions, none at infinity
// (Boege, Gebauer, Kredel, Some examples for solving systems of algebraic equations by calculating Groebner bases,
// Journal of Symbolic Computation 2, 1986).
TEST(Homotopy, FindsAllSolutionsOfKatsura) {
  for (const int n : {1, 2, 3, 4, 5, 6}) {
    // u_l as a row of coefficients of (1, z_1, ..., z_n), z_l = u_l
    const auto u = [&](int l) {
      Eigen::VectorXd row = Eigen::VectorXd::Zero(n + 1);
      l = std::abs(l);
      if (l == 0) {
        row.setConstant(-2);
        row[0] = 1;
      } else if (l <= n) {
        row[l] = 1;
      }
      return row;
    };
    std::vector<Eigen::MatrixXd> forms;
    for (int m = 0; m < n; ++m) {
      Eigen::MatrixXd f = Eigen::MatrixXd::Zero(n + 1, n + 1);
      for (int l = -n; l <= n; ++l) f += u(l) * u(m - l).transpose();
      f.row(0) -= u(m).transpose();
      forms.push_back(f);
    }
    const Solutions s = solve(made(n, forms));
    EXPECT_EQ(s.paths, 1 << n);
    EXPECT_EQ(static_cast<int>(s.real.size()) + s.complex, 1 << n) << n;
    EXPECT_EQ(s.lost + s.diverged + s.multiple, 0) << n;
    for (const Solutions::Simple& simple : s.real) {
      Eigen::VectorXd z(n + 1);
      z << 1, simple.z;
      for (const Eigen::MatrixXd& f : forms) EXPECT_NEAR(z.dot(f * z), 0, 1e-13) << n;
    }
  }
}

// x^2 = e and y^2 = 1: for e > 0 four solutions, for e < 0 none, at e = 0 two double ones.
TEST(Homotopy, TellsRealFromComplexAndFromDouble) {
  for (const double e : {1.0, 1e-6, 1e-12, 0.0, -1e-12, -1e-6, -1.0}) {
    Eigen::MatrixXd x = Eigen::MatrixXd::Zero(3, 3), y = x;
    x.diagonal() << -e, 1, 0;
    y.diagonal() << -1, 0, 1;
    const Solutions s = solve(made(2, {x, y}));
    EXPECT_EQ(s.lost, 0) << e;
    EXPECT_EQ(ends(s), 4) << e;
    EXPECT_EQ(s.real.size(), e > 0 ? 4u : 0u) << e;
    EXPECT_EQ(s.complex, e < 0 ? 4 : 0) << e;
    EXPECT_EQ(s.multiple, e == 0 ? 4 : 0) << e;
    EXPECT_EQ(s.real_multiple.size(), e == 0 ? 2u : 0u) << e;
    for (const Solutions::Simple& simple : s.real) EXPECT_NEAR(std::abs(simple.z[0]), std::sqrt(e), 1e-15);
  }
}

// Two circles meet in two points at most: the other two paths lead to the circular points at infinity. Quadratics
// would find their difference, a linear equation; here they are solved as they are.
TEST(Homotopy, SendsSurplusPathsToInfinity) {
  for (const double distance : {1.0, 1.9, 2.0, 2.1}) {
    Eigen::MatrixXd a = Eigen::MatrixXd::Identity(3, 3), b = a;
    a(0, 0) = -1;
    b(0, 0) = distance * distance - 1;
    b(0, 1) = b(1, 0) = -distance;
    const Solutions s = solve(made(2, {a, b}));
    EXPECT_EQ(s.diverged, 2) << distance;
    EXPECT_EQ(s.lost, 0) << distance;
    EXPECT_EQ(s.real.size(), distance < 2 ? 2u : 0u) << distance;
    EXPECT_EQ(s.multiple, distance == 2 ? 2 : 0) << distance;
    for (const Solutions::Simple& simple : s.real) EXPECT_NEAR(simple.z[0], distance / 2, 1e-14);
  }
}

// x^2 + y^2 = 1 and x = x: a curve of solutions cannot be listed.
TEST(Homotopy, FindsNoSimpleSolutionOnACurve) {
  Eigen::MatrixXd a = Eigen::MatrixXd::Identity(3, 3);
  a(0, 0) = -1;
  const Solutions s = solve(made(2, {a, a}));
  EXPECT_EQ(s.real.size(), 0u);
  EXPECT_EQ(s.complex, 0);
  EXPECT_GT(s.multiple + s.lost, 0);
}

}  // namespace
}  // namespace assur
