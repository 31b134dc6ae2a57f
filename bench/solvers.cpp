// Every linear solver that can run here, over patterns, sizes and numbers of groups. Times one factorisation with three
// solutions (as in a step of a group), one factorisation alone, and one solution alone. The counters are the time for
// one group, the backward error of the timed results, and the memory that was allocated.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "backends/allocations.hpp"
#include "matrices.hpp"
#include "program.hpp"

namespace assur::bench {
namespace {

// The work that is timed.
enum class Work { group, factor, solve };
constexpr std::string_view kWork[] = {"factor+3solves", "factor", "solve"};
constexpr int kSolves = 3;

// A solver of the table, and the number of groups that it solves side by side.
struct Candidate {
  const Backend* backend;
  int lanes;
  Precision precision;

  [[nodiscard]] std::string text() const {
    return std::string(backend->id) + (lanes > 1 ? ":" + std::to_string(lanes) : "") +
           (precision == Precision::binary32 ? "+float" : "");
  }
};

// The matrices of one benchmark, made at first use and kept, because making a large matrix takes longer than solving.
class Matrices {
 public:
  Matrices(std::string kind, int n, int count) : kind_(std::move(kind)), n_(n), count_(count) {}
  const std::vector<test::Matrix>& get() {
    if (all_.empty()) all_ = make_matrices(kind_, n_, count_);
    return all_;
  }

 private:
  std::string kind_;
  int n_, count_;
  std::vector<test::Matrix> all_;
};

// Groups side by side; lanes beyond the last group repeat the first.
struct Pack {
  std::vector<int> groups;               // lanes
  std::vector<double> values, right, x;  // nnz x lanes; n x lanes
  std::shared_ptr<LinearSolver> solver;
};

// shared: all packs use one solver, which keeps the factors of the last pack only.
std::vector<Pack> make_packs(const std::vector<test::Matrix>& matrices, const Candidate& candidate, bool shared) {
  std::vector<Pack> packs;
  const int count = static_cast<int>(matrices.size()), n = matrices[0].pattern.n;
  test::Random random(1);
  for (int first = 0; first < count; first += candidate.lanes) {
    Pack& pack = packs.emplace_back();
    std::vector<std::vector<double>> values, right;
    for (int lane = 0; lane < candidate.lanes; ++lane) {
      pack.groups.push_back(first + lane < count ? first + lane : first);
      values.push_back(matrices[static_cast<std::size_t>(pack.groups.back())].values);
      auto& b = right.emplace_back();
      for (int i = 0; i < n; ++i) b.push_back(test::nonzero(random));
    }
    pack.values = test::interleave(values);
    pack.right = test::interleave(right);
    pack.x.resize(pack.right.size());
    if (packs.size() > 1) pack.solver = shared ? packs.front().solver : packs.front().solver->clone();
    if (!pack.solver) {
      pack.solver = candidate.backend->make(ThreadBudget{}, candidate.precision);
      if (!pack.solver->analyze(matrices[0].pattern, candidate.lanes).ok()) return {};
    }
    if (!pack.solver->factorize(pack.values).ok()) return {};
  }
  return packs;
}

bool solve(Pack& pack) {
  std::copy(pack.right.begin(), pack.right.end(), pack.x.begin());
  return pack.solver->solve(pack.x, 1).ok();
}

bool run(std::vector<Pack>& packs, Work work) {
  bool ok = true;
  for (Pack& pack : packs) {
    if (work != Work::solve) ok = pack.solver->factorize(pack.values).ok() && ok;
    for (int i = 0; work != Work::factor && i < (work == Work::group ? kSolves : 1); ++i) ok = solve(pack) && ok;
  }
  return ok;
}

double worst_error(const std::vector<Pack>& packs, const std::vector<test::Matrix>& matrices) {
  double worst = 0;
  for (const Pack& pack : packs) {
    const int lanes = static_cast<int>(pack.groups.size());
    for (int lane = 0; lane < lanes; ++lane) {
      const double error =
          test::backward_error(matrices[static_cast<std::size_t>(pack.groups[static_cast<std::size_t>(lane)])],
                               test::lane_of(pack.x, lanes, lane), test::lane_of(pack.right, lanes, lane));
      if (!(error <= worst)) worst = error;
    }
  }
  return worst;
}

void time_solver(benchmark::State& state, const std::shared_ptr<Matrices>& source, const Candidate& candidate,
                 Work work) {
  const std::vector<test::Matrix>& matrices = source->get();
  // As in the simulator: one solver for each pack if it keeps pivots, else one for all.
  const bool shared = work == Work::group && !candidate.backend->keeps_pivots;
  std::vector<Pack> packs = make_packs(matrices, candidate, shared);
  if (packs.empty() || !run(packs, Work::group)) return state.SkipWithError("a factorisation or solution failed");
  const std::int64_t before = test::allocations();
  for ([[maybe_unused]] auto _ : state) {
    if (!run(packs, work)) return state.SkipWithError("a factorisation or solution failed");
    benchmark::DoNotOptimize(packs.back().x.data());
  }
  const auto allocated = static_cast<double>(test::allocations() - before);
  if (work == Work::factor && !run(packs, Work::solve)) return state.SkipWithError("a solution failed");
  state.counters["per_group"] =
      benchmark::Counter(static_cast<double>(matrices.size()),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["backward"] = worst_error(packs, matrices);
  state.counters["allocations"] = allocated / static_cast<double>(state.iterations());
}

// ---- the solvers for each matrix

// Largest sizes. Memory limits dense solvers: groups x n^2. Time limits sparse solvers on dense matrices: it grows with
// n^3 at the speed of scalar code.
constexpr double kDenseMemory = 16e6;  // doubles: 4000 unknowns of one group, 500 of 64
constexpr int kSparseOnDense = 240;    // unknowns

bool worth_running(const Candidate& c, std::string_view kind, int n, int groups) {
  if (c.backend->dense) return static_cast<double>(groups) * n * n <= kDenseMemory;
  return kind != "dense" || n <= kSparseOnDense;
}

// Lanes of the backend `lanes`: one for a single group, sixteen for more than eight groups.
std::vector<int> widths(const Backend& backend, int groups) {
  if (!backend.fills_lanes) return {1};
  if (groups == 1) return {1};
  if (groups <= 8) return {8};
  return {8, 16};
}

void register_all() {
  struct Family {
    std::string kind;
    std::vector<int> sizes, groups;
  };
  const Family families[] = {
      {"ring", {6, 12, 30, 60, 120, 240, 360, 720, 1440, 4000}, {1, 6, 8, 16, 64}},
      {"legs", {15}, {1, 6, 8, 16, 64}},
      {"dense", {3, 6, 9, 15, 30, 60, 120, 240, 500, 1000, 2000, 4000}, {1, 8}},
  };
  for (const Family& family : families) {
    for (const int n : family.sizes) {
      for (const int groups : family.groups) {
        const auto matrices = std::make_shared<Matrices>(family.kind, n, groups);
        for (const Backend& backend : backends()) {
          if (!backend.why_not(Shape{n, 3 * n, groups, kSolves}, ThreadBudget{}).empty()) continue;
          for (const int lanes : widths(backend, groups)) {
            for (const Precision precision : {Precision::binary64, Precision::binary32}) {
              const Candidate candidate{&backend, lanes, precision};
              if (precision == Precision::binary32 && !backend.single) continue;
              if (!worth_running(candidate, family.kind, n, groups)) continue;
              for (const Work work : {Work::group, Work::factor, Work::solve}) {
                if (work != Work::group && groups != 1 && groups != 8) continue;
                const std::string text = family.kind + "/n=" + std::to_string(n) + "/groups=" + std::to_string(groups) +
                                         "/" + candidate.text() + "/" + std::string(kWork[static_cast<int>(work)]);
                benchmark::RegisterBenchmark(text.c_str(), time_solver, matrices, candidate, work);
              }
            }
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace assur::bench

int main(int argc, char** argv) { return assur::bench::run_program(argc, argv, assur::bench::register_all); }
