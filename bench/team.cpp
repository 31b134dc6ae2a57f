// A team of threads against LAPACK's own threads on one dense matrix. Both solvers factorise the same matrices, in one
// run and interleaved at random; the backward error of each is measured first.
#include <benchmark/benchmark.h>

#include <limits>
#include <string>
#include <vector>

#include "assur/backend.hpp"
#include "backends/matrices.hpp"
#include "program.hpp"

namespace assur::bench {
namespace {

void factorize(benchmark::State& state, const Backend& backend, const test::Matrix& a, int threads,
               Precision precision) {
  const double eps = precision == Precision::binary64 ? kEps : std::numeric_limits<float>::epsilon();
  const auto solver = backend.make(ThreadBudget{threads}, precision);
  const std::vector<double> b(static_cast<std::size_t>(a.pattern.n), 1.0);
  std::vector<double> x = b;
  if (!solver->analyze(a.pattern, 1).ok() || !solver->factorize(a.values).ok() || !solver->solve(x, 1).ok()) {
    return state.SkipWithError("not solved");
  }
  const double error = test::backward_error(a, x, b);
  if (!(error <= 10 * a.pattern.n * eps)) return state.SkipWithError("the solution is wrong");
  for ([[maybe_unused]] auto _ : state) {
    if (!solver->factorize(a.values).ok()) return state.SkipWithError("not factorised");
  }
  const double n = a.pattern.n;
  state.counters["error"] = error;
  state.counters["GFlop/s"] =
      benchmark::Counter(2.0 / 3 * n * n * n * 1e-9, benchmark::Counter::kIsIterationInvariantRate);
}

void register_all() {
  for (const std::int32_t n : {100, 200, 500, 1000, 2000}) {
    test::Random random(1);
    const test::Matrix a = test::dense(n, random);
    for (const int threads : {1, 2}) {
      for (const std::string id : {"lapack", "team"}) {
        const Backend& backend = find_backend(backends(), id);
        if (!backend.why_not({.n = n, .nnz = n * n}, {threads}).empty()) continue;
        for (const Precision precision : {Precision::binary64, Precision::binary32}) {
          const std::string name = id + (precision == Precision::binary32 ? "+float" : "") + " n=" + std::to_string(n) +
                                   " threads=" + std::to_string(threads);
          benchmark::RegisterBenchmark(name.c_str(), [=, &backend](benchmark::State& state) {
            factorize(state, backend, a, threads, precision);
          })->UseRealTime();
        }
      }
    }
  }
}

}  // namespace
}  // namespace assur::bench

int main(int argc, char** argv) { return assur::bench::run_program(argc, argv, assur::bench::register_all, 9); }
