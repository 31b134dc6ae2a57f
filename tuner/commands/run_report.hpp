// What `assur run` says about a run.
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
  std::string strategy = {};                                     // as asked for
  std::int64_t steps = 0;                                        // done, of all members
  std::int64_t steps_wanted = 0;                                 // of each member
  double seconds = 0;                                            // the run, start to end
  double prepare_seconds = 0;                                    // of an ensemble
  std::optional<measure::StepTimes::Figures> step_seconds = {};  // in latency mode; none if there was no step
  const Members* members = nullptr;                              // of an ensemble
  std::optional<Certificate> certificate = {};                   // of the run, if it was asked for

  // s: in throughput mode steps begin and end together, and only their mean over the whole run is known.
  [[nodiscard]] double mean_step() const { return seconds / static_cast<double>(steps); }
};

[[nodiscard]] Json to_json(const RunSummary& summary);

void print(Page& page, const RunSummary& summary);

}  // namespace assur::output
