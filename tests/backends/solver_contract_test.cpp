// What backend.hpp promises, for every backend that can run here.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <map>

#include "assur/backend.hpp"
#include "backends/allocations.hpp"
#include "backends/matrices.hpp"

namespace assur::test {
namespace {

struct Case {
  const char* name;
  std::function<Matrix(Random&)> lane;  // one lane; the pattern is the same at every call
  Code expected = Code::ok;
};

Matrix scaled(Matrix a, const std::function<double(int, int)>& factor) {
  scale(a, factor);
  return a;
}
double power(int i) { return i % 2 ? 1e150 : 1e-150; }

// ---- the table: what is solved, and how it must end in every lane

const std::vector<Case>& cases() {
  static const double nan = std::numeric_limits<double>::quiet_NaN();
  static const double inf = std::numeric_limits<double>::infinity();
  static const std::vector<Case> table = {
      {"empty", [](Random& r) { return dense(0, r); }},
      {"dense1", [](Random& r) { return dense(1, r); }},
      {"dense2", [](Random& r) { return dense(2, r); }},
      {"dense3", [](Random& r) { return dense(3, r); }},
      {"dense15", [](Random& r) { return dense(15, r); }},
      {"dense40", [](Random& r) { return dense(40, r); }},
      {"dense102", [](Random& r) { return dense(102, r); }},
      {"sparse3", [](Random& r) { return sparse(3, 1, r); }},
      {"sparse15", [](Random& r) { return sparse(15, 2, r); }},
      {"sparse40", [](Random& r) { return sparse(40, 3, r); }},
      {"sparse102", [](Random& r) { return sparse(102, 4, r); }},
      {"ring24", [](Random& r) { return ring(24, r); }},
      {"ring120", [](Random& r) { return ring(120, r); }},
      {"rows_scaled", [](Random& r) { return scaled(dense(15, r), [](int i, int) { return power(i); }); }},
      {"columns_scaled", [](Random& r) { return scaled(dense(15, r), [](int, int j) { return power(j); }); }},
      {"all_tiny", [](Random& r) { return scaled(sparse(15, 2, r), [](int, int) { return 1e-150; }); }},
      {"all_huge", [](Random& r) { return scaled(sparse(15, 2, r), [](int, int) { return 1e150; }); }},
      {"graded_down", [](Random& r) { return scaled(dense(15, r), [](int i, int j) { return std::pow(8, -i - j); }); }},
      {"graded_up",
       [](Random& r) { return scaled(dense(15, r), [](int i, int j) { return std::pow(8, i + j - 28); }); }},
      {"zero_diagonal",
       [](Random& r) {
         return compress(
             15, [](int i, int j) { return i != j; }, [&](int, int) { return nonzero(r); });
       }},
      {"zero_values_on_the_diagonal",
       [](Random& r) { return scaled(dense(15, r), [](int i, int j) { return i != j; }); }},
      {"permuted_triangle", [](Random& r) { return permuted_triangle(40, 1, r); }},
      {"block_triangle", [](Random& r) { return permuted_triangle(40, 4, r); }},
      {"nearly_singular",  // condition 1e14: solvable, with a backward error like any other
       [](Random& r) { return scaled(dense(15, r), [](int i, int) { return i == 7 ? 1e-14 : 1.0; }); }},

      {"zero1",
       [](Random&) {
         return compress(
             1, [](int, int) { return true; }, [](int, int) { return 0.0; });
       },
       Code::singular},
      {"zero_row", [](Random& r) { return scaled(dense(15, r), [](int i, int) { return i != 7; }); }, Code::singular},
      {"zero_column", [](Random& r) { return scaled(sparse(15, 3, r), [](int, int j) { return j != 7; }); },
       Code::singular},
      {"repeated_row3", [](Random& r) { return repeated_row(3, r); }, Code::singular},
      {"repeated_row15", [](Random& r) { return repeated_row(15, r); }, Code::singular},
      {"empty_column",  // no pattern can be worse
       [](Random& r) {
         return compress(
             6, [](int, int j) { return j != 3; }, [&](int, int) { return nonzero(r); });
       },
       Code::singular},
      {"two_columns_share_their_only_row",
       [](Random& r) {
         return compress(
             6, [](int i, int j) { return j > 1 || i == 4; }, [&](int, int) { return nonzero(r); });
       },
       Code::singular},
      {"nan", [](Random& r) { return scaled(sparse(15, 3, r), [](int i, int) { return i == 7 ? nan : 1.0; }); },
       Code::not_finite},
      {"infinity", [](Random& r) { return scaled(sparse(15, 3, r), [](int, int j) { return j == 7 ? inf : 1.0; }); },
       Code::not_finite},
      {"nan1", [](Random& r) { return scaled(dense(1, r), [](int, int) { return nan; }); }, Code::not_finite},
  };
  return table;
}

// Sign of the determinant by another algorithm: Eigen's LU with complete pivoting.
int determinant_sign(const Matrix& a) {
  if (a.pattern.n == 0) return 1;
  Eigen::MatrixXd full = Eigen::MatrixXd::Zero(a.pattern.n, a.pattern.n);
  for (int j = 0; j < a.pattern.n; ++j) {
    for (auto k = a.pattern.column_start[static_cast<std::size_t>(j)];
         k < a.pattern.column_start[static_cast<std::size_t>(j) + 1]; ++k) {
      full(a.pattern.row[static_cast<std::size_t>(k)], j) = a.values[static_cast<std::size_t>(k)];
    }
  }
  const Eigen::FullPivLU<Eigen::MatrixXd> lu(full);
  auto sign = lu.permutationP().determinant() * lu.permutationQ().determinant();
  for (Eigen::Index i = 0; i < full.rows(); ++i) sign *= lu.matrixLU()(i, i) < 0 ? -1 : 1;
  return static_cast<int>(sign);
}

std::vector<const Backend*> available() {
  std::vector<const Backend*> rows;
  for (const Backend& backend : backends()) {
    if (backend.why_not(Shape{}, ThreadBudget{}).empty()) rows.push_back(&backend);
  }
  return rows;
}

// ---- every case x backend x lanes x right-hand sides x transposed

using Parameters = std::tuple<const Backend*, int, int, Transpose>;

class SolverContract : public testing::TestWithParam<Parameters> {};

std::vector<double> right_sides(int n, int rhs, int lanes, Random& random) {
  std::vector<double> b(static_cast<std::size_t>(n * rhs * lanes));
  for (double& element : b) element = nonzero(random);
  return b;
}

void expect_solved(const Matrix& a, std::span<const double> x, std::span<const double> b, int rhs,
                   Transpose transpose) {
  const auto n = static_cast<std::size_t>(a.pattern.n);
  for (std::size_t r = 0; r < static_cast<std::size_t>(rhs); ++r) {
    EXPECT_LE(backward_error(a, x.subspan(r * n, n), b.subspan(r * n, n), transpose), 10.0 * a.pattern.n * kEps);
  }
}

void expect_failed(const Figures& figures, std::span<const double> x) {
  EXPECT_FALSE(figures.ok);
  EXPECT_EQ(figures.determinant_sign, 0);
  EXPECT_EQ(figures.reciprocal_condition, 0);
  for (double element : x) EXPECT_TRUE(std::isnan(element));
}

void expect_healthy(const Matrix& a, const Figures& figures) {
  EXPECT_TRUE(figures.ok);
  EXPECT_GT(figures.reciprocal_condition, 0);
  EXPECT_LE(figures.reciprocal_condition, 1);
  EXPECT_GT(figures.pivot_growth, 0);
  EXPECT_LE(figures.pivot_growth, 1e4);
  EXPECT_EQ(figures.determinant_sign, determinant_sign(a));
}

TEST_P(SolverContract, EveryLaneOfEveryCaseEndsAsItMust) {
  const auto [backend, lanes, rhs, transpose] = GetParam();
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    Random random(7);
    std::vector<Matrix> matrices;
    std::vector<std::vector<double>> values;
    for (int lane = 0; lane < lanes; ++lane) values.push_back(matrices.emplace_back(c.lane(random)).values);
    const Pattern& pattern = matrices[0].pattern;
    const auto solver = backend->make(ThreadBudget{}, Precision::binary64);
    ASSERT_TRUE(solver->analyze(pattern, lanes).ok());

    // Twice: the second factorisation may take another path.
    for (int repetition = 0; repetition < 2; ++repetition) {
      EXPECT_EQ(solver->factorize(interleave(values)).code, c.expected);
      const std::vector<double> b = right_sides(pattern.n, rhs, lanes, random);
      std::vector<double> x = b;
      EXPECT_EQ(solver->solve(x, rhs, transpose).code, c.expected);
      for (int lane = 0; lane < lanes; ++lane) {
        SCOPED_TRACE(lane);
        const auto xs = lane_of(x, lanes, lane), bs = lane_of(b, lanes, lane);
        if (c.expected == Code::ok) {
          const Matrix& a = matrices[static_cast<std::size_t>(lane)];
          expect_solved(a, xs, bs, rhs, transpose);
          expect_healthy(a, solver->figures(lane));
        } else {
          expect_failed(solver->figures(lane), xs);
        }
      }
    }
  }
}

struct Name {
  std::string operator()(const testing::TestParamInfo<Parameters>& info) const {
    const auto [backend, lanes, rhs, transpose] = info.param;
    return std::string(backend->id) + "_lanes" + std::to_string(lanes) + "_rhs" + std::to_string(rhs) +
           (transpose == Transpose::yes ? "_transposed" : "");
  }
};
INSTANTIATE_TEST_SUITE_P(Backends, SolverContract,
                         testing::Combine(testing::ValuesIn(available()), testing::Values(1, 2, 4, 8),
                                          testing::Values(1, 3, 7), testing::Values(Transpose::no, Transpose::yes)),
                         Name{});

// ---- one bad lane among good ones

class OneSolver : public testing::TestWithParam<const Backend*> {
 protected:
  std::unique_ptr<LinearSolver> solver_ = GetParam()->make(ThreadBudget{}, Precision::binary64);
};

// Solutions of each lane in a pack must not depend on its neighbours, bit by bit.
TEST_P(OneSolver, ABadLaneIsNamedAndTouchesNoOther) {
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
        EXPECT_EQ(status.where, sick);
      }
      for (int lane = 0; lane < lanes; ++lane) {
        EXPECT_EQ(solver_->figures(lane).ok, lane != sick);
        const auto actual = lane_of(x, lanes, lane);
        if (lane == sick) {
          expect_failed(solver_->figures(lane), actual);
        } else {
          EXPECT_EQ(actual, lane_of(healthy, lanes, lane));
        }
      }

      x = b;  // and a good matrix heals it
      EXPECT_TRUE(solver_->factorize(interleave(values)).ok());
      EXPECT_TRUE(solver_->solve(x, 3).ok());
      expect_solved({matrices[0].pattern, values[s]}, lane_of(x, lanes, sick), lane_of(b, lanes, sick), 3,
                    Transpose::no);
    }
  }
}

TEST_P(OneSolver, NotFiniteIsWorseThanSingular) {
  Random random(1);
  const Matrix a = sparse(3, 0, random);
  auto zero = a.values, nan = a.values;
  zero[1] = 0;
  nan[1] = std::numeric_limits<double>::quiet_NaN();
  ASSERT_TRUE(solver_->analyze(a.pattern, 4).ok());
  const Status status = solver_->factorize(interleave({a.values, zero, a.values, nan}));
  EXPECT_EQ(status.code, Code::not_finite);
  EXPECT_EQ(status.where, 3);
}

// ---- the wanted unknowns only

TEST_P(OneSolver, UnknownsFromFirstWantedOnAreThoseOfTheFullSolution) {
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

TEST_P(OneSolver, AllocatesNothingAfterTheFirstFactorisation) {
  ASSERT_TRUE(GetParam()->steady);
  ASSERT_GT((std::make_unique<double>(), allocations()), 0);
  for (int n : {1, 15, 102, 360, 720}) {
    for (int lanes : {1, 2}) {
      Random random(5);
      const Matrix a = sparse(n, 2, random);
      std::vector<double> values = interleave(std::vector(static_cast<std::size_t>(lanes), a.values));
      std::vector<double> b = right_sides(n, 7, lanes, random);
      ASSERT_TRUE(solver_->analyze(a.pattern, lanes).ok());
      ASSERT_TRUE(solver_->factorize(values).ok());
      const auto before = allocations();
      for (int step = 0; step < 3; ++step) {
        for (double& value : values) value *= 1 + 1e-3 * uniform(random, -1, 1);
        ASSERT_TRUE(solver_->factorize(values).ok());
        ASSERT_TRUE(solver_->solve(b, 7).ok());
        ASSERT_TRUE(solver_->solve(b, 7, Transpose::yes).ok());
        ASSERT_TRUE(solver_->solve(b, 7, Transpose::no, n / 2).ok());
        ASSERT_TRUE(solver_->figures(lanes - 1).ok);
      }
      EXPECT_EQ(allocations() - before, 0) << "n = " << n << ", lanes = " << lanes;
    }
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
  EXPECT_EQ(solver_->solve(two, 1).code, Code::singular);  // nothing was factorised
  EXPECT_TRUE(std::isnan(two[0]) && std::isnan(two[1]));
}

INSTANTIATE_TEST_SUITE_P(Backends, OneSolver, testing::ValuesIn(available()),
                         [](const auto& row) { return std::string(row.param->id); });

}  // namespace
}  // namespace assur::test
