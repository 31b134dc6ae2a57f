// Tests of `team` alone: several threads, bitwise equal results for every number of threads, concurrent packs.
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <mutex>
#include <set>
#include <thread>

#include "assur/backend.hpp"
#include "backends/allocations.hpp"
#include "backends/matrices.hpp"

namespace {

constexpr int kPanel = 48;  // columns; products of LAPACK within a panel have fewer

// While this is active, a product with a whole panel waits until the expected number of threads has begun one.
struct Meeting {
  std::atomic<std::size_t> expected{0};         // 0: off
  std::chrono::steady_clock::time_point limit;  // waiting ends at this time
  std::mutex mutex;
  std::set<std::thread::id> threads;

  void arrive() {
    const auto count = [&] {
      const std::scoped_lock lock(mutex);
      threads.insert(std::this_thread::get_id());
      return threads.size();
    };
    while (count() < expected && std::chrono::steady_clock::now() < limit) std::this_thread::yield();
  }
};
Meeting meeting;

}  // namespace

// This dgemm is called instead of that of the BLAS library and forwards to it.
extern "C" void dgemm_(const char* transa, const char* transb, const int* m, const int* n, const int* k,
                       const double* alpha, const double* a, const int* lda, const double* b, const int* ldb,
                       const double* beta, double* c, const int* ldc, std::size_t transa_length,
                       std::size_t transb_length) {
  static const auto next = reinterpret_cast<decltype(&dgemm_)>(dlsym(RTLD_NEXT, "dgemm_"));
  if (meeting.expected > 0 && *k == kPanel) meeting.arrive();
  next(transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc, transa_length, transb_length);
}

namespace assur::test {
namespace {

class TeamBackend : public testing::Test {
 protected:
  void SetUp() override {
    if (const std::string why_not = row_.why_not({}, {2}); !why_not.empty()) GTEST_SKIP() << why_not;
  }

  std::unique_ptr<LinearSolver> make(int threads, const Pattern& pattern, Precision precision = Precision::binary64) {
    auto solver = row_.make(ThreadBudget{threads}, precision);
    EXPECT_TRUE(solver->analyze(pattern, 1).ok());
    return solver;
  }

  const Backend& row_ = find_backend(backends(), "team");
};

std::vector<double> right_side(int n) {
  std::vector<double> b;
  for (int i = 0; i < n; ++i) b.push_back(1 + 0.1 * (i % 7));
  return b;
}

// Orders around the borders of panels (48 columns) and tiles (192), where errors are most likely.
TEST_F(TeamBackend, SolvesEveryOrderWithEveryNumberOfThreads) {
  Random random(1);
  for (int n : {1, 47, 48, 49, 96, 97, 144, 191, 192, 193, 240, 241, 383, 385, 433, 577}) {
    const Matrix a = dense(n, random);
    const std::vector<double> b = right_side(n);
    for (int threads : {1, 2, 3, 5}) {
      const auto solver = make(threads, a.pattern);
      ASSERT_TRUE(solver->factorize(a.values).ok());
      for (const Transpose transpose : {Transpose::no, Transpose::yes}) {
        std::vector<double> x = b;
        ASSERT_TRUE(solver->solve(x, 1, transpose).ok());
        EXPECT_LE(backward_error(a, x, b, transpose), 10 * n * kEps) << n << ", " << threads << " threads";
      }
    }
  }
}

TEST_F(TeamBackend, ResultsAreBitwiseEqualForEveryNumberOfThreads) {
  Random random(2);
  for (const Precision precision : {Precision::binary64, Precision::binary32}) {
    for (int n : {193, 400, 700}) {
      const Matrix a = dense(n, random);
      std::vector<double> expected;
      double expected_growth = 0;
      for (int threads : {1, 2, 2, 3, 4, 7}) {
        const auto solver = make(threads, a.pattern, precision);
        ASSERT_TRUE(solver->factorize(a.values).ok());
        std::vector<double> x = right_side(n);
        ASSERT_TRUE(solver->solve(x, 1).ok());
        if (expected.empty()) {
          expected = x;
          expected_growth = solver->figures(0).pivot_growth;
        }
        EXPECT_EQ(x, expected) << n << ", " << threads << " threads";
        EXPECT_EQ(solver->figures(0).pivot_growth, expected_growth);
      }
    }
  }
}

// If a column vanishes in any panel, no thread waits forever. The next matrix is solved correctly.
TEST_F(TeamBackend, SingularMatricesEndEarlyEverywhere) {
  const int n = 433;
  Random random(3);
  const Matrix a = dense(n, random);
  for (int threads : {1, 2, 4}) {
    const auto solver = make(threads, a.pattern);
    for (int column : {0, 47, 48, 95, 200, 431, 432}) {
      Matrix sick = a;
      scale(sick, [&](int, int j) { return j == column ? 0.0 : 1.0; });
      EXPECT_EQ(solver->factorize(sick.values).code, Code::singular) << column;
      EXPECT_FALSE(solver->figures(0).ok);
      ASSERT_TRUE(solver->factorize(a.values).ok());
      std::vector<double> x = right_side(n);
      ASSERT_TRUE(solver->solve(x, 1).ok());
      EXPECT_LE(backward_error(a, x, right_side(n)), 10 * n * kEps);
    }
  }
}

TEST_F(TeamBackend, ReportsOverflowAsSingular) {
  const int n = 300;
  Random random(4);
  Matrix a = dense(n, random);
  scale(a, [](int, int) { return 1.5e308; });
  for (int threads : {1, 2}) {
    const auto solver = make(threads, a.pattern);
    EXPECT_EQ(solver->factorize(a.values).code, Code::singular);
  }
}

TEST_F(TeamBackend, DeterminantSignEqualsEigen) {
  Random random(5);
  int negative = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const Matrix a = dense(200 + trial, random);
    const auto solver = make(2, a.pattern);
    const auto other = find_backend(backends(), "eigen").make(ThreadBudget{}, Precision::binary64);
    ASSERT_TRUE(other->analyze(a.pattern, 1).ok());
    ASSERT_TRUE(solver->factorize(a.values).ok());
    ASSERT_TRUE(other->factorize(a.values).ok());
    EXPECT_EQ(solver->figures(0).determinant_sign, other->figures(0).determinant_sign);
    negative += solver->figures(0).determinant_sign < 0;
  }
  EXPECT_GT(negative, 0);
  EXPECT_LT(negative, 20);
}

TEST_F(TeamBackend, TwoThreadsAllocateNothingAfterTheFirstFactorisation) {
  Random random(6);
  for (const Precision precision : {Precision::binary64, Precision::binary32}) {
    for (int n : {102, 200, 300, 433, 500}) {  // products of fewer and of more multiplications than 1e6
      const Matrix a = dense(n, random);
      const auto solver = make(2, a.pattern, precision);
      std::vector<double> x = right_side(n);
      for (int i = 0; i < 3; ++i) ASSERT_TRUE(solver->factorize(a.values).ok());  // each thread has worked
      const auto before = allocations();
      for (int i = 0; i < 5; ++i) {
        ASSERT_TRUE(solver->factorize(a.values).ok());
        ASSERT_TRUE(solver->solve(x, 1).ok());
      }
      EXPECT_EQ(allocations() - before, 0) << n << (precision == Precision::binary32 ? ", float" : "");
    }
  }
}

// A budget of four threads as 2 x 2: the matrix products of two packs run concurrently on four threads, even if there
// are fewer cores.
TEST_F(TeamBackend, TwoCallersWithTwoThreadsEachUseFourThreads) {
  const int n = 400;
  Random random(7);
  const Matrix a = dense(n, random);
  const std::vector<double> b = right_side(n);
  std::vector<double> x[2] = {b, b};
  Code code[2] = {Code::singular, Code::singular};
  meeting.threads.clear();
  meeting.limit = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  meeting.expected = 4;
  std::thread callers[2];
  for (int caller = 0; caller < 2; ++caller) {
    callers[caller] = std::thread([&, caller] {
      const auto solver = make(2, a.pattern);
      if (!solver->factorize(a.values).ok()) return;
      code[caller] = solver->solve(x[caller], 1).code;
    });
  }
  for (std::thread& caller : callers) caller.join();
  meeting.expected = 0;
  EXPECT_EQ(meeting.threads.size(), 4u);
  for (int caller = 0; caller < 2; ++caller) {
    EXPECT_EQ(code[caller], Code::ok);
    EXPECT_LE(backward_error(a, x[caller], b), 10 * n * kEps);
  }
  EXPECT_EQ(x[0], x[1]);
}

}  // namespace
}  // namespace assur::test
