// What `assur compare` says: error against run time of a scene.
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
  std::vector<double> accuracies;  // that were asked for
  const measure::WorkPrecision& result;
};

// What `auto` makes of one accuracy, beside the fastest way that reaches it.
struct Verdict {
  std::string strategy, step, reached;  // "-" for what is not known
  std::string words;                    // "on the front", "12 % slower than ...", "misses it", why it failed
};
[[nodiscard]] Verdict verdict(const measure::WorkPrecision& result, double accuracy);

// "0.0001,1e-06"
[[nodiscard]] std::string accuracies_text(const std::vector<double>& accuracies);

// "irreducible/klu --iterations 2", "irreducible/klu --accuracy 0.0001,1e-06": any of these is what `assur run` takes.
[[nodiscard]] std::string way_text(const measure::WorkPrecisionRow& row);

[[nodiscard]] Json to_json(const ComparisonSummary& summary);
void print(Page& page, const ComparisonSummary& summary);

}  // namespace assur::output
