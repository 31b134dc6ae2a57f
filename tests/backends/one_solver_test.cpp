// Contracts of backend.hpp besides the table of matrices: independent lanes, wanted unknowns, steady state, misuse.
#include <gtest/gtest.h>

#include <map>
#include <thread>

#include "assur/backend.hpp"
#include "backends/allocations.hpp"
#include "backends/available.hpp"
#include "backends/contract_cases.hpp"
#include "backends/matrices.hpp"

namespace assur::test {
namespace {

// ---- one bad lane among good ones

class OneSolver : public testing::TestWithParam<const Backend*> {
 protected:
  std::unique_ptr<LinearSolver> solver_ = GetParam()->make(ThreadBudget{}, Precision::binary64);
};

// The solution in a lane must not depend on its neighbours, bit by bit.
TEST_P(OneSolver, NamesABadLaneAndKeepsTheOthers) {
  const int lanes = 4, n = 15;
  const std::map<double, Code> bad = {{0.0, Code::singular},
                                      {std::numeric_limits<double>::quiet_NaN(), Code::not_finite}};
  for (const auto& [row_factor, code] : bad) {
    for (int sick = 0; sick < lanes; ++sick) {
      Random random(3);
      std::vector<std::vector<double>> values;
      std::vector<Matrix> matrices;
      for (int lane = 0; lane < lanes; ++lane) values.push_back(matrices.emplace_back(sparse(n, 3, random)).values);
      const std::vector<double> b = right_sides(n, 3, lanes, random);
      ASSERT_TRUE(solver_->analyze(matrices[0].pattern, lanes).ok());
      ASSERT_TRUE(solver_->factorize(interleave(values)).ok());
      std::vector<double> healthy = b;
      ASSERT_TRUE(solver_->solve(healthy, 3).ok());

      const auto s = static_cast<std::size_t>(sick);
      const double factor = row_factor;
      scale(matrices[s], [&](int i, int) { return i == 4 ? factor : 1.0; });
      auto with_bad = values;
      with_bad[s] = matrices[s].values;
      std::vector<double> x = b;
      for (const Status status : {solver_->factorize(interleave(with_bad)), solver_->solve(x, 3)}) {
        EXPECT_EQ(status.code, code);
        EXPECT_EQ(status.where, Place::lane(sick));
      }
      for (int lane = 0; lane < lanes; ++lane) {
        EXPECT_EQ(solver_->figures(lane).ok, lane != sick);
        const auto actual = lane_of(x, lanes, lane);
        if (lane == sick) {
          EXPECT_EQ(solver_->figures(lane).determinant_sign, 0);
          for (double element : actual) EXPECT_TRUE(std::isnan(element));
        } else {
          EXPECT_EQ(actual, lane_of(healthy, lanes, lane));
        }
      }

      x = b;  // after a good matrix the lane is solved again
      EXPECT_TRUE(solver_->factorize(interleave(values)).ok());
      EXPECT_TRUE(solver_->solve(x, 3).ok());
      const auto xs = lane_of(x, lanes, sick), bs = lane_of(b, lanes, sick);
      for (std::size_t r = 0; r < xs.size(); r += n) {
        const auto xr = std::span(xs).subspan(r, n), br = std::span(bs).subspan(r, n);
        EXPECT_LE(backward_error({matrices[0].pattern, values[s]}, xr, br), 10 * n * kEps);
      }
    }
  }
}

TEST_P(OneSolver, ReportsNotFiniteBeforeSingular) {
  Random random(1);
  const Matrix a = sparse(3, 0, random);
  auto zero = a.values, nan = a.values;
  zero[1] = 0;
  nan[1] = std::numeric_limits<double>::quiet_NaN();
  ASSERT_TRUE(solver_->analyze(a.pattern, 4).ok());
  const Status status = solver_->factorize(interleave({a.values, zero, a.values, nan}));
  EXPECT_EQ(status.code, Code::not_finite);
  EXPECT_EQ(status.where, Place::lane(3));
}

// ---- the wanted unknowns only

TEST_P(OneSolver, WantedUnknownsEqualTheFullSolution) {
  for (int n : {1, 7, 15, 40}) {
    Random random(5);
    const Matrix a = sparse(n, 3, random);  // condition below 100
    const std::vector<double> b = right_sides(n, 2, 2, random);
    ASSERT_TRUE(solver_->analyze(a.pattern, 2).ok());
    ASSERT_TRUE(solver_->factorize(interleave({a.values, a.values})).ok());
    std::vector<double> full = b;
    ASSERT_TRUE(solver_->solve(full, 2).ok());
    for (int first = 0; first < n; ++first) {
      std::vector<double> x = b;
      ASSERT_TRUE(solver_->solve(x, 2, Transpose::no, first).ok());
      for (int r = 0; r < 2; ++r) {
        for (int i = (r * n + first) * 2; i < (r + 1) * n * 2; ++i) {
          EXPECT_NEAR(x[static_cast<std::size_t>(i)], full[static_cast<std::size_t>(i)], 100 * n * kEps);
        }
      }
    }
  }
}

// ---- the steady state

void expect_allocations(const Backend& row, ThreadBudget budget, int n, int lanes) {
  Random random(5);
  const Matrix a = sparse(n, 2, random);
  std::vector<double> values = interleave(std::vector(static_cast<std::size_t>(lanes), a.values));
  std::vector<double> b = right_sides(n, 7, lanes, random);
  const auto solver = row.make(budget, Precision::binary64);
  ASSERT_TRUE(solver->analyze(a.pattern, lanes).ok());
  ASSERT_TRUE(solver->factorize(values).ok());
  for (int i = 0; i < 2 && budget.threads > 1; ++i) {  // until each thread has worked
    ASSERT_TRUE(solver->solve(b, 7).ok());
    ASSERT_TRUE(solver->factorize(values).ok());
  }
  const auto before = allocations();
  for (int step = 0; step < 3; ++step) {
    for (double& value : values) value *= 1 + 1e-3 * uniform(random, -1, 1);
    ASSERT_TRUE(solver->factorize(values).ok());
    ASSERT_TRUE(solver->solve(b, 7).ok());
    ASSERT_TRUE(solver->solve(b, 7, Transpose::yes).ok());
    ASSERT_TRUE(solver->solve(b, 7, Transpose::no, n / 2).ok());
    ASSERT_TRUE(solver->figures(lanes - 1).ok);
  }
  if (row.device) return;  // its libraries may allocate where this test cannot count
  EXPECT_EQ(allocations() == before, row.steady)
      << "n = " << n << ", lanes = " << lanes << ", " << budget.threads << " threads";
}

TEST_P(OneSolver, AllocatesInSteadyStateOnlyIfNotDeclaredSteady) {
  ASSERT_GT((std::make_unique<double>(), allocations()), 0);
  const Backend& row = *GetParam();
  for (int n : {1, 15, 102, 360, 433, 720}) {
    for (int lanes : {1, 2}) expect_allocations(row, {1}, n, lanes);
    if (row.why_not({}, {2}).empty()) expect_allocations(row, {2}, n, 1);
  }
}

// ---- several callers

TEST_P(OneSolver, ConcurrentCallersGetTheSameResultsAsAlone) {
  constexpr std::size_t kCallers = 3;
  const auto work = [](std::size_t caller, bool& ok) {
    Random random(caller);
    std::vector<double> all;
    for (int i = 0; i < 10; ++i) {
      const int n = 30 + static_cast<int>(caller) + 10 * i;
      const Matrix a = sparse(n, 3, random);
      std::vector<double> x = right_sides(n, 1, 1, random);
      const auto solver = GetParam()->make(ThreadBudget{}, Precision::binary64);
      ok = ok && solver->analyze(a.pattern, 1).ok() && solver->factorize(a.values).ok() && solver->solve(x, 1).ok();
      all.insert(all.end(), x.begin(), x.end());
    }
    return all;
  };
  std::vector<double> together[kCallers];
  bool ok[kCallers] = {true, true, true};
  std::vector<std::thread> callers;
  for (std::size_t c = 0; c < kCallers; ++c) {
    callers.emplace_back([&, c] {
      try {
        together[c] = work(c, ok[c]);
      } catch (const Error&) {
        ok[c] = false;
      }
    });
  }
  for (std::thread& caller : callers) caller.join();
  for (std::size_t c = 0; c < kCallers; ++c) {
    EXPECT_TRUE(ok[c]);
    EXPECT_EQ(together[c], work(c, ok[c]));
  }
}

// ---- misuse

std::string message(const std::function<void()>& misuse) {
  try {
    misuse();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST_P(OneSolver, RefusesMisuse) {
  const auto analyze = [&](Pattern pattern, int lanes) {
    return message([&] { (void)solver_->analyze(pattern, lanes); });
  };
  EXPECT_EQ(analyze({1, {0, 1}, {0}}, 0), "a solver needs at least one lane, not 0");
  EXPECT_EQ(analyze({2, {0, 1}, {0}}, 1), "a pattern needs n + 1 column starts, not 2 for n = 2");
  EXPECT_EQ(analyze({1, {0, 2}, {0}}, 1), "the column starts of a pattern must ascend from 0 to its 1 nonzeros");
  EXPECT_EQ(analyze({2, {0, 2, 3}, {0, 0, 1}}, 1), "the rows of column 0 of a pattern must ascend within 0 to n - 1");
  EXPECT_EQ(analyze({2, {0, 1, 2}, {0, 2}}, 1), "the rows of column 1 of a pattern must ascend within 0 to n - 1");

  ASSERT_TRUE(solver_->analyze({1, {0, 1}, {0}}, 2).ok());
  std::vector<double> three(3, 1.0), two(2, 2.0);
  EXPECT_EQ(message([&] { (void)solver_->factorize(three); }), "a solver expects 2 values, not 3");
  EXPECT_EQ(message([&] { (void)solver_->solve(three, 1); }),
            "a solver expects 2 numbers on the right-hand side, not 3");
  EXPECT_EQ(solver_->solve(two, 1).code, Code::singular);  // no matrix was factorised
  EXPECT_TRUE(std::isnan(two[0]) && std::isnan(two[1]));
}

INSTANTIATE_TEST_SUITE_P(Backends, OneSolver, testing::ValuesIn(available()),
                         [](const auto& row) { return std::string(row.param->id); });

}  // namespace
}  // namespace assur::test
