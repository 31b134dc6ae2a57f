// Tests of KLU alone, which keeps its pivots from one factorisation to the next and checks them.
#include <gtest/gtest.h>

#include <cmath>

#include "assur/backend.hpp"
#include "backends/allocations.hpp"
#include "backends/matrices.hpp"

namespace assur::test {
namespace {

class Klu : public testing::Test {
 protected:
  void SetUp() override {
    const Backend& klu = find_backend(backends(), "klu");
    const std::string why_not = klu.why_not(Shape{}, ThreadBudget{});
    if (!why_not.empty()) GTEST_SKIP() << why_not;
    solver_ = klu.make(ThreadBudget{}, Precision::binary64);
  }

  // Factorises, and returns the backward error of one solution. Only new pivots allocate.
  double step(const Matrix& a) {
    const auto before = allocations();
    EXPECT_TRUE(solver_->factorize(a.values).ok());
    pivoted_ = allocations() != before;
    std::vector<double> b(static_cast<std::size_t>(a.pattern.n));
    for (std::size_t i = 0; i < b.size(); ++i) b[i] = 1 + 0.1 * static_cast<double>(i % 7);
    std::vector<double> x = b;
    EXPECT_TRUE(solver_->solve(x, 1).ok());
    return backward_error(a, x, b);
  }

  std::unique_ptr<LinearSolver> solver_;
  bool pivoted_ = false;
};

TEST_F(Klu, DeterminantSignEqualsDenseElimination) {
  const auto dense_solver = find_backend(backends(), "eigen").make(ThreadBudget{}, Precision::binary64);
  Random random(11);
  int negative = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const int n = 1 + trial % 20;
    Matrix a = trial % 3 == 0 ? permuted_triangle(n, 1 + trial % 4, random) : sparse(n, 1 + trial % 4, random);
    ASSERT_TRUE(solver_->analyze(a.pattern, 1).ok());
    ASSERT_TRUE(dense_solver->analyze(a.pattern, 1).ok());
    for (int again = 0; again < 3; ++again) {  // refactorised after the first time
      ASSERT_TRUE(solver_->factorize(a.values).ok());
      ASSERT_TRUE(dense_solver->factorize(a.values).ok());
      EXPECT_EQ(solver_->figures(0).determinant_sign, dense_solver->figures(0).determinant_sign) << trial;
      negative += solver_->figures(0).determinant_sign < 0;
      const auto turned = static_cast<int>(random() % static_cast<unsigned>(n));
      scale(a, [&](int row, int) { return row == turned ? -1.0 : 1.0; });
    }
  }
  EXPECT_GT(negative, 300);  // of 900: both signs occur
  EXPECT_LT(negative, 600);
}

TEST_F(Klu, SolvesRingsToRoundingError) {
  Random random(2);
  for (int n : {12, 24, 120, 360, 720}) {
    for (int posture = 0; posture < 5; ++posture) {
      const Matrix a = ring(n, random);
      if (posture == 0) {
        ASSERT_TRUE(solver_->analyze(a.pattern, 1).ok());
      }
      EXPECT_LE(step(a), 10 * n * kEps) << n;
      EXPECT_LE(solver_->figures(0).pivot_growth, 64);
    }
  }
}

// Entries oscillate with different phases, so that every pivot passes through zero at some time.
TEST_F(Klu, RepivotsOnlyWhenPivotsBecomeBad) {
  const int n = 15, steps = 2000;
  Random random(4);
  Matrix a = sparse(n, 3, random);
  std::vector<double> phase(a.values.size());
  for (double& p : phase) p = uniform(random, 0, 6);
  ASSERT_TRUE(solver_->analyze(a.pattern, 1).ok());
  int pivoted = 0;
  for (int k = 0; k < steps; ++k) {
    for (std::size_t i = 0; i < phase.size(); ++i) a.values[i] = std::cos(phase[i] + 6.0 * k / steps);
    EXPECT_LE(step(a), 10 * n * kEps) << k;
    pivoted += pivoted_;
  }
  EXPECT_GT(pivoted, 1);           // not only the first time
  EXPECT_LT(pivoted, steps / 20);  // all other steps refactorise
}

// A small pivot that only causes large entries in L. With diagonal pivots U is {e 1 0; 1 0; 1}, and L has two entries
// of size 1/e.
TEST_F(Klu, DetectsGrowthInL) {
  const auto matrix = [](double e) {
    const double rows[3][3] = {{e, 1, 0}, {0, 1, 0}, {1, 0, 1}};
    return compress(
        3, [](int, int) { return true; }, [&](int i, int j) { return rows[i][j]; });
  };
  ASSERT_TRUE(solver_->analyze(matrix(1).pattern, 1).ok());
  EXPECT_LE(step(matrix(1)), 30 * kEps);
  EXPECT_TRUE(pivoted_);
  for (double e : {1e-3, 1e-6, 1e-9, 1e-12}) {
    EXPECT_LE(step(matrix(e)), 30 * kEps) << e;
    EXPECT_EQ(pivoted_, e == 1e-3) << e;
  }
  EXPECT_LE(step(matrix(1e-12)), 30 * kEps);
  EXPECT_FALSE(pivoted_);
}

// Scales are powers of two, so that new scales change neither the pivots nor any bit of the solution.
TEST_F(Klu, AcceptsRowsThatChangeTheirScale) {
  const int n = 15;
  Random random(8);
  Matrix a = sparse(n, 3, random);
  ASSERT_TRUE(solver_->analyze(a.pattern, 1).ok());
  std::vector<double> b(n, 1.0), expected;
  for (int k = 0; k < 300; ++k) {  // up to 2^300 and down to 2^-300
    EXPECT_LE(step(a), 10 * n * kEps);
    EXPECT_EQ(pivoted_, k == 0) << k;
    std::vector<double> x = b;
    ASSERT_TRUE(solver_->solve(x, 1).ok());
    if (k == 0) expected = x;
    EXPECT_EQ(x, expected) << k;
    const auto factor = [](int row) { return std::ldexp(1, row % 3 - 1); };
    scale(a, [&](int row, int) { return factor(row); });
    for (int i = 0; i < n; ++i) b[static_cast<std::size_t>(i)] *= factor(i);
  }
}

TEST_F(Klu, EachLaneHasItsOwnPivots) {
  Random random(6);
  const Matrix a = sparse(15, 3, random);
  Matrix moving = a;
  ASSERT_TRUE(solver_->analyze(a.pattern, 2).ok());
  std::vector<double> first;
  for (int k = 0; k < 20; ++k) {
    ASSERT_TRUE(solver_->factorize(interleave({moving.values, a.values})).ok());
    std::vector<double> x(30, 1.0);
    ASSERT_TRUE(solver_->solve(x, 1).ok());
    EXPECT_LE(backward_error(moving, lane_of(x, 2, 0), std::vector<double>(15, 1.0)), 150 * kEps);
    if (k == 0) first = lane_of(x, 2, 1);
    EXPECT_EQ(lane_of(x, 2, 1), first);
    scale(moving, [&](int i, int j) { return i % 3 == j % 3 ? 0.1 : 1.0; });
  }
}

}  // namespace
}  // namespace assur::test
