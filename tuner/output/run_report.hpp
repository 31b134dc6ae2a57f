// What `assur run` says about a run.
#pragma once

#include <optional>
#include <string>

#include "assur/plan.hpp"
#include "assur/report.hpp"
#include "measure/step_times.hpp"
#include "output/json.hpp"
#include "output/page.hpp"

namespace assur::output {

struct RunSummary {
  const Prepared& prepared;
  const Report& report;
  std::string strategy;    // as asked for
  std::int64_t steps = 0;  // done
  std::int64_t steps_wanted = 0;
  double seconds = 0;                                       // the run, start to end
  std::optional<measure::StepTimes::Figures> step_seconds;  // none if there was no step
};

[[nodiscard]] Json to_json(const RunSummary& summary);

void print(Page& page, const RunSummary& summary);

}  // namespace assur::output
