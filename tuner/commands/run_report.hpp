// Output of `assur run`.
#pragma once

#include <optional>
#include <string>

#include "assur/plan.hpp"
#include "assur/report.hpp"
#include "commands/members.hpp"
#include "measure/step_times.hpp"
#include "output/json.hpp"
#include "output/page.hpp"

namespace assur::output {

struct RunSummary {
  const Prepared& prepared;
  const Report& report;
  Mode mode = Mode::latency;
  std::string strategy = {};                                     // text of the requested strategy
  std::int64_t steps = 0;                                        // finished steps, of all members together
  std::int64_t steps_wanted = 0;                                 // of each member
  double seconds = 0;                                            // duration of the run
  double prepare_seconds = 0;                                    // duration of the preparation of an ensemble, s
  std::optional<measure::StepTimes::Figures> step_seconds = {};  // in latency mode; empty without steps
  const Members* members = nullptr;                              // of an ensemble
  std::optional<Certificate> certificate = {};                   // of the run, if requested

  // Mean time of a step, s: in throughput mode steps begin and end together, so that only their mean is known.
  [[nodiscard]] double mean_step() const { return seconds / static_cast<double>(steps); }
};

[[nodiscard]] Json to_json(const RunSummary& summary);

void print(Page& page, const RunSummary& summary);

}  // namespace assur::output
