// assur run SCENE --ensemble FILE
#include <algorithm>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "assur/ensemble.hpp"
#include "assur/machine.hpp"
#include "commands/commands.hpp"
#include "commands/interrupt.hpp"
#include "commands/members.hpp"
#include "commands/run_parts.hpp"
#include "commands/run_report.hpp"
#include "commands/start_modes.hpp"
#include "equations/outputs.hpp"
#include "output/format.hpp"
#include "output/motion_files.hpp"
#include "output/progress.hpp"
#include "parallel/free_memory.hpp"
#include "plan/preparation.hpp"

namespace assur::command {
namespace {

using measure::StepTimes;
using output::Progress;

void check(const RunOptions& options, const PrepareOptions& how) {
  if (how.strategy != "auto" && parse_strategy(how.strategy).run.chunks > 1) {
    refuse("--ensemble", "its members use the lanes and threads; remove +chunks= from the strategy");
  }
  if (!options.start_modes.modes.empty()) {
    refuse("--start-mode", "the modes of each member have numbers of their own; choose them by --guess");
  }
  if (options.reference) refuse("--reference", "it compares a single mechanism; run one member with --set");
  if (options.certify) refuse("--certify", "it certifies a single mechanism; run one member with --set");
  if (!options.animate.empty()) refuse("--animate", "it shows a single mechanism; run one member with --set");
  if (!options.picture.empty()) refuse("--picture", "it shows a single mechanism; run one member with --set");
  if (!options.plot.empty()) refuse("--plot", "it shows a single mechanism; run one member with --set");
}

// The variants with the values of --set added.
std::vector<Parameters> variants_of(const Common& common, const RunOptions& options) {
  std::vector<Parameters> variants = read_variants(options.ensemble);
  for (const auto& [name, value] : common.set) {
    if (variants.front().contains(name)) {
      refuse("--set", "\"" + name + "\" is also a column of " + options.ensemble + "; give it only once");
    }
    for (Parameters& v : variants) v.emplace(name, value);
  }
  return variants;
}

// Throws if the time grid of a member differs from that of the first.
void check_grid(const TimeGrid& grid, const TimeGrid& first) {
  if (grid.start == first.start && grid.end == first.end && grid.step == first.step) return;
  throw Error(Error::Kind::input, "its time grid differs from that of the first member");
}

constexpr std::int64_t kTried = 200;  // members prepared to estimate the memory of one

// Throws if the results do not fit into memory, before all members are prepared.
void check_room(const Prepared& first, std::int64_t members) {
  const double rows = static_cast<double>(members) * static_cast<double>(first.time().steps() + 1);
  const auto columns = column_names(*preparation(first).structure->system).size();
  require_memory(
      rows * static_cast<double>(columns) * sizeof(double),
      output::number(rows) + " times x " + std::to_string(columns) + " values of " + output::counted(members, "member"),
      "ask for fewer outputs, a shorter run or fewer members");
}

Ensemble prepare_all(const Common& common, const std::vector<Parameters>& variants, const RunOptions& options,
                     const PrepareOptions& how, Progress& progress) {
  const double begin = StepTimes::steady();
  const auto all = static_cast<std::int64_t>(variants.size());
  std::optional<TimeGrid> first;
  const double taken = taken_memory();
  Ensemble ensemble(
      variants.size(),
      [&](std::size_t i) {
        progress.show(StepTimes::steady() - begin, static_cast<std::int64_t>(i), all);
        if (static_cast<std::int64_t>(i) == kTried) {
          require_memory((taken_memory() - taken) / kTried * static_cast<double>(all - kTried),
                         output::counted(all, "member"), "run fewer at a time");
        }
        const Scene scene = scene_of(common, options, variants[i]);
        if (first) check_grid(scene.time(), *first);
        Prepared prepared = prepare(scene, how, chosen_modes(scene, options.start_modes));
        if (!first) check_room(prepared, all);
        first = scene.time();
        return prepared;
      },
      settings_of(options));
  progress.clear();
  return ensemble;
}

std::int64_t steps_of(const EnsembleTrajectory& trajectory) {
  std::int64_t steps = 0;
  for (std::size_t i = 0; i < trajectory.members(); ++i) {
    steps += std::max<std::int64_t>(static_cast<std::int64_t>(trajectory.rows(i)) - 1, 0);
  }
  return steps;
}

void explain(const output::Members& members) {
  if (members.failed.empty()) return;
  const output::Members::Failure& first = members.failed.front();
  std::cerr << "error: " << members.failures() << "; the first: " << output::to_string(first) << '\n';
}

}  // namespace

int run_ensemble(const Common& common, const RunOptions& options) {
  PrepareOptions how = how_of(common, options);
  check(options, how);
  check_errors(options, how);
  if (!how.budget) how.budget = this_machine().budget();  // determined once for all members
  const std::vector<Parameters> variants = variants_of(common, options);
  Progress preparing(common.quiet, "member");
  const double start = StepTimes::steady();
  Ensemble ensemble = prepare_all(common, variants, options, how, preparing);
  output::MotionFiles files(options.motion, options.motion_how);

  const std::int64_t steps = ensemble.prepared().scene()->time().steps();
  const std::int64_t member_steps = steps * static_cast<std::int64_t>(variants.size());
  Progress progress(common.quiet);
  StepTimes times(0);
  const double begin = StepTimes::steady();
  const EnsembleTrajectory trajectory = [&] {
    const Interrupt interrupt;
    return ensemble.run(observer(progress, times, member_steps));
  }();
  const double seconds = StepTimes::steady() - begin;
  progress.clear();
  files.write(trajectory);

  const output::Members members = output::members_of(ensemble.outcomes(), variants);
  Report report = ensemble.report();
  report.status.code = members.code();
  print(common, options,
        {.prepared = ensemble.prepared(),
         .report = report,
         .mode = Mode::throughput,
         .strategy = options.strategy,
         .steps = steps_of(trajectory),
         .steps_wanted = steps,
         .seconds = seconds,
         .prepare_seconds = begin - start,
         .members = &members});
  if (!common.json) explain(members);
  return exit_of(report.status.code);
}

}  // namespace assur::command
