// No backend changes the thread settings of its caller.
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cfenv>
#include <functional>
#include <ostream>
#include <string>
#include <thread>
#include <vector>

#include "assur/backend.hpp"
#include "backends/available.hpp"
#include "backends/matrices.hpp"
#include "parallel/thread_state.hpp"

namespace assur::test {
namespace {

// -1 if no loaded library has such a setting.
int ask(const char* symbol) {
  const auto function = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, symbol));
  return function ? function() : -1;
}

void set(const char* symbol, int value) {
  if (const auto function = reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, symbol))) function(value);
}

struct Settings {
  int openmp_threads = ask("omp_get_max_threads");
  int openmp_dynamic = ask("omp_get_dynamic");
  int openmp_levels = ask("omp_get_max_active_levels");
  int openblas_threads = ask("openblas_get_num_threads");
  int mkl_threads = ask("MKL_Get_Max_Threads");
  int rounding = std::fegetround();
  std::vector<int> processors = allowed_processors();

  friend bool operator==(const Settings&, const Settings&) = default;
  friend void PrintTo(const Settings& s, std::ostream* out) {
    *out << "OpenMP: threads " << s.openmp_threads << ", dynamic " << s.openmp_dynamic << ", levels " << s.openmp_levels
         << "; OpenBLAS: " << s.openblas_threads << ", MKL: " << s.mkl_threads << "; rounding " << s.rounding << "; "
         << s.processors.size() << " processors";
  }
};

class CallerSettings : public testing::TestWithParam<const Backend*> {
 protected:
  // These numbers differ from all budgets of the test, so that a setting left behind is found. They differ from each
  // other, so that a call of BLAS on the threads of the caller is found: OpenBLAS then takes the number of OpenMP.
  void SetUp() override {
    set("openblas_set_num_threads", 4);  // also sets that of OpenMP
    set("omp_set_num_threads", 3);
    set("omp_set_dynamic", 0);
    set("omp_set_max_active_levels", 5);
  }
  void TearDown() override {
    set("openblas_set_num_threads", before_.openblas_threads);
    set("omp_set_num_threads", before_.openmp_threads);
    set("omp_set_dynamic", before_.openmp_dynamic);
    set("omp_set_max_active_levels", before_.openmp_levels);
  }

 private:
  const Settings before_ = {};
};

TEST_P(CallerSettings, KeepsSettingsAfterEveryCall) {
  const Backend& backend = *GetParam();
  Random random(11);
  for (const int n : {15, 300}) {  // with 300, OpenBLAS and the team use several threads
    const Matrix a = sparse(n, 3, random);
    for (const int threads : {1, 2}) {
      if (!backend.why_not({.n = n, .nnz = a.pattern.nnz()}, {threads}).empty()) continue;
      for (const Precision precision : {Precision::binary64, Precision::binary32}) {
        if (precision == Precision::binary32 && !backend.single) continue;
        const Settings before;
        const auto check = [&](const char* call) {
          EXPECT_EQ(Settings(), before) << call << ", n = " << n << ", threads = " << threads;
        };
        auto solver = backend.make({threads}, precision);
        check("make");
        ASSERT_TRUE(solver->analyze(a.pattern, 1).ok());
        check("analyze");
        for (int i = 0; i < 2; ++i) {  // the second factorisation may take another path
          ASSERT_TRUE(solver->factorize(a.values).ok());
          check("factorize");
        }
        for (const Transpose transpose : {Transpose::no, Transpose::yes}) {
          std::vector<double> x(static_cast<std::size_t>(3 * n), 1.0);
          ASSERT_TRUE(solver->solve(x, 3, transpose).ok());
          check("solve");
        }
        [[maybe_unused]] const Figures figures = solver->figures(0);
        check("figures");
        auto clone = solver->clone();
        check("clone");
        const std::vector<double> zeros(a.values.size(), 0.0);
        EXPECT_FALSE(solver->factorize(zeros).ok());
        check("factorize, singular");
        solver.reset();
        clone.reset();
        check("the destructor");
      }
    }
  }
}

// OpenBLAS has one number of threads for the whole process. After two concurrent callers it must be as it was before
// both.
TEST_P(CallerSettings, KeepsSettingsAfterConcurrentCalls) {
  const Backend& backend = *GetParam();
  if (backend.id != "lapack" && backend.id != "team") GTEST_SKIP() << "does not touch the threads of BLAS";
  const int n = 300;
  Random random(12);
  const Matrix a = dense(n, random);
  if (const auto why = backend.why_not({.n = n, .nnz = n * n}, {2}); !why.empty()) GTEST_SKIP() << why;
  const Settings before;
  std::vector<std::thread> callers;
  for (int caller = 0; caller < 2; ++caller) {
    callers.emplace_back([&] {
      const auto solver = backend.make({2}, Precision::binary64);
      EXPECT_TRUE(solver->analyze(a.pattern, 1).ok());
      for (int i = 0; i < 20; ++i) EXPECT_TRUE(solver->factorize(a.values).ok());
    });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(Settings(), before);
}

INSTANTIATE_TEST_SUITE_P(Backends, CallerSettings, testing::ValuesIn(available()),
                         [](const auto& row) { return std::string(row.param->id); });

}  // namespace
}  // namespace assur::test
