#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>
#include <utility>

#include "assur/simulator.hpp"
#include "commands/commands.hpp"
#include "commands/interrupt.hpp"
#include "commands/run_parts.hpp"
#include "commands/run_report.hpp"
#include "commands/start_modes.hpp"
#include "output/motion_files.hpp"
#include "output/progress.hpp"
#include "pictures/outputs_over_time.hpp"
#include "status_text.hpp"

namespace assur::command {
namespace {

using output::Progress;

Trajectory follow(Simulator& simulator, Progress& progress, measure::StepTimes& times, std::int64_t steps) {
  const Interrupt interrupt;
  Trajectory trajectory = simulator.run(observer(progress, times, steps));
  progress.clear();
  return trajectory;
}

// With --animate, a scene that cannot be assembled is drawn before the error is reported.
Prepared prepare_or_show(const Scene& scene, const PrepareOptions& how, const std::vector<ModeChoice>& modes,
                         const RunOptions& options) {
  try {
    return prepare(scene, how, modes);
  } catch (const Error& error) {
    if (error.kind() == Error::Kind::numerical && !options.animate.empty()) {
      write_refused(scene, how, options.animate);
    }
    throw;
  }
}

// Why the run stopped early; empty if it did not.
std::string ending(const Report& report) {
  return report.status.arrived() ? "" : why_stopped(report.status, report.events, report.reached);
}

}  // namespace

int run(const Common& common, const RunOptions& options) {
  refuse_overwriting(common, outputs_of(options), {options.scene, options.ensemble});
  if (!options.ensemble.empty()) return run_ensemble(common, options);
  const PrepareOptions how = how_of(common, options);
  check_errors(options, how);
  const Scene scene = scene_of(common, options, common.set);
  const std::vector<ModeChoice> modes = chosen_modes(scene, options.start_modes);
  const Prepared prepared = prepare_or_show(scene, how, modes, options);
  Simulator simulator(prepared, settings_of(options));
  output::MotionFiles files(options.motion, options.motion_how);
  output::Replacement errors("--errors", options.errors), animation("--animate", options.animate),
      picture("--picture", options.picture), plot("--plot", options.plot);

  const std::int64_t steps = scene.time().steps();
  Progress progress(common.quiet);
  measure::StepTimes times(steps);
  const double begin = measure::StepTimes::steady();
  const Trajectory trajectory = follow(simulator, progress, times, steps);
  const double seconds = measure::StepTimes::steady() - begin;
  files.write(trajectory);

  Report report = simulator.report();
  if (options.reference && trajectory.rows() > 0 && report.status.code != Code::interrupted) {
    const ForwardError forward = forward_error(prepared, trajectory);
    const auto known = [](double error) { return std::isnan(error) ? std::nullopt : std::optional(error); };
    report.error.forward_position = known(forward.position);
    report.error.forward_velocity = known(forward.velocity);
    report.error.forward_acceleration = known(forward.acceleration);
  }
  std::optional<Certificate> certificate;
  if (options.certify && trajectory.rows() > 0 && report.status.code != Code::interrupted) {
    certificate = worst_of(certify(prepared, trajectory, settings_of(options)));
    if (certificate->why_not.empty()) report.error.certified_radius = certificate->radius;
  }
  output::RunSummary summary{.prepared = prepared,
                             .report = report,
                             .mode = how.mode,
                             .strategy = options.strategy,
                             .steps = std::max<std::int64_t>(static_cast<std::int64_t>(trajectory.rows()) - 1, 0),
                             .steps_wanted = steps,
                             .seconds = seconds,
                             .certificate = std::move(certificate)};
  if (summary.steps > 0 && how.mode == Mode::latency) summary.step_seconds = times.figures();
  print(common, options, summary);
  if (plot) {
    plot.stream() << pictures::outputs_over_time(prepared, trajectory, ending(report));
    plot.put();
  }
  bool all_written = !errors || write_errors(simulator, options, errors, progress);
  if (animation || picture) {
    const bool is_whole =
        write_animation(prepared, report, how, modes, options, animation ? &animation.stream() : nullptr,
                        picture ? &picture.stream() : nullptr, progress);
    all_written = is_whole && all_written;
    animation.put();
    picture.put();
  }
  const Exit exit = all_written ? exit_of(report.status.code) : kInterrupted;
  if (exit == kNumerical && !common.json) {
    std::cerr << "error: " << why_stopped(report.status, report.events, report.reached) << '\n';
  }
  return exit;
}

}  // namespace assur::command
