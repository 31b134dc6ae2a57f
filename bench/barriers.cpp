// Costs of starting the work of a team and of meeting at its barrier, which a second thread must gain back. They are
// also measured for more threads than cores ("crowded") and for threads that are pinned to separate cores.
#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "assur/machine.hpp"
#include "parallel/team.hpp"
#include "program.hpp"

namespace assur::bench {
namespace {

void run_team(benchmark::State& state, int size, const std::vector<int>& pin_to) {
  Team team(size, pin_to);
  for ([[maybe_unused]] auto _ : state) team.run([](int) noexcept {});
}

// Time of one meeting, from many meetings in one run.
void meet(benchmark::State& state, int size, const std::vector<int>& pin_to) {
  constexpr int kMeetings = 1000;
  Team team(size, pin_to);
  for ([[maybe_unused]] auto _ : state) {
    team.run([&](int) {
      for (int i = 0; i < kMeetings; ++i) team.barrier();
    });
  }
  state.counters["one meeting"] =
      benchmark::Counter(kMeetings, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void register_all() {
  const std::vector<int> cores = this_machine().cores;
  const int most = static_cast<int>(cores.size());
  const auto add = [](const std::string& how, int size, const std::vector<int>& pin_to) {
    const std::string text = " threads=" + std::to_string(size) + how;
    benchmark::RegisterBenchmark(("run" + text).c_str(), [=](benchmark::State& s) {
      run_team(s, size, pin_to);
    })->UseRealTime();
    benchmark::RegisterBenchmark(("barrier" + text).c_str(), [=](benchmark::State& s) {
      meet(s, size, pin_to);
    })->UseRealTime();
  };
  add("", 1, {});
  for (int size = 2; size <= most; size *= 2) {
    add("", size, {});
    add(" pinned", size, cores);
  }
  add(" crowded", 2 * most, {});
}

}  // namespace
}  // namespace assur::bench

int main(int argc, char** argv) { return assur::bench::run_program(argc, argv, assur::bench::register_all, 9); }
