#include "report/contents.hpp"

#include "report/sections.hpp"

namespace assur::report {

std::vector<Planned> contents(const Knowledge& knowledge) {
  const auto one = [&knowledge](Section (*make)(const Knowledge&, const Conditions&)) {
    return [&knowledge, make](const Conditions& conditions) { return std::vector{make(knowledge, conditions)}; };
  };
  constexpr const char* kHere = "This machine";
  return {
      {kHere, "Which strategy wins", 0.01, one(winners)},
      {kHere, "What auto loses", 0.35, one(regret)},
      {kHere, "Error against run time", 0.25, one(work_precision)},
      {kHere, "How it scales: threads, lanes, variants", 0.25, one(scaling)},
      {kHere, "How long single steps take", 0.06, one(step_histogram)},
      {kHere, "What tuning costs, and what it saves", 0.04, one(tuning_cost)},
      {kHere, "How well times are predicted", 0.04, one(model_fit)},
  };
}

}  // namespace assur::report
