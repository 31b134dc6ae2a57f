// Tests of LAPACK alone: the threads of its library.
#include <gtest/gtest.h>

#include <thread>

#include "assur/backend.hpp"
#include "backends/allocations.hpp"
#include "backends/matrices.hpp"

namespace assur::test {
namespace {

class Lapack : public testing::Test {
 protected:
  void SetUp() override {
    if (const std::string why_not = row_.why_not({}, {2}); !why_not.empty()) GTEST_SKIP() << why_not;
  }
  const Backend& row_ = find_backend(backends(), "lapack");
};

TEST_F(Lapack, SolvesWithTheThreadsOfItsBudget) {
  Random random(9);
  const int n = 400;  // OpenBLAS uses several threads from 200 on
  const Matrix a = dense(n, random);
  std::vector<double> b;
  for (int i = 0; i < 3 * n; ++i) b.push_back(nonzero(random));
  for (int threads : {1, 2, 3}) {
    const auto solver = row_.make(ThreadBudget{threads}, Precision::binary64);
    ASSERT_TRUE(solver->analyze(a.pattern, 1).ok());
    ASSERT_TRUE(solver->factorize(a.values).ok());
    for (const Transpose transpose : {Transpose::no, Transpose::yes}) {
      std::vector<double> x = b;
      ASSERT_TRUE(solver->solve(x, 3, transpose).ok());
      for (std::size_t r = 0; r < 3; ++r) {
        const auto part = [&](const std::vector<double>& v) { return std::span(v).subspan(r * 400, 400); };
        EXPECT_LE(backward_error(a, part(x), part(b), transpose), 10 * n * kEps) << threads;
      }
    }
  }
}

TEST_F(Lapack, ConcurrentCallersDoNotDisturbEachOther) {
  constexpr int kCallers = 3;
  std::vector<double> error(kCallers, 1.0);
  std::vector<std::thread> callers;
  for (int caller = 0; caller < kCallers; ++caller) {
    callers.emplace_back([&, caller] {
      Random random(static_cast<std::uint64_t>(caller));
      const int n = 230 + caller;
      const auto solver = row_.make(ThreadBudget{1 + caller % 2}, Precision::binary64);
      double& worst = error[static_cast<std::size_t>(caller)];
      worst = 0;
      for (int i = 0; i < 10; ++i) {
        const Matrix a = dense(n, random);
        const std::vector<double> b(static_cast<std::size_t>(n), 1.0);
        std::vector<double> x = b;
        if (!solver->analyze(a.pattern, 1).ok() || !solver->factorize(a.values).ok() || !solver->solve(x, 1).ok()) {
          worst = 1;
          return;
        }
        worst = std::max(worst, backward_error(a, x, b) / n);
      }
    });
  }
  for (std::thread& caller : callers) caller.join();
  for (double worst : error) EXPECT_LE(worst, 10 * kEps);
}

TEST_F(Lapack, NamesTheLoadedLibrary) {
  EXPECT_NE(row_.version(), "LAPACK") << "its threads can be set, so it is known";
}

}  // namespace
}  // namespace assur::test
