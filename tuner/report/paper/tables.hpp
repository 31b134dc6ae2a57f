// The tables and figures of the paper beside those of this machine: one section of the report for each.
#pragma once

#include <vector>

#include "report/paper/runs.hpp"
#include "report/section.hpp"

namespace assur::report {

// Runs the experiments that fit into the given time, and reports them. If interrupted, reports the results so far and
// the missing ones.
[[nodiscard]] std::vector<Section> reproduce_paper(const PaperOptions& options);

// The sections from given results: tables 2 to 5, figures 2 and 3, and the conclusions.
[[nodiscard]] std::vector<Section> paper_sections(const PaperResults& results, const PaperOptions& options);

}  // namespace assur::report
