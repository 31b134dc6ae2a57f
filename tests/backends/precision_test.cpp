// Factorisation and solution in float by the dense backends, including numbers beyond the range of float.
#include <gtest/gtest.h>

#include "assur/backend.hpp"
#include "backends/allocations.hpp"
#include "backends/matrices.hpp"

namespace assur::test {
namespace {

constexpr double kFloatEps = std::numeric_limits<float>::epsilon();

class Single : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    const Backend& backend = find_backend(backends(), GetParam());
    if (const std::string why_not = backend.why_not({}, {}); !why_not.empty()) GTEST_SKIP() << why_not;
    ASSERT_TRUE(backend.single);
    solver_ = backend.make(ThreadBudget{}, Precision::binary32);
  }

  Code factorize(const Matrix& a) {
    EXPECT_TRUE(solver_->analyze(a.pattern, 1).ok());
    return solver_->factorize(a.values).code;
  }

  std::unique_ptr<LinearSolver> solver_;
};

std::vector<double> ones(int n) { return std::vector(static_cast<std::size_t>(n), 1.0); }

// The error is as large as that of float. Rounding the values costs eps / 2 as well.
TEST_P(Single, SolvesWithFloatAccuracy) {
  Random random(3);
  for (int n : {1, 2, 3, 8, 9, 15, 40, 102, 250}) {
    for (const Transpose transpose : {Transpose::no, Transpose::yes}) {
      const Matrix a = dense(n, random);
      ASSERT_EQ(factorize(a), Code::ok);
      std::vector<double> x;
      for (int i = 0; i < 5 * n; ++i) x.push_back(nonzero(random));
      const std::vector<double> b = x;
      ASSERT_TRUE(solver_->solve(x, 5, transpose).ok());
      double largest = 0;
      for (int r = 0; r < 5; ++r) {
        const auto part = [&](const std::vector<double>& v) {
          return std::span(v).subspan(static_cast<std::size_t>(r * n), static_cast<std::size_t>(n));
        };
        largest = std::max(largest, backward_error(a, part(x), part(b), transpose));
      }
      EXPECT_LE(largest, 10 * n * kFloatEps) << n;
      EXPECT_GT(largest, 1e4 * kEps) << n;
    }
  }
}

TEST_P(Single, ReportsValuesBeyondFloatAsNotFinite) {
  Random random(3);
  Matrix a = dense(4, random);
  a.values[5] = 1e39;
  EXPECT_EQ(factorize(a), Code::not_finite);
  EXPECT_FALSE(solver_->figures(0).ok);
  a.values[5] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(factorize(a), Code::not_finite);
  a = dense(4, random);
  scale(a, [](int, int j) { return j == 2 ? 1e-50 : 1; });  // below the range of float, so the column is zero
  EXPECT_EQ(factorize(a), Code::singular);
}

// Refinement solves for residuals, which can be arbitrarily small.
TEST_P(Single, RightHandSidesMayHaveAnySize) {
  Random random(3);
  const int n = 15;
  const Matrix a = dense(n, random);
  ASSERT_EQ(factorize(a), Code::ok);
  std::vector<double> unit = ones(n);
  ASSERT_TRUE(solver_->solve(unit, 1).ok());
  for (const int exponent : {-1060, -700, -100, 100, 700, 1000}) {
    std::vector<double> x = ones(n);
    for (double& element : x) element = std::ldexp(element, exponent);
    ASSERT_TRUE(solver_->solve(x, 1).ok());
    for (std::size_t i = 0; i < x.size(); ++i) {
      // Subnormal results have fewer digits.
      EXPECT_NEAR(x[i], std::ldexp(unit[i], exponent), std::numeric_limits<double>::denorm_min());
    }
  }
}

TEST_P(Single, AllocatesNothingAfterTheFirstFactorisation) {
  if (!find_backend(backends(), GetParam()).steady) GTEST_SKIP() << "the backend promises no steady state";
  Random random(3);
  for (int n : {102, 200, 250, 433}) {
    const Matrix a = dense(n, random);
    std::vector<double> x = ones(n);
    ASSERT_EQ(factorize(a), Code::ok);
    const auto before = allocations();
    for (int i = 0; i < 3; ++i) {
      ASSERT_TRUE(solver_->factorize(a.values).ok());
      ASSERT_TRUE(solver_->solve(x, 1).ok());
    }
    EXPECT_EQ(allocations() - before, 0) << n;
  }
}

INSTANTIATE_TEST_SUITE_P(Dense, Single, testing::Values("eigen", "lapack", "team", "cusolver", "magma"),
                         [](const auto& id) { return id.param; });

}  // namespace
}  // namespace assur::test
