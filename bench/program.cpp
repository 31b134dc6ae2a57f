#include "program.hpp"

#include <hwy/targets.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <string_view>
#include <vector>

#include "assur/assur.hpp"
#include "machine.hpp"

namespace assur::bench {
namespace {

constexpr int kWarm = 10;  // steps, for the history of the predictors and the memory of the solvers

// --simd=AVX2: runs as on a processor without wider instructions. Highway gives the best target the lowest number.
bool take_simd(std::string_view argument) {
  if (argument != "--simd=AVX2") return false;
  hwy::SetSupportedTargetsForTest(hwy::SupportedTargets() & -std::int64_t{HWY_AVX2});
  return true;
}

}  // namespace

int run_program(int argc, char** argv, void (*register_all)(), int repetitions) {
  std::string defaults[] = {
      "--benchmark_enable_random_interleaving=true", "--benchmark_repetitions=" + std::to_string(repetitions),
      "--benchmark_report_aggregates_only=true", "--benchmark_min_time=0.05", "--benchmark_counters_tabular=true"};
  std::vector<char*> arguments = {argv[0]};
  for (std::string& argument : defaults) arguments.push_back(argument.data());
  std::copy_if(argv + 1, argv + argc, std::back_inserter(arguments), [](const char* a) { return !take_simd(a); });
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  for (const auto& [name, text] : machine_facts()) benchmark::AddCustomContext(name, text);
  register_all();
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}

bool worth_timing(const Scene& scene, const std::string& strategy) {
  try {
    const Prepared prepared = prepare(scene, {strategy, {}});
    const std::int32_t lanes = parse_strategy(strategy).solver.lanes;
    return std::any_of(prepared.plan().choices.begin(), prepared.plan().choices.end(),
                       [lanes](const Plan::Choice& choice) { return choice.solver.lanes == lanes; });
  } catch (const Error&) {
    return false;  // it cannot run here; `assur backends` gives the reason
  }
}

void time_steps(benchmark::State& state, const Scene& scene, const std::string& strategy) {
  Simulator simulator(prepare(scene, {strategy, {}}));
  // The motion of the samples continues beyond the end of the grid.
  std::int64_t k = 0;
  const auto advance = [&] { return simulator.step(scene.time().time(++k)); };
  for (int i = 0; i < kWarm; ++i) {
    if (!advance().ok()) return state.SkipWithError("a step failed");
  }
  const Counters before = simulator.report().counters;
  for ([[maybe_unused]] auto _ : state) {
    if (const Status status = advance(); !status.arrived()) {
      return state.SkipWithError(std::string(name(status.code)).c_str());
    }
  }
  const Counters& after = simulator.report().counters;
  const auto over = [](std::int64_t work, std::int64_t of) {
    return static_cast<double>(work) / static_cast<double>(of);
  };
  state.counters["iterations"] =
      over(after.newton_iterations - before.newton_iterations, after.group_solutions - before.group_solutions);
  state.counters["factorizations"] = over(after.factorizations - before.factorizations, state.iterations());
  state.counters["substeps"] = over(after.substeps - before.substeps, state.iterations());
  const ErrorFigures& error = simulator.report().error;
  state.counters["position"] = error.position;
  state.counters["velocity"] = error.velocity;
  state.counters["acceleration"] = error.acceleration;
}

}  // namespace assur::bench
