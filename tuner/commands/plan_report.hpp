// Output of `assur plan`: the plan, the reasons, and the alternatives.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "assur/plan.hpp"
#include "output/json.hpp"
#include "output/page.hpp"

namespace assur::output {

struct PlanSummary {
  const Prepared& prepared;
  Mode mode = Mode::latency;
  ThreadBudget budget;
  const PerformanceModel& model;
  const std::vector<std::string>& messages;        // of the databases
  std::vector<std::vector<Candidate>> candidates;  // for each class
  std::optional<std::string> machine_code;         // Simulator::machine_code(); none: not asked
};

[[nodiscard]] Json to_json(const PlanSummary& summary);
void print(Page& page, const PlanSummary& summary);

}  // namespace assur::output
