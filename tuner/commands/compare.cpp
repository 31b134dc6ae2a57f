// assur compare SCENE
#include <algorithm>
#include <ctime>
#include <iostream>
#include <optional>

#include "assur/machine.hpp"
#include "commands/commands.hpp"
#include "commands/interrupt.hpp"
#include "commands/print_result.hpp"
#include "db/libraries.hpp"
#include "measure/step_times.hpp"
#include "measure/work_precision.hpp"
#include "output/comparison_report.hpp"
#include "output/format.hpp"
#include "output/progress.hpp"
#include "output/replace_file.hpp"
#include "pictures/comparison_page.hpp"

namespace assur::command {
namespace {

constexpr std::int64_t kMostSteps = 1000;  // by default: the reference is slow

// For the race of all strategies together.
constexpr measure::RaceRules kRules{.seconds = 10, .least_rounds = 15, .most_rounds = 41, .hopeless = 100};

Scene scene_of(const Common& common, const CompareOptions& options) {
  Scene scene = open(common, options.scene, common.set, true);
  if (!options.outputs.empty()) scene = scene.with_outputs(options.outputs);
  TimeGrid grid = scene.time();
  const std::int64_t steps = options.steps.value_or(std::min(grid.steps(), kMostSteps));
  if (steps == grid.steps()) return scene;
  grid.end = grid.time(steps);
  return scene.with_time(grid);
}

// `auto` is always compared; naming it alone leaves out all others.
std::optional<std::vector<Strategy>> strategies_of(const CompareOptions& options) {
  if (options.strategies.empty()) return std::nullopt;
  std::vector<Strategy> all;
  for (const std::string& text : options.strategies) {
    if (text == "auto") continue;
    all.push_back(parse_strategy(text));
    if (all.back().run.chunks == 1) continue;
    refuse("--strategies", text + ": compare times single steps, and chunks have none; remove +chunks=");
  }
  return all;
}

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  localtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%d", &parts);
  return text;
}

std::vector<std::string> origin(const PerformanceModel& model) {
  const db::Library build = db::library_at_hand("assur");
  return {to_string(this_machine()), "assur " + std::string(db::assur_version()) + ", " + build.build + "; " + today(),
          model.samples() == 0 ? "No samples of this machine: auto decides by counts of operations."
                               : "auto uses " + output::counted(model.samples(), "sample") + ": " + model.source()};
}

bool has_time(const measure::WorkPrecision& result) {
  return std::any_of(result.rows.begin(), result.rows.end(), [](const auto& row) { return row.seconds.has_value(); });
}

}  // namespace

int compare(const Common& common, const CompareOptions& options) {
  const Scene scene = scene_of(common, options);
  refuse_overwriting(common, {{"--html", options.html}}, {options.scene});
  refuse_overwriting({{"--html", options.html}}, scene);
  const MachineModel known = machine_model_of(common);
  if (!common.quiet) {
    for (const std::string& message : known.messages) std::cerr << "note: " << message << '\n';
  }
  output::Replacement html("--html", options.html);

  using output::Progress;
  Progress progress(common.quiet, "candidate");
  const double begin = measure::StepTimes::steady();
  measure::WorkPrecisionOptions how;
  how.accuracies = options.accuracies;
  how.strategies = strategies_of(options);
  how.budget = common.threads > 0 ? ThreadBudget{common.threads} : this_machine().budget();
  how.model = known.model;
  how.rules = kRules;
  how.progress = [&](std::int64_t done, std::int64_t of) {
    progress.show(measure::StepTimes::steady() - begin, done, of);
  };
  const Interrupt interrupt;
  how.instruments.stop = [] { return Interrupt::requested(); };
  const measure::WorkPrecision result = measure::work_precision(scene, how);
  progress.clear();

  const output::ComparisonSummary summary{scene.name(), scene.time().step, options.accuracies, result};
  if (html) {
    html.stream() << pictures::comparison_page(summary, origin(*known.model));
    html.put();
  }
  print_result(common, summary);
  if (result.interrupted) return kInterrupted;
  return has_time(result) ? kDone : kNumerical;
}

}  // namespace assur::command
