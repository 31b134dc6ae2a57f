// The library against a program that a good engineer writes in an afternoon for one mechanism (afternoon.hpp). Both are
// timed in one run, on one thread, with the same outputs including velocity and acceleration; the largest relative
// residual of the timed steps is shown.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <string>
#include <vector>

#include "afternoon.hpp"
#include "assur/assur.hpp"
#include "chains.hpp"
#include "program.hpp"

namespace assur::bench {
namespace {

constexpr int kWarm = 10;  // steps
constexpr int kChunkedSteps = 4000;

struct Rival {
  const char* name;
  KluOptions options;
  double tolerance;
};
constexpr Rival kRivals[] = {
    {"afternoon", KluOptions::defaults, kRivalTolerance},
    {"afternoon, unscaled", KluOptions::unscaled, kRivalTolerance},
    {"afternoon, unscaled, to 1e-12", KluOptions::unscaled, 1e-12},  // saves an iteration in some steps
};

template <class Mechanism>
void time_rival(benchmark::State& state, const Mechanism& mechanism, const Rival& kind, double dt) {
  Afternoon<Mechanism> rival(mechanism, kind.options, kind.tolerance);
  std::int64_t k = 0;
  for (; k < kWarm; ++k) {
    if (!rival.step(dt * static_cast<double>(k))) return state.SkipWithError("a step failed");
  }
  double worst = 0;
  std::size_t iterations = 0;
  for ([[maybe_unused]] auto _ : state) {
    if (!rival.step(dt * static_cast<double>(k++))) return state.SkipWithError("a step failed");
    benchmark::DoNotOptimize(rival.acceleration().data());
    worst = std::max(worst, rival.residual());
    iterations += rival.iterations();
  }
  state.counters["iterations"] = static_cast<double>(iterations) / static_cast<double>(state.iterations());
  state.counters["position"] = worst;
}

// Runs a whole grid in chunks that fill the lanes: finds start postures, verifies every border and stores all results.
// `per_step` is the processor time of one step.
void time_chunks(benchmark::State& state, const Scene& scene, const std::string& strategy) {
  const TimeGrid& grid = scene.time();
  const Scene longer = scene.with_time({grid.start, grid.time(kChunkedSteps), grid.step});
  Simulator simulator(prepare(longer, {strategy, {}}));
  for ([[maybe_unused]] auto _ : state) {
    const Trajectory trajectory = simulator.run();
    if (!simulator.report().status.arrived()) return state.SkipWithError("a run failed");
    benchmark::DoNotOptimize(trajectory.values().data());
  }
  state.counters["per_step"] =
      benchmark::Counter(kChunkedSteps, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["position"] = simulator.report().error.position;
}

// Registers the rows of one mechanism; the outputs of `scene` are the unknowns of the rival.
template <class Mechanism>
void register_mechanism(const std::string& text, const Scene& scene, const Mechanism& mechanism) {
  const double dt = scene.time().step;
  for (const Rival& kind : kRivals) {
    benchmark::RegisterBenchmark((text + " " + kind.name).c_str(), time_rival<Mechanism>, mechanism, kind, dt);
  }
  for (const std::string strategy :
       {"irreducible/lanes+predict=hermite:5", "irreducible/lanes+once+predict=hermite:5",
        "irreducible/lanes:8+predict=hermite:5", "irreducible/lanes:8+once+predict=hermite:5",
        "irreducible/lanes:8+together+predict=hermite:5", "irreducible/lanes:16+together+predict=hermite:5",
        "irreducible/klu+predict=hermite:5", "irreducible/eigen+predict=hermite:5", "global/klu+predict=hermite:5"}) {
    if (!worth_timing(scene, strategy)) continue;
    benchmark::RegisterBenchmark((text + " " + strategy).c_str(), time_steps, scene, strategy);
  }
  for (const std::string strategy :
       {"irreducible/lanes:8+predict=hermite:5+chunks=8", "irreducible/lanes:16+predict=hermite:5+chunks=16"}) {
    benchmark::RegisterBenchmark((text + " " + strategy).c_str(), time_chunks, scene, strategy);
  }
}

// Chains of other groups, level after level and together.
void register_chain(const Scene& scene) {
  for (const std::string strategy :
       {"irreducible/lanes+predict=hermite:5", "irreducible/lanes:4+together+predict=hermite:5",
        "irreducible/lanes:8+together+predict=hermite:5", "irreducible/lanes:16+together+predict=hermite:5"}) {
    benchmark::RegisterBenchmark((scene.name() + ":64 " + strategy).c_str(), time_steps, scene, strategy);
  }
}

void register_all() {
  std::vector<std::string> points;
  for (int i = 1; i <= 6; ++i) points.push_back("B" + std::to_string(i));
  const std::string file = ASSUR_SOURCE_DIR "/scenes/stewart.json";
  register_mechanism("stewart", read_scene(file).with_outputs(points), StewartHandles());
  for (const int loops : {1, 10, 100, 1000}) {
    points.clear();
    for (int i = 1; i <= loops; ++i) points.push_back("B" + std::to_string(i));
    const std::string text = "four_bar:" + std::to_string(loops);
    register_mechanism(text, sample(text).with_outputs(points), FourBarChain(loops));
  }
  for (const Scene& chain : {slider_chain(), six_bar_chain(), spatial_chain()}) register_chain(chain);
}

}  // namespace
}  // namespace assur::bench

int main(int argc, char** argv) { return assur::bench::run_program(argc, argv, assur::bench::register_all); }
