// Tests of `lanes` alone: fixed pivots for a class, checked in every lane, on every instruction set of this machine.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <Eigen/LU>

#include "assur/backend.hpp"
#include "backends/allocations.hpp"
#include "backends/lanes_elimination.hpp"
#include "backends/lanes_kernels.hpp"
#include "backends/matrices.hpp"

namespace assur::test {
namespace {

constexpr double kSingleEps = std::numeric_limits<float>::epsilon();

std::unique_ptr<LinearSolver> make(Precision precision = Precision::binary64) {
  return find_backend(backends(), "lanes").make(ThreadBudget{}, precision);
}

std::vector<double> right_side(int n, int lanes = 1, int rhs = 1) {
  std::vector<double> b(static_cast<std::size_t>(n * lanes * rhs));
  for (std::size_t i = 0; i < b.size(); ++i) b[i] = 1 + 0.1 * static_cast<double>(i % 7);
  return b;
}

// Several matrices of one pattern.
struct Pack {
  std::vector<Matrix> matrices;

  Pack(int lanes, const std::function<Matrix()>& draw) {
    for (int lane = 0; lane < lanes; ++lane) matrices.push_back(draw());
  }
  [[nodiscard]] const Pattern& pattern() const { return matrices[0].pattern; }
  [[nodiscard]] int lanes() const { return static_cast<int>(matrices.size()); }
  [[nodiscard]] std::vector<double> values() const {
    std::vector<std::vector<double>> each;
    for (const Matrix& a : matrices) each.push_back(a.values);
    return interleave(each);
  }
  [[nodiscard]] double worst_error(std::span<const double> x, std::span<const double> b) const {
    double worst = 0;
    for (int lane = 0; lane < lanes(); ++lane) {
      const Matrix& a = matrices[static_cast<std::size_t>(lane)];
      const double error = backward_error(a, lane_of(x, lanes(), lane), lane_of(b, lanes(), lane));
      if (!(error <= worst)) worst = error;
    }
    return worst;
  }
};

// ---- every instruction set

class LanesOn : public testing::TestWithParam<std::int64_t> {
 protected:
  void SetUp() override {
    hwy::SetSupportedTargetsForTest(GetParam());
    ASSERT_STREQ(lanes::instruction_set(), hwy::TargetName(GetParam()));
  }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};

// The instruction sets of this machine that the library was compiled for.
std::vector<std::int64_t> instruction_sets() {
  std::vector<std::int64_t> sets;
  for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1) {
    const std::int64_t one = left & -left;
    hwy::SetSupportedTargetsForTest(one);
    if (std::string(lanes::instruction_set()) == hwy::TargetName(one)) sets.push_back(one);
    hwy::SetSupportedTargetsForTest(0);
  }
  return sets;
}

// |x - x*| <= cond(A) times the backward error that the contract allows, x* in extended precision.
void expect_near_reference(const Matrix& a, std::span<const double> x, std::span<const double> b, Transpose transpose,
                           double eps) {
  using Long = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  const Eigen::Index n = a.pattern.n;
  Long full = Long::Zero(n, n), right(n, 1);
  for (Eigen::Index j = 0; j < n; ++j) {
    for (auto k = a.pattern.column_start[static_cast<std::size_t>(j)];
         k < a.pattern.column_start[static_cast<std::size_t>(j) + 1]; ++k) {
      full(a.pattern.row[static_cast<std::size_t>(k)], j) = a.values[static_cast<std::size_t>(k)];
    }
  }
  if (transpose == Transpose::yes) full.transposeInPlace();
  for (Eigen::Index i = 0; i < n; ++i) right(i, 0) = b[static_cast<std::size_t>(i)];
  const Long inverse = full.fullPivLu().inverse(), exact = inverse * right;
  const auto norm = [](const Long& m) { return static_cast<double>(m.cwiseAbs().rowwise().sum().maxCoeff()); };
  double error = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    error = std::max(error, std::abs(static_cast<double>(x[static_cast<std::size_t>(i)] - exact(i, 0))));
  }
  const double allowed = 10 * static_cast<double>(n) * eps * 2 * norm(full) * norm(inverse);
  EXPECT_LE(error, allowed * static_cast<double>(exact.cwiseAbs().maxCoeff()));
}

TEST_P(LanesOn, SolutionsAgreeWithExtendedPrecision) {
  Random random(1);
  for (int lanes : {1, 2, 4, 8, 16}) {
    for (int trial = 0; trial < 12; ++trial) {
      const int n = 1 + 2 * trial, rhs = 1 + trial % 6;
      const Pack pack(lanes, [&] { return trial % 2 ? sparse(n, 2, random) : dense(n, random); });
      const std::vector<double> b = right_side(n, lanes, rhs);
      for (const Precision precision : {Precision::binary64, Precision::binary32}) {
        const auto solver = make(precision);
        ASSERT_TRUE(solver->analyze(pack.pattern(), lanes).ok());
        ASSERT_TRUE(solver->factorize(pack.values()).ok());
        for (const Transpose transpose : {Transpose::no, Transpose::yes}) {
          std::vector<double> x = b;
          ASSERT_TRUE(solver->solve(x, rhs, transpose).ok());
          for (int lane = 0; lane < lanes; ++lane) {
            const auto xs = lane_of(x, lanes, lane), bs = lane_of(b, lanes, lane);
            for (int r = 0; r < rhs; ++r) {
              const auto from = static_cast<std::size_t>(r * n), size = static_cast<std::size_t>(n);
              expect_near_reference(pack.matrices[static_cast<std::size_t>(lane)], std::span(xs).subspan(from, size),
                                    std::span(bs).subspan(from, size), transpose,
                                    precision == Precision::binary64 ? kEps : kSingleEps);
            }
          }
        }
      }
    }
  }
}

// The same matrix gives the same bits in every lane and with any neighbours.
TEST_P(LanesOn, LanesAreIndependent) {
  Random random(2);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int lanes : {2, 4, 8, 16}) {
    Pack pack(lanes, [&] { return sparse(15, 3, random); });
    const auto first = make();
    ASSERT_TRUE(first->analyze(pack.pattern(), lanes).ok());
    ASSERT_TRUE(first->factorize(pack.values()).ok());
    const std::vector<double> b = right_side(15, lanes, 3);
    std::vector<double> healthy = b;
    ASSERT_TRUE(first->solve(healthy, 3).ok());
    for (const double factor : {0.0, nan, 1e-300, 1e300}) {
      for (int sick = 0; sick < lanes; ++sick) {
        Pack other = pack;
        scale(other.matrices[static_cast<std::size_t>(sick)], [&](int i, int) { return i == 4 ? factor : 1; });
        const auto solver = first->clone();
        const Code expected = factor == 0 ? Code::singular : std::isnan(factor) ? Code::not_finite : Code::ok;
        EXPECT_EQ(solver->factorize(other.values()).code, expected);
        std::vector<double> x = b;
        EXPECT_EQ(solver->solve(x, 3).code, expected);
        for (int lane = 0; lane < lanes; ++lane) {
          if (lane == sick) continue;
          EXPECT_EQ(lane_of(x, lanes, lane), lane_of(healthy, lanes, lane));
        }
      }
    }
  }
}

TEST_P(LanesOn, SolvesRingsToRoundingErrorAndRepeatsBitwise) {
  Random random(2);
  for (int n : {12, 24, 120, 360, 720}) {
    const auto solver = make(), again = make();
    for (int posture = 0; posture < 4; ++posture) {
      const Pack pack(8, [&] { return ring(n, random); });
      const std::vector<double> b = right_side(n, 8);
      if (posture == 0) {
        ASSERT_TRUE(solver->analyze(pack.pattern(), 8).ok());
        ASSERT_TRUE(again->analyze(pack.pattern(), 8).ok());
      }
      ASSERT_TRUE(solver->factorize(pack.values()).ok());
      ASSERT_TRUE(again->factorize(pack.values()).ok());
      std::vector<double> x = b, repeated = b;
      ASSERT_TRUE(solver->solve(x, 1).ok());
      ASSERT_TRUE(again->solve(repeated, 1).ok());
      EXPECT_LE(pack.worst_error(x, b), 10 * n * kEps) << n;
      EXPECT_EQ(x, repeated);
    }
  }
}

// Entries of one lane oscillate with different phases, so that every pivot passes through zero at some time.
TEST_P(LanesOn, SurvivesAPivotThatPassesThroughZero) {
  const int n = 15, steps = 2000, lanes = 8;
  Random random(4);
  Pack pack(lanes, [&] { return sparse(n, 3, random); });
  std::vector<double>& moving = pack.matrices[5].values;
  std::vector<double> phase(moving.size());
  for (double& p : phase) p = uniform(random, 0, 6);
  const auto solver = make();
  ASSERT_TRUE(solver->analyze(pack.pattern(), lanes).ok());
  const std::vector<double> b = right_side(n, lanes);
  for (int k = 0; k < steps; ++k) {
    for (std::size_t i = 0; i < phase.size(); ++i) moving[i] = std::cos(phase[i] + 6.0 * k / steps);
    ASSERT_TRUE(solver->factorize(pack.values()).ok());
    std::vector<double> x = b;
    ASSERT_TRUE(solver->solve(x, 1).ok());
    EXPECT_LE(pack.worst_error(x, b), 10 * n * kEps) << k;
  }
  EXPECT_GT(solver->effort().redone, 0);
  EXPECT_GT(solver->effort().renewed, 0);
  EXPECT_LT(solver->effort().renewed, 9);  // the wait for the next renewal doubles, from 8 steps on
}

INSTANTIATE_TEST_SUITE_P(Targets, LanesOn, testing::ValuesIn(instruction_sets()),
                         [](const auto& row) { return std::string(hwy::TargetName(row.param)); });

// ---- lanes that need other pivots than the class

// [d 1; 1 d] needs pivots on the diagonal for large d, and beside the diagonal for small d.
Matrix two(double d) {
  return compress(
      2, [](int, int) { return true; }, [=](int i, int j) { return i == j ? d : 1.0; });
}
Pack twos(const std::vector<double>& diagonals) {
  std::size_t lane = 0;
  return Pack(static_cast<int>(diagonals.size()), [&] { return two(diagonals[lane++]); });
}

void step(LinearSolver& solver, const Pack& pack) {
  ASSERT_TRUE(solver.factorize(pack.values()).ok());
  const std::vector<double> b = right_side(pack.pattern().n, pack.lanes());
  std::vector<double> x = b;
  ASSERT_TRUE(solver.solve(x, 1).ok());
  EXPECT_LE(pack.worst_error(x, b), 10 * pack.pattern().n * kEps);
  for (int lane = 0; lane < pack.lanes(); ++lane) EXPECT_TRUE(solver.figures(lane).ok);
}

TEST(Lanes, RepeatsAFailedLaneInTheSameCallAndCountsIt) {
  const auto solver = make();
  ASSERT_TRUE(solver->analyze(two(4).pattern, 4).ok());
  step(*solver, twos({4, 5, 6, 7}));
  EXPECT_EQ(solver->effort().redone, 0);
  step(*solver, twos({4, 5, 1e-9, 7}));
  EXPECT_EQ(solver->effort().redone, 1);
  EXPECT_EQ(solver->figures(2).determinant_sign, -1);
  EXPECT_EQ(solver->figures(1).determinant_sign, 1);
  step(*solver, twos({4, 5, 0, 1e-12}));
  EXPECT_EQ(solver->effort().redone, 3);
  step(*solver, twos({4, 5, 6, 7}));
  EXPECT_EQ(solver->effort().redone, 3);
  EXPECT_EQ(solver->effort().renewed, 0);
}

TEST(Lanes, SolvesTransposedSystemsOfARepeatedLane) {
  Random random(8);
  Pack pack(4, [&] { return dense(6, random); });
  const auto solver = make();
  ASSERT_TRUE(solver->analyze(pack.pattern(), 4).ok());
  ASSERT_TRUE(solver->factorize(pack.values()).ok());
  // In one lane all entries except a permuted diagonal nearly vanish, so that only six entries can be pivots. For some
  // permutations the pivots of the class are different ones.
  for (int shift = 0; shift < 6; ++shift) {
    Pack other = pack;
    scale(other.matrices[1], [&](int i, int j) { return (i + shift) % 6 == j ? 1 : 1e-12; });
    ASSERT_TRUE(solver->factorize(other.values()).ok());
    const std::vector<double> b = right_side(6, 4, 7);
    std::vector<double> x = b;
    ASSERT_TRUE(solver->solve(x, 7, Transpose::yes).ok());
    for (int lane = 0; lane < 4; ++lane) {
      const auto xs = lane_of(x, 4, lane), bs = lane_of(b, 4, lane);
      for (std::size_t r = 0; r < 7; ++r) {
        EXPECT_LE(backward_error(other.matrices[static_cast<std::size_t>(lane)], std::span(xs).subspan(r * 6, 6),
                                 std::span(bs).subspan(r * 6, 6), Transpose::yes),
                  60 * kEps);
      }
    }
  }
  EXPECT_GT(solver->effort().redone, 0);
}

TEST(Lanes, IdleLanesCopyLaneZeroWithoutAlarms) {
  const auto solver = make();
  ASSERT_TRUE(solver->analyze(two(4).pattern, 8).ok());
  step(*solver, twos({4, 5, 6, 7, 8, 9, 4, 4}));
  for (int k = 1; k <= 3; ++k) {
    const Pack pack = twos({1e-9 * k, 5, 6, 7, 8, 9, 1e-9 * k, 1e-9 * k});
    step(*solver, pack);
    EXPECT_EQ(solver->effort().redone, k);
    std::vector<double> x(16, 1.0);
    ASSERT_TRUE(solver->solve(x, 1).ok());
    EXPECT_EQ(lane_of(x, 8, 6), lane_of(x, 8, 0));
    EXPECT_EQ(lane_of(x, 8, 7), lane_of(x, 8, 0));
  }
  const Status failed = solver->factorize(interleave(std::vector(8, std::vector{1.0, 1.0, 1.0, 1.0})));
  EXPECT_EQ(failed.code, Code::singular);
  EXPECT_EQ(failed.where, Place::lane(0));
}

TEST(Lanes, RepivotsWhenLanesKeepFailing) {
  const auto solver = make();
  ASSERT_TRUE(solver->analyze(two(4).pattern, 2).ok());
  step(*solver, twos({4, 5}));
  for (int k = 0; k < 20; ++k) step(*solver, twos({1e-3, 1e-4}));
  EXPECT_EQ(solver->effort().renewed, 1);
  EXPECT_LE(solver->effort().redone, 2 * 8);  // no lane is redone after the eighth step
  const auto redone = solver->effort().redone;
  for (int k = 0; k < 20; ++k) step(*solver, twos({1e-3, 1e-4}));
  EXPECT_EQ(solver->effort().redone, redone);
}

// Who keeps a solver that has not redone a lane need not care what it factorised.
TEST(Lanes, EarlierStepsDoNotMatterWhileNoLaneWasRedone) {
  const auto solver = make();
  ASSERT_TRUE(solver->analyze(two(4).pattern, 2).ok());
  step(*solver, twos({4, 5}));
  const auto fresh = solver->clone();
  for (int k = 0; k < 100; ++k) step(*solver, twos({5, 4}));
  for (int k = 0; k < 20; ++k) {
    step(*solver, twos({1e-3, 1e-4}));
    step(*fresh, twos({1e-3, 1e-4}));
    EXPECT_EQ(solver->effort().renewed, fresh->effort().renewed) << k;
    EXPECT_EQ(solver->effort().redone, fresh->effort().redone) << k;
  }
  EXPECT_EQ(fresh->effort().renewed, 1);
}

// No pivots suit both lanes, so new ones are tried less and less often.
TEST(Lanes, DisagreeingLanesDoNotRepivotForever) {
  const auto solver = make();
  ASSERT_TRUE(solver->analyze(two(4).pattern, 2).ok());
  const int steps = 1000;
  for (int k = 0; k < steps; ++k) step(*solver, twos({1e-9, 1e9}));
  EXPECT_EQ(solver->effort().redone, steps + solver->effort().renewed);  // one lane in each step and renewal
  EXPECT_GT(solver->effort().renewed, 0);
  EXPECT_LE(solver->effort().renewed, 7);  // at most after 8, 16, ..., 512 steps
}

TEST(Lanes, FactorisesLanesWithOverflowingSquaresAlone) {
  const auto solver = make();
  ASSERT_TRUE(solver->analyze(two(4).pattern, 4).ok());
  step(*solver, twos({4, 5, 6, 7}));
  Pack pack = twos({4, 5, 6, 7});
  scale(pack.matrices[1], [](int, int) { return 1e-250; });
  scale(pack.matrices[2], [](int, int) { return 1e250; });
  step(*solver, pack);
  EXPECT_EQ(solver->effort().redone, 2);
}

TEST(Lanes, FactorisesNumbersBeyondFloatInDouble) {
  const auto solver = make(Precision::binary32);
  ASSERT_TRUE(solver->analyze(two(4).pattern, 2).ok());
  Pack pack = twos({4, 5});
  for (double factor : {1.0, 1e-100, 1e100}) {
    Pack other = pack;
    scale(other.matrices[1], [&](int, int) { return factor; });
    ASSERT_TRUE(solver->factorize(other.values()).ok());
    std::vector<double> b = right_side(2, 2), x = b;
    ASSERT_TRUE(solver->solve(x, 1).ok());
    EXPECT_LE(other.worst_error(x, b), 20 * kSingleEps);
  }
  EXPECT_EQ(solver->effort().redone, 2);
}

// ---- data shared by a class

TEST(Lanes, ACloneSharesOnlyThePivots) {
  Random random(3);
  const Pack pack(8, [&] { return sparse(20, 3, random); }), other(8, [&] { return sparse(20, 3, random); });
  const auto solver = make();
  ASSERT_TRUE(solver->analyze(pack.pattern(), 8).ok());
  ASSERT_TRUE(solver->factorize(pack.values()).ok());
  const std::vector<double> b = right_side(20, 8);
  std::vector<double> first = b, cloned = b, kept = b;
  ASSERT_TRUE(solver->solve(first, 1).ok());
  const auto clone = solver->clone();
  ASSERT_NE(clone, nullptr);
  EXPECT_EQ(clone->solve(cloned, 1).code, Code::singular);  // the clone has factorised nothing yet
  ASSERT_TRUE(clone->factorize(other.values()).ok());
  ASSERT_TRUE(solver->solve(kept, 1).ok());
  EXPECT_EQ(kept, first);
  ASSERT_TRUE(clone->factorize(pack.values()).ok());
  cloned = b;
  ASSERT_TRUE(clone->solve(cloned, 1).ok());
  EXPECT_EQ(cloned, first);
}

// ---- the steady state

TEST(Lanes, AllocatesNothingInAnyWidthOrPrecision) {
  Random random(5);
  for (const Precision precision : {Precision::binary64, Precision::binary32}) {
    for (int lanes : {1, 2, 4, 8, 16}) {
      const Pack pack(lanes, [&] { return sparse(60, 2, random); });
      const std::vector<double> values = pack.values();
      std::vector<double> b = right_side(60, lanes, 5);
      const auto solver = make(precision);
      ASSERT_TRUE(solver->analyze(pack.pattern(), lanes).ok());
      ASSERT_TRUE(solver->factorize(values).ok());
      const auto before = allocations();
      ASSERT_TRUE(solver->factorize(values).ok());
      for (int first : {0, 1, 30, 59, 60}) ASSERT_TRUE(solver->solve(b, 5, Transpose::no, first).ok());
      ASSERT_TRUE(solver->solve(b, 5, Transpose::yes).ok());
      EXPECT_EQ(allocations(), before);
      EXPECT_EQ(solver->effort().redone, 0);
    }
  }
}

TEST(Lanes, ALaneWithItsOwnPivotsAllocatesNothing) {
  const auto solver = make();
  ASSERT_TRUE(solver->analyze(two(4).pattern, 2).ok());
  const std::vector<double> values = twos({1e-3, 1e3}).values();
  ASSERT_TRUE(solver->factorize(values).ok());
  ASSERT_EQ(solver->effort().redone, 1);
  std::vector<double> b = right_side(2, 2, 5);
  const auto before = allocations();
  ASSERT_TRUE(solver->factorize(values).ok());
  ASSERT_TRUE(solver->solve(b, 5).ok());
  EXPECT_EQ(allocations(), before);
  EXPECT_EQ(solver->effort().redone, 2);
}

// ---- the program

TEST(Lanes, SolvesATriangleWithoutFillAndProducts) {
  Random random(6);
  const Matrix a = permuted_triangle(40, 1, random);
  const lanes::Order order = lanes::markowitz_order(a.pattern, a.values, 1, 1, {});
  ASSERT_TRUE(order.complete(40));
  const lanes::Elimination program = lanes::write_program(a.pattern, order);
  EXPECT_EQ(program.slots, static_cast<unsigned>(a.pattern.nnz()) + 40);
  EXPECT_EQ(program.factor.size(), 40u * 3 + 2 * a.values.size());
}

TEST(Lanes, BackwardSubstitutionStopsAtTheWantedUnknowns) {
  const int n = 12;  // upper triangle with two diagonals: unknown i needs i + 1 and all after it
  Random random(6);
  const Matrix a = compress(
      n, [](int i, int j) { return j == i || j == i + 1; }, [&](int, int) { return nonzero(random); });
  const lanes::Elimination program =
      lanes::write_program(a.pattern, lanes::markowitz_order(a.pattern, a.values, 1, 1, {}));
  // In a triangular matrix, one of the two substitutions does all the work.
  for (std::size_t first = 0; first <= n; ++first) EXPECT_EQ(program.wanted_rows[first], n - first);
}

TEST(Lanes, RefusesTooLargePatterns) {
  const Backend& backend = find_backend(backends(), "lanes");
  EXPECT_EQ(backend.why_not({.n = 300, .nnz = 90'000}, {}), "");
  EXPECT_EQ(backend.why_not({.n = 4000, .nnz = 16'000'000}, {}),
            "the program for an elimination of 16000000 nonzeros is too long; the limit is 90000");
  Random random(1);
  const auto solver = make();
  const Matrix wide = sparse(900, 9, random);
  ASSERT_TRUE(solver->analyze(wide.pattern, 1).ok());
  EXPECT_THROW((void)solver->factorize(wide.values), Error);
  try {
    (void)solver->analyze(two(1).pattern, 3);
    FAIL();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "the backend lanes has 1, 2, 4, 8 or 16 lanes, not 3");
  }
}

}  // namespace
}  // namespace assur::test
