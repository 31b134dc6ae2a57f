#include "commands/run_parts.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <string>

#include "assur/machine.hpp"
#include "commands/interrupt.hpp"
#include "output/format.hpp"

namespace assur::command {
namespace {

constexpr double kWholeSteps = 1e-9;  // allowed distance of the end from the grid, in steps

// The scene's grid, changed by the options.
TimeGrid grid_of(const TimeGrid& scene, const RunOptions& options) {
  TimeGrid grid = scene;
  grid.start = options.start.value_or(scene.start);
  grid.step = options.dt.value_or(scene.step);
  if (!(grid.step > 0)) refuse("--dt", "the scene has no time step; give one");
  if (options.steps) {
    grid.end = grid.time(*options.steps);
    return grid;
  }
  const double steps = (grid.end - grid.start) / grid.step;
  if (std::round(steps) < 1 || std::abs(steps - std::round(steps)) > kWholeSteps * std::max(1.0, steps)) {
    refuse(options.dt ? "--dt" : "--start", "from " + output::number(grid.start) + " s to the scene's end at " +
                                                output::number(grid.end) + " s there are " + output::number(steps) +
                                                " steps of " + output::number(grid.step) +
                                                " s, which is not a whole number >= 1; give the number with --steps");
  }
  return grid;
}

// Throws if latency is requested for a run that is not step by step.
void check_mode(const RunOptions& options, bool chunks) {
  if (options.mode != Mode::latency || (!chunks && options.ensemble.empty())) return;
  const std::string what = chunks ? "+chunks= runs parts of the time grid" : "--ensemble runs its members";
  refuse("--mode", "latency runs one mechanism step by step, but " + what + " side by side; remove one of them");
}

}  // namespace

std::vector<std::pair<std::string, std::string>> outputs_of(const RunOptions& options) {
  return {{"--csv", options.motion.csv}, {"--npy", options.motion.npy},  {"--hdf5", options.motion.hdf5},
          {"--errors", options.errors},  {"--animate", options.animate}, {"--picture", options.picture},
          {"--plot", options.plot}};
}

Scene scene_of(const Common& common, const RunOptions& options, const Parameters& set) {
  Scene scene = open(common, options.scene, set, true);
  refuse_overwriting(outputs_of(options), scene);
  if (!options.outputs.empty()) scene = scene.with_outputs(options.outputs);
  if (options.start || options.dt || options.steps) scene = scene.with_time(grid_of(scene.time(), options));
  return scene;
}

PrepareOptions how_of(const Common& common, const RunOptions& options) {
  const bool chunks = options.strategy != "auto" && parse_strategy(options.strategy).run.chunks > 1;
  check_mode(options, chunks);
  PrepareOptions how;
  how.strategy = options.strategy;
  how.without = options.without;
  how.accuracy = options.accuracy;
  how.machine_code = !options.no_machine_code;
  if (options.strategy == "auto" || !common.db.empty()) {
    const MachineModel known = machine_model_of(common);
    how.model = known.model;
    for (const std::string& message : known.messages) {
      if (!common.quiet) std::cerr << "note: " << message << '\n';
    }
  }
  if (common.threads > 0) how.budget = ThreadBudget{common.threads};
  how.mode = chunks || !options.ensemble.empty() ? Mode::throughput : options.mode.value_or(Mode::latency);
  return how;
}

StepSettings settings_of(const RunOptions& options) {
  StepSettings settings;
  settings.iterations = options.iterations;
  settings.stop = [] { return Interrupt::requested(); };
  if (options.pin) settings.pin_to = this_machine().cores;
  return settings;
}

Observer observer(output::Progress& progress, measure::StepTimes& times, std::int64_t steps) {
  return [&progress, &times, steps](std::int64_t done, std::int64_t of) {
    if (times.tick()) {
      // The first row is the start posture. Rows of chunks are shown as equal parts of the steps.
      progress.show(times.elapsed(), of > 1 ? (done - 1) * steps / (of - 1) : steps, steps);
      times.resume();
    }
    return Interrupt::requested();
  };
}

void print(const Common& common, const RunOptions& options, const output::RunSummary& summary) {
  if (common.json) {
    output::print(std::cout, to_json(summary));
  } else if (options.motion.csv != "-" || !common.quiet) {
    // Standard output holds nothing but the CSV if --csv - is given.
    output::Page page(options.motion.csv == "-" ? std::cerr : std::cout);
    output::print(page, summary);
  }
}

Exit exit_of(Code code) {
  if (code == Code::ok) return kDone;
  return code == Code::interrupted ? kInterrupted : kNumerical;
}

}  // namespace assur::command
