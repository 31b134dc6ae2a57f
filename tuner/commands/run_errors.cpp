// assur run SCENE --errors FILE
#include <optional>
#include <ostream>
#include <vector>

#include "commands/interrupt.hpp"
#include "commands/run_parts.hpp"
#include "measure/true_posture.hpp"
#include "output/csv_text.hpp"
#include "plan/preparation.hpp"
#include "simulation/simulator_access.hpp"

namespace assur::command {

void check_errors(const RunOptions& options, const PrepareOptions& how) {
  if (options.errors.empty() || how.mode == Mode::latency) return;
  refuse("--errors",
         "it examines single steps; remove options that run steps side by side: "
         "--mode throughput, --ensemble, +chunks=");
}

namespace {

template <class T>
void cell(std::ostream& out, const std::optional<T>& value) {
  out << ',';
  if (value) out << *value;
}

// Writes the errors of every group at the present posture, of which that against the truth is relative to the
// characteristic length. iterations, substeps: since the posture before; the iterations of single groups are unknown.
void write_rows(std::ostream& out, Simulator& simulator, measure::TruePosture* truth, std::int64_t iterations,
                std::int64_t substeps) {
  const GroupedSystem& structure = *preparation(simulator.prepared()).structure;
  const std::vector<double> posture = SimulatorAccess::posture(simulator);
  for (const GroupFigures& f : simulator.examine()) {
    const SolvedGroup& group = structure.groups[static_cast<std::size_t>(f.group)];
    out << simulator.time() << ',' << output::csv_text(group.name) << ',' << f.residual << ',' << f.estimated_error;
    cell(out, truth != nullptr ? std::optional(truth->error(simulator.time(), posture, group.unknowns)) : std::nullopt);
    out << ',' << f.condition;
    cell(out, structure.groups.size() == 1 ? std::optional(iterations) : std::nullopt);
    out << ',' << substeps << '\n';
  }
}

}  // namespace

bool write_errors(Simulator& simulator, const RunOptions& options, output::Replacement& csv,
                  output::Progress& progress) {
  const Interrupt interrupt;
  std::optional<measure::TruePosture> truth;
  if (options.reference) truth.emplace(simulator.prepared());
  csv.stream().precision(17);  // a time reads back as the same double as in the CSV of the motion
  csv.stream() << "t,group,residual,estimated,error,condition,iterations,substeps\n";
  const double begin = measure::StepTimes::steady();
  Counters before;
  (void)simulator.run([&](std::int64_t done, std::int64_t of) {
    progress.show(measure::StepTimes::steady() - begin, done, of);
    const Counters now = simulator.report().counters;
    write_rows(csv.stream(), simulator, truth ? &*truth : nullptr, now.newton_iterations - before.newton_iterations,
               now.substeps - before.substeps);
    csv.check();
    before = now;
    return Interrupt::requested();
  });
  progress.clear();
  csv.put();
  return !Interrupt::requested();
}

}  // namespace assur::command
