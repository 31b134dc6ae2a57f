// assur run SCENE --errors FILE
#include <optional>
#include <utility>

#include "commands/interrupt.hpp"
#include "commands/run_parts.hpp"
#include "measure/true_posture.hpp"
#include "plan/preparation.hpp"
#include "simulation/simulator_access.hpp"

namespace assur::command {

void check_errors(const RunOptions& options, const PrepareOptions& how) {
  if (options.errors.empty() || how.mode == Mode::latency) return;
  throw Error(Error::Kind::input, {{"--errors",
                                    "it examines single steps; remove options that run steps side by side: "
                                    "--mode throughput, --ensemble, +chunks="}});
}

namespace {

// The errors of every group at the present posture.
std::vector<output::ErrorsRow> look(Simulator& simulator, measure::TruePosture* truth, std::int64_t iterations) {
  const GroupedSystem& structure = *preparation(simulator.prepared()).structure;
  const std::vector<double> posture = SimulatorAccess::posture(simulator);
  std::vector<output::ErrorsRow> rows;
  for (const GroupFigures& figures : simulator.examine()) {
    output::ErrorsRow& row = rows.emplace_back(output::ErrorsRow{figures});
    const SolvedGroup& group = structure.groups[static_cast<std::size_t>(figures.group)];
    if (truth != nullptr) row.error = truth->error(simulator.time(), posture, group.unknowns);
    if (structure.groups.size() == 1) row.iterations = iterations;
  }
  return rows;
}

}  // namespace

bool write_errors(Simulator& simulator, const RunOptions& options, output::ErrorsCsv& csv, output::Progress& progress) {
  const Interrupt interrupt;
  std::optional<measure::TruePosture> truth;
  if (options.reference) truth.emplace(simulator.prepared());
  const double begin = measure::StepTimes::steady();
  Counters before;
  (void)simulator.run([&](std::int64_t done, std::int64_t of) {
    progress.show(measure::StepTimes::steady() - begin, done, of);
    const Counters now = simulator.report().counters;
    const auto rows = look(simulator, truth ? &*truth : nullptr, now.newton_iterations - before.newton_iterations);
    csv.write(simulator.time(), now.substeps - before.substeps, *preparation(simulator.prepared()).structure, rows);
    before = now;
    return Interrupt::requested();
  });
  progress.clear();
  csv.close();
  return !Interrupt::requested();
}

}  // namespace assur::command
