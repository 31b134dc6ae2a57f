// `assur compare` as a page: the work-precision diagram, what `auto` makes of each accuracy, and every number.
#pragma once

#include <string>
#include <vector>

#include "output/comparison_report.hpp"
#include "pictures/html.hpp"

namespace assur::pictures {

// Error against time, logarithmic; a series for each knob, the Pareto front, and what `auto` took. Without a yardstick:
// that and why.
[[nodiscard]] std::string work_precision_figure(const output::ComparisonSummary& summary);

// What `auto` makes of each accuracy.
[[nodiscard]] HtmlTable table_of_verdicts(const output::ComparisonSummary& summary);

// `origin`: machine, version and day, a sentence each.
[[nodiscard]] std::string comparison_page(const output::ComparisonSummary& summary,
                                          const std::vector<std::string>& origin);

}  // namespace assur::pictures
