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
      {kHere, "How long single steps take", 0.03, one(step_histogram)},
  };
}

}  // namespace assur::report
