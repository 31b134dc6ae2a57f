// Output of `assur compare`: error and run time of all ways to run a scene.
#pragma once

#include <string>
#include <vector>

#include "measure/work_precision.hpp"
#include "output/json.hpp"
#include "output/page.hpp"

namespace assur::output {

struct ComparisonSummary {
  std::string scene;
  double step = 0;                 // s, of the time grid
  std::vector<double> accuracies;  // required accuracies
  const measure::WorkPrecision& result;
};

// The choice of `auto` for one accuracy, compared with the fastest way that reaches it.
struct Verdict {
  std::string strategy, step, reached;  // "-" if unknown
  std::string words;  // "on the front", "12 % slower than ...", "misses it", or the reason why it failed
};
[[nodiscard]] Verdict verdict(const measure::WorkPrecision& result, double accuracy);

// "0.0001,1e-06"
[[nodiscard]] std::string accuracies_text(const std::vector<double>& accuracies);

// "irreducible/klu --iterations 2", "irreducible/klu --accuracy 0.0001,1e-06": options of `assur run`.
[[nodiscard]] std::string way_text(const measure::WorkPrecisionRow& row);

[[nodiscard]] Json to_json(const ComparisonSummary& summary);
void print(Page& page, const ComparisonSummary& summary);

}  // namespace assur::output
