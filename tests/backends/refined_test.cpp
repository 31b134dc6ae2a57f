// The decorators of solvers: refinement, float with double as fallback, and the check of residuals.
#include "backends/refined.hpp"

#include <gtest/gtest.h>

#include "assur/backend.hpp"
#include "backends/allocations.hpp"
#include "backends/matrices.hpp"
#include "backends/plain_lu.hpp"

namespace assur::test {
namespace {

std::vector<double> right_sides(std::size_t size, Random& random) {
  std::vector<double> b(size);
  for (double& element : b) element = nonzero(random);
  return b;
}

// The result of solving for one right-hand side in one lane, or in each of several lanes.
struct Solution {
  Status status;
  double componentwise, normwise;  // largest errors of all lanes
};
Solution solve(LinearSolver& solver, const std::vector<Matrix>& lanes, Transpose transpose = Transpose::no,
               int rhs = 1) {
  const int w = static_cast<int>(lanes.size());
  const auto n = static_cast<std::size_t>(lanes[0].pattern.n);
  std::vector<std::vector<double>> values;
  for (const Matrix& a : lanes) values.push_back(a.values);
  EXPECT_TRUE(solver.analyze(lanes[0].pattern, w).ok());
  (void)solver.factorize(interleave(values));
  Random random(3);
  const auto b = right_sides(n * lanes.size() * static_cast<std::size_t>(rhs), random);
  auto x = b;
  Solution result{solver.solve(x, rhs, transpose, 0), 0, 0};
  for (int lane = 0; lane < w; ++lane) {
    const auto xs = lane_of(x, w, lane), bs = lane_of(b, w, lane);
    for (std::size_t r = 0; r < static_cast<std::size_t>(rhs); ++r) {
      const auto xr = std::span(xs).subspan(r * n, n), br = std::span(bs).subspan(r * n, n);
      const Matrix& a = lanes[static_cast<std::size_t>(lane)];
      result.componentwise = std::max(result.componentwise, componentwise_error(a, xr, br, transpose));
      result.normwise = std::max(result.normwise, backward_error(a, xr, br, transpose));
    }
  }
  return result;
}

std::unique_ptr<LinearSolver> plain() { return kPlainLu.make({}, Precision::binary64); }
std::unique_ptr<LinearSolver> refine() { return make_solver(kPlainLu, {}, Precision::binary64, true); }
std::unique_ptr<LinearSolver> in_float(bool refine = false) {
  return make_solver(kPlainLu, {}, Precision::binary32, refine);
}

TEST(Refined, RepairsSolutionsAfterPivotGrowth) {
  const Matrix a = wilkinson(60);
  EXPECT_GT(solve(*plain(), {a}).normwise, 1e-6);  // growth of 2^59
  for (Transpose transpose : {Transpose::no, Transpose::yes}) {
    const auto solver = refine();
    const Solution repaired = solve(*solver, {a}, transpose);
    EXPECT_TRUE(repaired.status.ok());
    EXPECT_LE(repaired.componentwise, 61 * kEps);
    EXPECT_LE(solver->effort().refined, 3);  // Skeel: one step mostly suffices
  }
}

TEST(Refined, FloatReachesDoubleAccuracyAtModerateCondition) {
  Random random(8);
  for (int lanes : {1, 2, 3, 8}) {
    for (Transpose transpose : {Transpose::no, Transpose::yes}) {
      std::vector<Matrix> matrices;
      for (int lane = 0; lane < lanes; ++lane) matrices.push_back(sparse(15, 3, random));
      const auto solver = in_float();
      const Solution solution = solve(*solver, matrices, transpose, 6);
      EXPECT_TRUE(solution.status.ok());
      EXPECT_LE(solution.normwise, 16 * kEps);
      EXPECT_EQ(solver->effort().in_double, 0);
      EXPECT_GE(solver->effort().refined, lanes * 6);  // float alone has 1e-7
      EXPECT_LE(solver->effort().refined, lanes * 6 * 4);
    }
  }
}

TEST(Refined, FactorisesOnlyFailedFloatLanesInDouble) {
  Random random(8);
  const Matrix good = dense(12, random);
  Matrix overflows = good, vanishes = good;
  scale(overflows, [](int, int) { return 1e50; });
  scale(vanishes, [](int, int) { return 1e-50; });
  Matrix ill = hilbert(12);  // condition 1e16
  const std::vector<Matrix> lanes = {good, overflows, ill, vanishes, good};
  for (bool componentwise : {false, true}) {
    const auto solver = in_float(componentwise);
    const Solution solution = solve(*solver, lanes, Transpose::no, 5);
    EXPECT_TRUE(solution.status.ok());
    EXPECT_LE(solution.normwise, 120 * kEps);
    EXPECT_EQ(solver->effort().in_double, 3);
    EXPECT_LE(solution.componentwise, componentwise ? 14 * kEps : 1);
    std::vector<double> x(12 * 5, 1.0);
    EXPECT_TRUE(solver->solve(x, 1, Transpose::no, 0).ok());
    EXPECT_EQ(solver->effort().in_double, 3);  // one for each lane that float cannot factorise
  }
}

TEST(Refined, ALaneDoesNotDependOnItsNeighbours) {
  Random random(5);
  const Matrix a = dense(9, random), ill = hilbert(9);
  for (const auto& make : {+[] { return refine(); }, +[] { return in_float(); }}) {
    const auto alone = make(), beside = make();
    ASSERT_TRUE(alone->analyze(a.pattern, 1).ok());
    ASSERT_TRUE(alone->factorize(a.values).ok());
    ASSERT_TRUE(beside->analyze(a.pattern, 2).ok());
    ASSERT_TRUE(beside->factorize(interleave({ill.values, a.values})).ok());
    const auto b = right_sides(9, random);
    auto x = b, both = interleave({b, b});
    ASSERT_TRUE(alone->solve(x, 1, Transpose::no, 0).ok());
    ASSERT_TRUE(beside->solve(both, 1, Transpose::no, 0).ok());
    EXPECT_EQ(lane_of(both, 2, 1), x);
  }
}

TEST(Refined, KeepsStatusSingularAndNotFinite) {
  Random random(5);
  const Matrix good = dense(5, random), singular = repeated_row(5, random);
  Matrix nan = good;
  nan.values[7] = std::numeric_limits<double>::quiet_NaN();
  for (const auto& make : {+[] { return refine(); }, +[] { return in_float(); }}) {
    const auto solver = make();
    ASSERT_TRUE(solver->analyze(good.pattern, 3).ok());
    const Status one = solver->factorize(interleave({good.values, singular.values, good.values}));
    EXPECT_EQ(one.code, Code::singular);
    EXPECT_EQ(one.where, Place::lane(1));
    const Status worse = solver->factorize(interleave({good.values, singular.values, nan.values}));
    EXPECT_EQ(worse.code, Code::not_finite);
    EXPECT_EQ(worse.where, Place::lane(2));
    std::vector<double> x(15, 1.0);
    EXPECT_EQ(solver->solve(x, 1, Transpose::no, 0).code, Code::not_finite);
    EXPECT_TRUE(std::isfinite(x[0]));
    EXPECT_TRUE(std::isnan(x[1]) && std::isnan(x[2]));
  }
}

// The last two equations make two unknowns vanish, but the pivots come from other equations, so that rounding errors
// remain. In the last two rows a componentwise error of 1 is not a failure.
TEST(Refined, VanishingUnknownsRaiseNoAlarm) {
  Random random(5);
  int errors_of_one = 0;
  for (int trial = 0; trial < 50; ++trial) {
    const Matrix a = compress(
        6, [](int i, int j) { return i < 4 || j < 2; },
        [&](int i, int) { return i < 4 ? nonzero(random) : 0.1 * nonzero(random); });
    const auto solver = refine();
    ASSERT_TRUE(solver->analyze(a.pattern, 1).ok());
    ASSERT_TRUE(solver->factorize(a.values).ok());
    const std::vector<double> b = {nonzero(random), nonzero(random), nonzero(random), nonzero(random), 0, 0};
    std::vector<double> x = b;
    EXPECT_TRUE(solver->solve(x, 1, Transpose::no, 0).ok());
    EXPECT_LE(backward_error(a, x, b), 7 * kEps);
    errors_of_one += componentwise_error(a, x, b) > 0.1;
  }
  EXPECT_GT(errors_of_one, 0);
}

// A solver with errors in the first digit, which refinement cannot repair and the check has to find.
class Wrong final : public LinearSolver {
 public:
  explicit Wrong(double factor) : factor_(factor) {}
  Status analyze(const Pattern& pattern, int lanes) override { return right_.analyze(pattern, lanes); }
  Status factorize(std::span<const double> values) override { return right_.factorize(values); }
  Status solve(std::span<double> x, int rhs, Transpose transpose, int) override {
    const Status status = right_.solve(x, rhs, transpose, 0);
    for (double& element : x) element *= factor_;
    return status;
  }
  [[nodiscard]] Figures figures(int lane) const override { return right_.figures(lane); }

 private:
  PlainLu<double> right_;
  double factor_;
};

TEST(Refined, TheResidualCheckSeesAWrongSolution) {
  Random random(5);
  Matrix a = dense(9, random);
  // The largest entry of each row and column is 1, so that the residual needs no scaling.
  const double largest = std::abs(*std::max_element(a.values.begin(), a.values.end(),
                                                    [](double x, double y) { return std::abs(x) < std::abs(y); }));
  for (double& value : a.values) value /= 2 * largest;
  for (std::size_t i = 0; i < 9; ++i) a.values[9 * i + i] = 1;
  EXPECT_TRUE(solve(*checked(plain()), {a, a, a}).status.ok());
  for (double factor : {1 + 1e-10, 0.5, -1.0}) {
    const Solution solution = solve(*checked(std::make_unique<Wrong>(factor)), {a}, Transpose::no, 5);
    EXPECT_EQ(solution.status.code, Code::not_converged);
    EXPECT_EQ(solution.status.where, Place::lane(0));
    EXPECT_NEAR(solution.status.figure, solution.normwise, 10 * 9 * kEps);  // residuals in different precisions
  }
  const Solution infinite = solve(*checked(std::make_unique<Wrong>(HUGE_VAL)), {a, a, a});
  EXPECT_EQ(infinite.status.code, Code::not_converged);
}

// In all units of rows and columns, no row of a solution in float is worse than in double.
TEST(Refined, ChecksSmallRowsBesideLargeRows) {
  Random random(8);
  Matrix a = dense(12, random);
  for (std::size_t j = 0; j < 12; ++j) {
    for (std::size_t i = 0; i < 12; ++i)
      a.values[12 * j + i] = std::ldexp(a.values[12 * j + i], 2 * static_cast<int>(i + j));
  }
  const Solution solution = solve(*make_solver(kPlainLu, {}, Precision::binary32, false), {a});
  EXPECT_TRUE(solution.status.ok());
  EXPECT_LE(solution.componentwise, 12 * kEps);
}

TEST(Refined, ReportsNotConvergedIfRefinementFails) {
  static constexpr Backend kWrong = {.id = "wrong",
                                     .why_not = kPlainLu.why_not,
                                     .make = [](ThreadBudget, Precision) -> std::unique_ptr<LinearSolver> {
                                       return std::make_unique<Wrong>(3.0);  // each correction makes it worse
                                     },
                                     .version = kPlainLu.version,
                                     .licence = "Apache-2.0",
                                     .single = true,
                                     .steady = true};
  Random random(5);
  const Solution solution = solve(*make_solver(kWrong, {}, Precision::binary64, true), {dense(9, random)});
  EXPECT_EQ(solution.status.code, Code::not_converged);
  EXPECT_GT(solution.status.figure, 0.1);
}

// Accepts every matrix, but solves none.
class Optimist final : public LinearSolver {
 public:
  Status analyze(const Pattern&, int) override { return {}; }
  Status factorize(std::span<const double>) override { return {}; }
  Status solve(std::span<double>, int, Transpose, int) override { return {}; }
  [[nodiscard]] Figures figures(int) const override { return {true, 1, 1, 1}; }
};

// Only the solution shows that float fails. Double then finds that the matrix is singular.
TEST(Refined, FiguresOfAnUnsolvableLaneReportIt) {
  Backend row = kPlainLu;
  row.make = [](ThreadBudget budget, Precision precision) -> std::unique_ptr<LinearSolver> {
    if (precision == Precision::binary32) return std::make_unique<Optimist>();
    return kPlainLu.make(budget, precision);
  };
  Random random(5);
  const Matrix singular = repeated_row(3, random), regular = dense(3, random);
  const auto solver = make_solver(row, {}, Precision::binary32, false);
  ASSERT_TRUE(solver->analyze(regular.pattern, 2).ok());
  ASSERT_TRUE(solver->factorize(interleave({regular.values, singular.values})).ok());
  std::vector<double> x = {1, 1, 2, 2, 3, 3};
  const Status status = solver->solve(x, 1);
  EXPECT_EQ(status.code, Code::singular);
  EXPECT_EQ(status.where, Place::lane(1));
  EXPECT_TRUE(std::isnan(x[1]));
  EXPECT_FALSE(solver->figures(1).ok);
  EXPECT_TRUE(std::isfinite(x[0]));
  EXPECT_TRUE(solver->figures(0).ok);
}

TEST(Refined, RefusesFloatForBackendsWithoutFloat) {
  Backend row = kPlainLu;
  row.single = false;
  try {
    (void)make_solver(row, {}, Precision::binary32, false);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::environment);
    EXPECT_STREQ(error.what(), "backend plain_lu cannot factorise in float: leave out +float");
  }
}

TEST(Refined, AllocatesNothingAfterTheAnalysis) {
  Random random(5);
  const Matrix a = dense(12, random), ill = hilbert(12);
  const auto both = interleave({a.values, ill.values});
  for (const auto& make : {+[] { return refine(); }, +[] { return in_float(); }, +[] { return checked(plain()); }}) {
    const auto solver = make();
    ASSERT_TRUE(solver->analyze(a.pattern, 2).ok());
    std::vector<double> x = right_sides(12 * 7 * 2, random);
    const auto before = allocations();
    for (Transpose transpose : {Transpose::no, Transpose::yes}) {
      ASSERT_TRUE(solver->factorize(both).ok());
      ASSERT_TRUE(solver->solve(x, 7, transpose, 0).ok());
    }
    EXPECT_EQ(allocations(), before);
  }
}

}  // namespace
}  // namespace assur::test
