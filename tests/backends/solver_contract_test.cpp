// The contract of backend.hpp for every backend that runs here: the table of contract_cases.cpp, plain and decorated.
#include <gtest/gtest.h>

#include <initializer_list>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "assur/backend.hpp"
#include "backends/available.hpp"
#include "backends/contract_cases.hpp"
#include "backends/matrices.hpp"
#include "backends/refined.hpp"
#include "decompositions.hpp"

namespace assur::test {
namespace {

// Computes the sign of the determinant with another algorithm, Eigen's LU with complete pivoting.
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

enum class Mode { plain, refine, in_float, in_float_refine };

bool refines(Mode mode) { return mode == Mode::refine || mode == Mode::in_float_refine; }
Precision precision(Mode mode) {
  return mode == Mode::plain || mode == Mode::refine ? Precision::binary64 : Precision::binary32;
}

using Parameters = std::tuple<const Backend*, Mode, int>;

class SolverContract : public testing::TestWithParam<Parameters> {
 protected:
  void check_case(const Case& c);
  void check_solution(const Case& c, int rhs, Transpose transpose, Status factorized);
  void check_lane(const Case& c, int lane, std::span<const double> x, std::span<const double> b, Transpose transpose);
  void check_figures(const Case& c, int lane);

  const Backend& backend_ = *std::get<0>(GetParam());
  const Mode mode_ = std::get<1>(GetParam());
  const int lanes_ = std::get<2>(GetParam());
  Random random_{7};
  std::unique_ptr<LinearSolver> solver_;
  std::vector<Matrix> matrices_;  // lanes
};

TEST_P(SolverContract, EveryLaneOfEveryCaseHasTheExpectedStatus) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    check_case(c);
  }
}

// After restart(), a solver gives the bits of a new one, whatever it solved before.
TEST_P(SolverContract, ARestartedSolverIsANewOne) {
  int restarted = 0;
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    std::vector<std::vector<double>> values, others;
    Matrix matrix;
    for (int lane = 0; lane < lanes_; ++lane) {
      matrix = c.lane(random_);
      values.push_back(matrix.values);
      others.push_back(c.lane(random_).values);
    }
    const std::vector<double> b = right_sides(matrix.pattern.n, 2, lanes_, random_);
    std::vector<std::vector<double>> solutions;
    for (const bool used : {false, true}) {
      solver_ = make_solver(backend_, ThreadBudget{}, precision(mode_), refines(mode_));
      ASSERT_TRUE(solver_->analyze(matrix.pattern, lanes_).ok());
      if (used) {
        for (int k = 0; k < 3; ++k) (void)solver_->factorize(interleave(others));
        if (!solver_->restart()) break;  // a new solver is needed
        ++restarted;
      }
      const Status s = solver_->factorize(interleave(values));
      std::vector<double>& x = solutions.emplace_back(b);
      if (!s.ok() || !solver_->solve(x, 2).ok()) x.assign(1, static_cast<double>(s.code));
      x.push_back(static_cast<double>(solver_->effort().redone));
    }
    if (solutions.size() == 2) {
      EXPECT_EQ(solutions[0], solutions[1]);
    }
  }
  EXPECT_EQ(restarted > 0, backend_.id == "lanes" && mode_ == Mode::plain);
}

void SolverContract::check_case(const Case& c) {
  std::vector<std::vector<double>> values;
  matrices_.clear();
  for (int lane = 0; lane < lanes_; ++lane) values.push_back(matrices_.emplace_back(c.lane(random_)).values);
  solver_ = make_solver(backend_, ThreadBudget{}, precision(mode_), refines(mode_));
  ASSERT_TRUE(solver_->analyze(matrices_[0].pattern, lanes_).ok());
  for (int repetition = 0; repetition < 2; ++repetition) {  // the second factorisation may take another path
    const Status factorized = solver_->factorize(interleave(values));
    switch (c.expected(backend_.id)) {
      case Outcome::solved:
      case Outcome::grows:
        EXPECT_EQ(factorized.code, Code::ok);
        break;
      case Outcome::singular:
        EXPECT_EQ(factorized.code, Code::singular);
        break;
      case Outcome::not_finite:
        EXPECT_EQ(factorized.code, Code::not_finite);
        break;
      case Outcome::either:
        EXPECT_TRUE(factorized.ok() || factorized.code == Code::singular);
        break;
    }
    for (Transpose transpose : {Transpose::no, Transpose::yes}) {
      for (int rhs : {1, 3, 7}) check_solution(c, rhs, transpose, factorized);
    }
    for (int lane = 0; lane < lanes_; ++lane) check_figures(c, lane);
  }
}

void SolverContract::check_solution(const Case& c, int rhs, Transpose transpose, Status factorized) {
  SCOPED_TRACE(std::to_string(rhs) + " right-hand sides" + (transpose == Transpose::yes ? ", transposed" : ""));
  const std::vector<double> b = right_sides(matrices_[0].pattern.n, rhs, lanes_, random_);
  std::vector<double> x = b;
  const Status solved = solver_->solve(x, rhs, transpose);
  if (c.expected(backend_.id) == Outcome::either && solved.code == Code::singular) factorized = solved;
  EXPECT_EQ(solved.code, factorized.code) << solved.figure;
  for (int lane = 0; lane < lanes_; ++lane) {
    SCOPED_TRACE("lane " + std::to_string(lane));
    check_lane(c, lane, lane_of(x, lanes_, lane), lane_of(b, lanes_, lane), transpose);
  }
}

void SolverContract::check_lane(const Case& c, int lane, std::span<const double> x, std::span<const double> b,
                                Transpose transpose) {
  if (!solver_->figures(lane).ok) {
    for (double element : x) EXPECT_TRUE(std::isnan(element));
    return;
  }
  if (c.expected(backend_.id) == Outcome::grows && !refines(mode_)) return;
  const Matrix& a = matrices_[static_cast<std::size_t>(lane)];
  const auto n = static_cast<std::size_t>(a.pattern.n);
  const double bound = 10.0 * a.pattern.n * kEps;
  for (std::size_t r = 0; r < x.size(); r += n) {
    const auto xr = x.subspan(r, n), br = b.subspan(r, n);
    EXPECT_LE(backward_error(a, xr, br, transpose), bound);
    if (refines(mode_)) {
      EXPECT_LE(componentwise_error(a, xr, br, transpose), bound);
    }
  }
}

void SolverContract::check_figures(const Case& c, int lane) {
  const Figures figures = solver_->figures(lane);
  const Outcome expected = c.expected(backend_.id);
  if (expected != Outcome::either) {
    EXPECT_EQ(figures.ok, expected == Outcome::solved || expected == Outcome::grows);
  }
  if (!figures.ok) {
    EXPECT_EQ(figures.determinant_sign, 0);
    EXPECT_EQ(figures.reciprocal_condition, 0);
    return;
  }
  if (precision(mode_) == Precision::binary32) return;  // these figures may be those of float
  const Told told = told_by(backend_.id);
  if (told.condition) {
    EXPECT_GT(figures.reciprocal_condition, 0);
    EXPECT_LE(figures.reciprocal_condition, 1);
  }
  if (told.growth && expected == Outcome::solved) {
    EXPECT_GT(figures.pivot_growth, 0);
    EXPECT_LE(figures.pivot_growth, 1e4);
  }
  if (told.partial_pivoting) {
    EXPECT_GE(figures.pivot_growth, c.growth);
  }
  if (told.sign && c.condition <= 1e10) {
    EXPECT_EQ(figures.determinant_sign, determinant_sign(matrices_[static_cast<std::size_t>(lane)]));
  }
}

std::vector<const Backend*> with_float() {
  std::vector<const Backend*> rows;
  for (const Backend* backend : available()) {
    if (backend->single) rows.push_back(backend);
  }
  return rows;
}

struct Name {
  std::string operator()(const testing::TestParamInfo<Parameters>& info) const {
    const auto [backend, mode, lanes] = info.param;
    const char* const decorated[] = {"", "_refine", "_float", "_float_refine"};
    return std::string(backend->id) + decorated[static_cast<int>(mode)] + "_lanes" + std::to_string(lanes);
  }
};
// MUMPS solves lane by lane and allocates a megabyte for each solution: 16 lanes take minutes with the sanitizers.
std::vector<Parameters> each_lane(const std::vector<const Backend*>& of, std::initializer_list<Mode> modes) {
  std::vector<Parameters> rows;
  for (const Backend* backend : of) {
    const int most = std::string_view(backend->id).find("mumps") == std::string_view::npos ? 16 : 4;
    for (const Mode mode : modes) {
      for (int lanes = 1; lanes <= most; lanes *= 2) rows.emplace_back(backend, mode, lanes);
    }
  }
  return rows;
}

INSTANTIATE_TEST_SUITE_P(Double, SolverContract, testing::ValuesIn(each_lane(available(), {Mode::plain, Mode::refine})),
                         Name{});
INSTANTIATE_TEST_SUITE_P(Float, SolverContract,
                         testing::ValuesIn(each_lane(with_float(), {Mode::in_float, Mode::in_float_refine})), Name{});
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(SolverContract);

}  // namespace
}  // namespace assur::test
