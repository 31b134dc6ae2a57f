// Error against run time for the shipped mechanisms, measured as by `assur compare`: the true error of each strategy,
// the Pareto front, and the choice of the dispatcher for each accuracy.
//
//   work_precision_bench [--quick] [--threads N] [--only TEXT] [--csv FILE]
#include <iostream>
#include <string>
#include <vector>

#include "assur/assur.hpp"
#include "measure/work_precision.hpp"
#include "output/comparison_report.hpp"
#include "output/csv_text.hpp"
#include "survey.hpp"

namespace assur::bench {
namespace {

constexpr std::int64_t kMostSteps = 500, kQuickSteps = 20;
const std::vector<double> kAccuracies = {1e-4, 1e-6, 1e-8, 1e-10, 1e-12};
const std::vector<std::string> kScenes = {"four_bar", "four_bar:16",     "slider_crank",      "andrews",
                                          "stewart",  "stewart:legs=22", "rings:legs=6,n=120"};

void write_csv(std::ostream& out, const std::string& scene, const measure::WorkPrecision& result) {
  for (const measure::WorkPrecisionRow& row : result.rows) {
    out << output::csv_text(scene) << ',' << output::csv_text(row.strategy) << ',' << row.iterations << ",\"";
    for (std::size_t i = 0; i < row.accuracies.size(); ++i) out << (i == 0 ? "" : " ") << row.accuracies[i];
    out << "\",";
    if (row.seconds) out << *row.seconds << ',' << row.spread;
    if (!row.seconds) out << ',';
    out << ',' << row.rounds << ',';
    if (row.error) out << row.error->position << ',' << row.error->velocity << ',' << row.error->acceleration;
    if (!row.error) out << ",,";
    out << ',';
    if (row.estimated) out << *row.estimated;
    out << ',' << row.on_front << ',' << output::csv_text(row.status) << '\n';
  }
}

void run(const Survey& survey, std::ostream& csv) {
  csv << "scene,strategy,iterations,auto_for,seconds_per_step,spread,rounds,forward_position,forward_velocity,"
         "forward_acceleration,estimated,on_front,status\n";
  measure::WorkPrecisionOptions how;
  how.accuracies = kAccuracies;
  how.budget = ThreadBudget{survey.threads};
  how.model = survey.model;
  how.rules = {.seconds = survey.quick ? 1.0 : 20.0,
               .least_rounds = survey.quick ? 3 : 15,
               .most_rounds = survey.quick ? 3 : 41,
               .hopeless = 100};
  for (const std::string& text : kScenes) {
    if (!survey.wants(text)) continue;
    const Scene scene = measure::first_steps(open_scene(text), survey.quick ? kQuickSteps : kMostSteps);
    const measure::WorkPrecision result = measure::work_precision(scene, how);
    output::Page page(std::cout);
    page.gap();
    print(page, {text, scene.time().step, kAccuracies, result});
    std::cout.flush();
    write_csv(csv, text, result);
  }
}

}  // namespace
}  // namespace assur::bench

int main(int argc, char** argv) {
  return assur::bench::run_survey(argc, argv, "Error against run time of the shipped mechanisms.", assur::bench::run);
}
