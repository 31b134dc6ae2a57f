// assur run SCENE --errors FILE
#include "commands/interrupt.hpp"
#include "commands/run_parts.hpp"
#include "measure/diagnosis.hpp"

namespace assur::command {

void check_errors(const RunOptions& options, const PrepareOptions& how) {
  if (options.errors.empty() || how.mode == Mode::latency) return;
  throw Error(Error::Kind::input, {{"--errors",
                                    "it looks at one step after another; leave out what runs side by side: "
                                    "--mode throughput, --ensemble, +chunks="}});
}

bool write_errors(Simulator& simulator, const RunOptions& options, output::ErrorsCsv& csv, output::Progress& progress) {
  const Interrupt interrupt;
  measure::Diagnosis diagnosis(simulator.prepared(), options.reference);
  const double begin = measure::StepTimes::steady();
  std::int64_t substeps = 0;
  (void)simulator.run([&](std::int64_t done, std::int64_t of) {
    progress.show(measure::StepTimes::steady() - begin, done, of);
    const std::vector<measure::GroupErrors> groups = diagnosis.look(simulator);
    const std::int64_t counted = simulator.report().counters.substeps;
    csv.write(simulator.time(), counted - substeps, *simulator.prepared().structure, groups);
    substeps = counted;
    return !Interrupt::requested();
  });
  progress.clear();
  csv.close();
  return !Interrupt::requested();
}

}  // namespace assur::command
