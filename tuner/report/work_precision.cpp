#include "measure/work_precision.hpp"

#include <algorithm>

#include "measure/step_times.hpp"
#include "output/comparison_report.hpp"
#include "output/format.hpp"
#include "pictures/comparison_page.hpp"
#include "report/sections.hpp"

namespace assur::report {
namespace {

constexpr double kShort = 8;                             // s; a shorter budget only suffices for the smallest mechanism
constexpr double kRace = 10;                             // s, upper limit for all strategies of one scene
constexpr std::int64_t kQuickSteps = 100, kSteps = 300;  // few, because the reference is slow

std::vector<std::string> scenes(const Conditions& conditions) {
  if (conditions.seconds < kShort) return {"four_bar"};
  if (conditions.quick) return {"stewart"};
  return {"stewart", "four_bar:10", "andrews", "slider_crank", "rings:legs=6,n=24"};
}

void add(Section& out, const std::string& scene, const measure::WorkPrecision& result) {
  for (const measure::WorkPrecisionRow& row : result.rows) {
    if (!row.seconds) continue;
    std::string origin = "measured";
    if (row.on_front) origin += ", on the front";
    if (!row.picked.empty()) origin += ", chosen by auto for " + output::accuracies_text(row.picked);
    out.measurements.push_back({scene, output::way_text(row), "seconds per step", "s", *row.seconds, origin,
                                static_cast<int>(row.rounds), row.spread / *row.seconds, row.worst_error()});
  }
}

}  // namespace

Section work_precision(const Knowledge& knowledge, const Conditions& conditions) {
  const double begin = measure::StepTimes::steady();
  Section out{"work-precision", "Error against run time"};
  out.body = paragraph(
      "Time of a step and true error of all strategies for a mechanism. The error is the largest of position, velocity "
      "and "
      "acceleration over the run, against a solution in quadruple precision. No strategy beats those of the Pareto "
      "front "
      "in both; diamonds are the choices of auto for the accuracies of the dotted lines.");
  const std::vector<std::string> names = scenes(conditions);
  double longest = 0;
  for (const std::string& name : names) {
    const double now = measure::StepTimes::steady() - begin;
    if (conditions.interrupted() || (longest > 0 && now + longest > conditions.seconds)) break;
    const Scene scene =
        measure::first_steps(sample(name), conditions.quick || conditions.seconds < kShort ? kQuickSteps : kSteps);
    measure::WorkPrecisionOptions how;
    how.accuracies = {1e-4, 1e-6, 1e-8, 1e-10, 1e-12};
    how.budget = ThreadBudget{conditions.threads};
    how.model = knowledge.known.model;
    how.rules = {.seconds = std::clamp(0.4 * conditions.seconds / static_cast<double>(names.size()), 0.5, kRace),
                 .least_rounds = 11,
                 .most_rounds = 41,
                 .hopeless = 100};
    how.instruments = conditions.instruments();
    const measure::WorkPrecision result = measure::work_precision(scene, how);
    longest = std::max(longest, measure::StepTimes::steady() - begin - now);
    if (result.interrupted) break;
    const output::ComparisonSummary summary{name, scene.time().step, how.accuracies, result};
    out.body +=
        "<h4>" + pictures::escaped(name) + "</h4>\n" +
        paragraph(output::counted(result.steps, "step") + " of " + output::number(scene.time().step) + " s.", "faint");
    out.body += pictures::work_precision_figure(summary) + html(pictures::table_of_verdicts(summary));
    add(out, name, result);
  }
  return out;
}

}  // namespace assur::report
