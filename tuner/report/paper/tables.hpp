// The paper's tables and figures again, theirs beside ours: one section of the report for each.
#pragma once

#include <vector>

#include "report/paper/runs.hpp"
#include "report/section.hpp"

namespace assur::report {

// Runs what fits into the time given and tells it; interrupted, what is done, and what is missing.
[[nodiscard]] std::vector<Section> reproduce_paper(const PaperOptions& options);

// The same from results that are there: tables 2 to 5, figures 2 and 3, and the conclusions.
[[nodiscard]] std::vector<Section> paper_sections(const PaperResults& results, const PaperOptions& options);

}  // namespace assur::report
