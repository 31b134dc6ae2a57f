// Error against run time of the shipped mechanisms, as `assur compare` measures it: each strategy with its true error,
// the Pareto front, and the dispatcher's choice for each accuracy.
//
//   work_precision_bench [--quick] [--threads N] [--only TEXT] [--csv FILE]
#include <algorithm>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "assur/assur.hpp"
#include "machine.hpp"
#include "measure/work_precision.hpp"
#include "output/comparison_report.hpp"
#include "survey.hpp"

namespace assur::bench {
namespace {

constexpr std::int64_t kMostSteps = 500, kQuickSteps = 20;
const std::vector<double> kAccuracies = {1e-4, 1e-6, 1e-8, 1e-10, 1e-12};
const std::vector<std::string> kScenes = {"four_bar", "four_bar:16",     "slider_crank",      "andrews",
                                          "stewart",  "stewart:legs=22", "rings:legs=6,n=120"};

Scene scene_of(const std::string& text, std::int64_t most) {
  const Scene scene = open_scene(text);
  TimeGrid grid = scene.time();
  if (grid.steps() <= most) return scene;
  grid.end = grid.time(most);
  return scene.with_time(grid);
}

void write_csv(std::ostream& out, const std::string& scene, const measure::WorkPrecision& result) {
  for (const measure::WorkPrecisionRow& row : result.rows) {
    out << '"' << scene << "\",\"" << row.strategy << "\"," << row.iterations << ",\"";
    for (std::size_t i = 0; i < row.accuracies.size(); ++i) out << (i == 0 ? "" : " ") << row.accuracies[i];
    out << "\",";
    if (row.seconds) out << *row.seconds << ',' << row.spread;
    if (!row.seconds) out << ',';
    out << ',' << row.rounds << ',';
    if (row.error) out << row.error->position << ',' << row.error->velocity << ',' << row.error->acceleration;
    if (!row.error) out << ",,";
    out << ',';
    if (row.estimated) out << *row.estimated;
    out << ',' << row.on_front << ",\"" << row.status << "\"\n";
  }
}

int run(const SurveyOptions& o) {
  for (const auto& [name, text] : machine_facts()) std::cout << name << ": " << text << '\n';
  const MachineModel& known = machine_model();
  for (const std::string& message : known.messages) std::cout << message << '\n';
  std::cout << "model: " << known.model->samples() << " samples, " << known.model->source() << '\n';
  std::ofstream csv;
  if (!o.csv.empty()) {
    csv.open(o.csv);
    csv << "scene,strategy,iterations,auto_for,seconds_per_step,spread,rounds,forward_position,forward_velocity,"
           "forward_acceleration,estimated,on_front,status\n";
  }
  measure::WorkPrecisionOptions how;
  how.accuracies = kAccuracies;
  how.budget = o.threads > 0 ? ThreadBudget{o.threads} : this_machine().budget();
  how.model = known.model;
  how.rules = {.seconds = o.quick ? 1.0 : 20.0,
               .least_rounds = o.quick ? 3 : 15,
               .most_rounds = o.quick ? 3 : 41,
               .hopeless = 100};
  for (const std::string& text : kScenes) {
    if (text.find(o.only) == std::string::npos) continue;
    const Scene scene = scene_of(text, o.quick ? kQuickSteps : kMostSteps);
    const measure::WorkPrecision result = measure::work_precision(scene, how);
    output::Page page(std::cout);
    page.gap();
    print(page, {text, scene.time().step, kAccuracies, result});
    std::cout.flush();
    if (csv.is_open()) write_csv(csv, text, result);
  }
  csv.close();
  if (!o.csv.empty() && !csv) throw Error(Error::Kind::environment, "--csv: cannot write " + o.csv);
  return 0;
}

}  // namespace
}  // namespace assur::bench

int main(int argc, char** argv) {
  return assur::bench::run_survey(argc, argv, "Error against run time of the shipped mechanisms.", assur::bench::run);
}
