// The page of `assur compare`: work-precision diagram, choices of `auto` for each accuracy, and all numbers.
#pragma once

#include <string>
#include <vector>

#include "output/comparison_report.hpp"
#include "pictures/html.hpp"

namespace assur::pictures {

// Diagram of error and time with logarithmic axes: a series for each knob, the Pareto front, and the choices of `auto`.
// If true errors are unknown: a sentence with the reason.
[[nodiscard]] std::string work_precision_figure(const output::ComparisonSummary& summary);

// The choices of `auto` for each accuracy.
[[nodiscard]] HtmlTable table_of_verdicts(const output::ComparisonSummary& summary);

// `origin`: machine, version and day, a sentence each.
[[nodiscard]] std::string comparison_page(const output::ComparisonSummary& summary,
                                          const std::vector<std::string>& origin);

}  // namespace assur::pictures
