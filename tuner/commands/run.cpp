#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iostream>
#include <string>
#include <utility>

#include "assur/simulator.hpp"
#include "commands/commands.hpp"
#include "commands/interrupt.hpp"
#include "output/format.hpp"
#include "output/progress.hpp"
#include "output/run_report.hpp"
#include "output/status_text.hpp"

namespace assur::command {
namespace {

using output::Progress;

constexpr double kWholeSteps = 1e-9;  // share of a step that the end may be off the grid, as in scene files

// The scene's grid with what the options replace.
TimeGrid grid_of(const TimeGrid& scene, const RunOptions& options) {
  TimeGrid grid = scene;
  grid.start = options.start.value_or(scene.start);
  grid.step = options.dt.value_or(scene.step);
  if (!(grid.step > 0)) throw Error(Error::Kind::input, {{"--dt", "the scene has no time step; say how long one is"}});
  if (options.steps) {
    grid.end = grid.time(*options.steps);
    return grid;
  }
  const double steps = (grid.end - grid.start) / grid.step;
  if (std::round(steps) < 1 || std::abs(steps - std::round(steps)) > kWholeSteps * std::max(1.0, steps)) {
    throw Error(Error::Kind::input,
                {{options.dt ? "--dt" : "--start",
                  "from " + output::number(grid.start) + " s to the scene's end at " + output::number(grid.end) +
                      " s it takes " + output::number(steps) + " steps of " + output::number(grid.step) +
                      " s, where a whole number from 1 is wanted; say how many with --steps"}});
  }
  return grid;
}

Scene scene_of(const Common& common, const RunOptions& options) {
  Scene scene = open_scene(options.scene, common.set);
  if (!options.outputs.empty()) scene = scene.with_outputs(options.outputs);
  if (options.start || options.dt || options.steps) scene = scene.with_time(grid_of(scene.time(), options));
  return scene;
}

// Where --csv goes. Opened before the run: an hour's work is not lost to a misspelt folder.
class CsvFile {
 public:
  explicit CsvFile(std::string name) : name_(std::move(name)) {
    if (name_.empty() || name_ == "-") return;
    errno = 0;
    file_.open(name_);
    if (!file_) fail();
  }

  void write(const Trajectory& trajectory) {
    if (name_.empty()) return;
    std::ostream& out = name_ == "-" ? std::cout : file_;
    errno = 0;
    write_csv(out, trajectory);
    out.flush();
    if (!out) fail();
  }

 private:
  [[noreturn]] void fail() const {
    const std::string why = errno != 0 ? std::strerror(errno) : "unknown reason";
    throw Error(Error::Kind::environment,
                {{"--csv", "cannot write " + (name_ == "-" ? "to standard output" : name_) + ": " + why}});
  }

  std::string name_;
  std::ofstream file_;
};

Trajectory follow(Simulator& simulator, Progress& progress, measure::StepTimes& times) {
  const Interrupt interrupt;
  Trajectory trajectory = simulator.run([&](std::int64_t done, std::int64_t of) {
    if (times.tick()) {
      progress.show(times.elapsed(), done - 1, of - 1);  // the first row is the start posture
      times.resume();
    }
    return !Interrupt::requested();
  });
  progress.clear();
  return trajectory;
}

void explain_failure(const Report& report) {
  std::cerr << "error: ";
  const bool has_event = !report.events.empty() && report.events.back().kind == report.status.code;
  if (has_event) {
    const Event& e = report.events.back();
    std::cerr << output::time_of(e) << (e.group.empty() ? "" : ", group " + e.group) << ": ";
  } else {
    std::cerr << "after t = " << output::number(report.reached) << " s: ";
  }
  std::cerr << output::explained(report.status.code) << '\n';
}

Exit exit_of(Code code) {
  if (code == Code::ok) return kDone;
  return code == Code::interrupted ? kInterrupted : kNumerical;
}

}  // namespace

int run(const Common& common, const RunOptions& options) {
  const Scene scene = scene_of(common, options);
  PrepareOptions how{.strategy = options.strategy, .controlled = {}};
  if (common.threads > 0) how.budget = ThreadBudget{common.threads};
  const Prepared prepared = prepare(scene, how);
  Simulator simulator(prepared, {.iterations = options.iterations});
  CsvFile csv(options.csv);

  const std::int64_t steps = scene.time().steps();
  Progress progress(std::cerr, common.quiet ? Progress::Style::none : Progress::style_of_standard_error());
  measure::StepTimes times(steps);
  const double begin = measure::StepTimes::steady();
  const Trajectory trajectory = follow(simulator, progress, times);
  const double seconds = measure::StepTimes::steady() - begin;
  csv.write(trajectory);

  Report report = simulator.report();
  if (options.reference && trajectory.rows() > 0 && report.status.code != Code::interrupted) {
    const ForwardError forward = forward_error(prepared, trajectory);
    report.error.forward_position = forward.position;
    report.error.forward_velocity = forward.velocity;
    report.error.forward_acceleration = forward.acceleration;
  }
  const auto done = static_cast<std::int64_t>(trajectory.rows()) - 1;
  output::RunSummary summary{prepared, report, options.strategy, std::max<std::int64_t>(done, 0), steps, seconds, {}};
  if (done > 0) summary.step_seconds = times.figures();

  if (common.json) {
    output::print(std::cout, to_json(summary));
    return exit_of(report.status.code);
  }
  if (options.csv != "-" || !common.quiet) {
    // A CSV on standard output stands there alone.
    output::Page page(options.csv == "-" ? std::cerr : std::cout);
    print(page, summary);
  }
  if (exit_of(report.status.code) == kNumerical) explain_failure(report);
  return exit_of(report.status.code);
}

}  // namespace assur::command
