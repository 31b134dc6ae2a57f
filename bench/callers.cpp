// The calls that callers from other languages are measured against, in C++:
//   callers_bench loop STEPS        a control loop of a four-bar: set, step, one output; prints ns for one turn of it
//   callers_bench c STEPS           the same through the C interface
//   callers_bench ensemble MEMBERS  four-bars with couplers from a table, bound and run over 200 steps; prints s
// bench/callers.py runs them interleaved with the same calls in Python.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "assur/assur.h"
#include "assur/assur.hpp"

namespace assur::bench {
namespace {

double seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

Scene four_bar() {
  SceneBuilder b("four_bar", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("D", {3, 0, 0}).point("B", {1, 0, 0}).point("C", {2.5, 2.4, 0});
  b.constrain("crank", Distance{"A", "B", 1}).constrain("coupler", Distance{"B", "C", 3});
  b.constrain("rocker", Distance{"D", "C", 2.5});
  b.drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, 6.283185307179586})});
  b.output("C").time(0, 1, 0.005);
  return std::move(b).build();
}

void loop(int steps) {
  Simulator simulator(prepare(four_bar(), {.controlled = {"motor"}, .budget = ThreadBudget{1}}));
  const DriverHandle motor = simulator.driver("motor");
  const std::size_t x = simulator.index("C.x");
  double sum = 0;
  const double begin = seconds();
  for (int k = 1; k <= steps; ++k) {
    simulator.set(motor, 0.01 * k, 2.0);
    if (!simulator.step().arrived()) std::exit(1);
    sum += simulator.outputs()[x];
  }
  std::printf("%.3f %.17g\n", 1e9 * (seconds() - begin) / steps, sum);
}

void c_loop(int steps) {
  const std::string text = write_scene(four_bar());
  const char* const controlled[] = {"motor"};
  assur_options options = ASSUR_OPTIONS;
  options.controlled = controlled;
  options.controlled_count = options.threads = 1;
  assur_scene* scene = nullptr;
  assur_plan* plan = nullptr;
  assur_simulator* simulator = nullptr;
  std::size_t motor = 0, x = 0;
  const bool made = assur_scene_parse(text.data(), text.size(), &scene) == ASSUR_OK &&
                    assur_prepare(scene, &options, &plan) == ASSUR_OK &&
                    assur_simulator_new(plan, nullptr, &simulator) == ASSUR_OK &&
                    assur_simulator_driver(simulator, "motor", &motor) == ASSUR_OK &&
                    assur_simulator_column(simulator, "C.x", &x) == ASSUR_OK;
  if (!made) std::exit(1);
  double sum = 0;
  const double begin = seconds();
  for (int k = 1; k <= steps; ++k) {
    assur_status status;
    (void)assur_simulator_set(simulator, motor, 0.01 * k, 2.0, 0);
    if (assur_arrived(assur_simulator_step(simulator, &status)) == 0) std::exit(1);
    sum += assur_simulator_outputs(simulator)[x];
  }
  std::printf("%.3f %.17g\n", 1e9 * (seconds() - begin) / steps, sum);
  assur_simulator_free(simulator);
  assur_plan_free(plan);
  assur_scene_free(scene);
}

void ensemble(std::size_t members) {
  std::vector<double> couplers(members), others(members);
  for (std::size_t i = 0; i < members; ++i) {
    couplers[i] = others[members - 1 - i] = 2.8 + 0.4 * static_cast<double>(i) / static_cast<double>(members - 1);
  }
  PrepareOptions options;
  options.budget = ThreadBudget{1};
  options.mode = Mode::throughput;
  Ensemble designs(four_bar(), {"coupler"}, couplers, options);
  (void)designs.run();
  const double begin = seconds();
  designs.bind(others);
  const EnsembleTrajectory motion = designs.run();
  const double end = seconds();
  double sum = 0;
  for (std::size_t i = 0; i < members; ++i) sum += motion(i, 200, 0);
  std::printf("%.6f %.17g\n", end - begin, sum);
}

}  // namespace
}  // namespace assur::bench

int main(int count, char** arguments) {
  const std::string what = count > 2 ? arguments[1] : "";
  if (what == "loop") {
    assur::bench::loop(std::max(std::atoi(arguments[2]), 1));
  } else if (what == "c") {
    assur::bench::c_loop(std::max(std::atoi(arguments[2]), 1));
  } else if (what == "ensemble") {
    assur::bench::ensemble(static_cast<std::size_t>(std::max(std::atoi(arguments[2]), 2)));
  } else {
    std::fputs("usage: callers_bench loop STEPS | c STEPS | ensemble MEMBERS\n", stderr);
    return 2;
  }
}
