// The work of a block of `factor` and `solve`, and the solvers that are never timed.
#include "measure/linear.hpp"
#include "numbers.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace assur::measure {
namespace {

struct Calls {
  int analyses = 0, factorizations = 0, solutions = 0;
};
Calls calls;
double factor_of_results = 1;  // 1, or the factor by which results are wrong
Code code_of_factorizations = Code::ok;

// Forwards all calls to another solver and counts them.
class Counting final : public LinearSolver {
 public:
  explicit Counting(std::unique_ptr<LinearSolver> solver) : solver_(std::move(solver)) {}
  Status analyze(const Pattern& pattern, int lanes) override {
    ++calls.analyses;
    return solver_->analyze(pattern, lanes);
  }
  Status factorize(std::span<const double> values) override {
    ++calls.factorizations;
    if (code_of_factorizations != Code::ok) return {code_of_factorizations, {}, 0};
    return solver_->factorize(values);
  }
  Status solve(std::span<double> b_to_x, int rhs, Transpose transpose, int first_wanted) override {
    ++calls.solutions;
    const Status s = solver_->solve(b_to_x, rhs, transpose, first_wanted);
    for (double& x : b_to_x) x *= factor_of_results;
    return s;
  }
  Figures figures(int lane) const override { return solver_->figures(lane); }

 private:
  std::unique_ptr<LinearSolver> solver_;
};

Backend counting() {
  Backend row = find_backend(backends(), "lanes");
  row.make = [](ThreadBudget budget, Precision precision) -> std::unique_ptr<LinearSolver> {
    return std::make_unique<Counting>(find_backend(backends(), "lanes").make(budget, precision));
  };
  return row;
}

class LinearTest : public testing::Test {
 protected:
  LinearTest() {
    calls = {};
    factor_of_results = 1;
    code_of_factorizations = Code::ok;
  }
  const Matrices matrices_ = random_matrices(30, 4, 3);
  const Backend counting_ = counting();
  Strategy strategy_ = parse_strategy("groups/lanes:4");
};

TEST_F(LinearTest, ABlockCountsFactorisationsOrSolutions) {
  Linear linear(matrices_, strategy_, counting_);
  EXPECT_EQ(linear.refused(), "");
  EXPECT_EQ(calls.analyses, 1);
  Calls before = calls;
  EXPECT_TRUE(linear.factor().run(7));
  EXPECT_EQ(calls.factorizations - before.factorizations, 7);
  EXPECT_EQ(calls.solutions, before.solutions);
  before = calls;
  EXPECT_TRUE(linear.solve().run(5));
  EXPECT_EQ(calls.solutions - before.solutions, 5);
  EXPECT_EQ(calls.factorizations, before.factorizations);
  EXPECT_EQ(calls.analyses, 1);
}

TEST_F(LinearTest, ReportsTheErrorsOfItsSolutions) {
  const Linear linear(matrices_, strategy_, counting_);
  // Higham, Accuracy and Stability, theorem 9.4: 3 n eps |L| |U|; growth is small for large diagonals.
  EXPECT_GT(linear.backward_error(), 0);
  EXPECT_LE(linear.backward_error(), 3 * 30 * kEps);
  EXPECT_GT(linear.forward_error(), 0);

  factor_of_results = 1 + 1e-9;
  const Linear off(matrices_, strategy_, counting_);
  EXPECT_EQ(off.refused(), "");
  EXPECT_NEAR(off.forward_error(), 1e-9, 1e-10);
  EXPECT_LE(off.backward_error(), 1e-9);
  EXPECT_GE(off.backward_error(), 1e-11);
}

TEST_F(LinearTest, RefusesWrongSolutions) {
  factor_of_results = 1.001;
  EXPECT_NE(Linear(matrices_, strategy_, counting_).refused().find("its backward error is"), std::string::npos);
  factor_of_results = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(Linear(matrices_, strategy_, counting_).refused(), "");
  factor_of_results = 1;
  code_of_factorizations = Code::singular;
  EXPECT_EQ(Linear(matrices_, strategy_, counting_).refused(), "its status is singular");
}

TEST(Matrices, AreRegularForEveryPattern) {
  for (const auto& [n, per_row] : {std::pair(1, 1), {2, 2}, {40, 6}, {40, 40}}) {
    const Matrices m = random_matrices(n, per_row, 2);
    ASSERT_EQ(m.values.size(), 2u);
    EXPECT_EQ(m.pattern.nnz(), n * per_row);
    EXPECT_EQ(m.values[0].size(), m.pattern.row.size());
    EXPECT_NE(m.values[0], m.values[1]);
    const Linear linear(m, parse_strategy("groups/eigen"), find_backend(backends(), "eigen"));
    EXPECT_EQ(linear.refused(), "");
    // The diagonal is twice the spectral radius of the rest, so conditions are about (2 + 1) / (2 - 1) for entries of
    // similar size.
    EXPECT_LE(linear.forward_error(), 100 * n * kEps);
  }
}

TEST(Matrices, JacobiansEqualThoseOfTheGroups) {
  const GroupedSystem s = group_equations(sample("stewart"));
  const std::int32_t legs = s.groups.back().group_class;
  const Matrices m = jacobians(s, legs, 4);
  EXPECT_EQ(m.pattern.n, 15);
  ASSERT_EQ(m.values.size(), 4u);
  EXPECT_NE(m.values[0], m.values[1]);
  const Linear linear(m, parse_strategy("groups/lanes:4"), find_backend(backends(), "lanes"));
  EXPECT_EQ(linear.refused(), "");
}

}  // namespace
}  // namespace assur::measure
