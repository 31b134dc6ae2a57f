// What the sections about the paper are made of.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "pictures/html.hpp"
#include "report/measurement.hpp"
#include "report/paper/runs.hpp"
#include "report/section.hpp"

namespace assur::report {

[[nodiscard]] Section paper_table_2(const PaperResults& results);
[[nodiscard]] Section paper_figure_2(const PaperResults& results);
[[nodiscard]] Section paper_table_3(const PaperResults& results);
[[nodiscard]] Section paper_figure_3(const PaperResults& results);
[[nodiscard]] Section paper_table_4(const PaperResults& results, const PaperOptions& options);
[[nodiscard]] Section paper_table_5(const PaperResults& results);
[[nodiscard]] Section paper_conclusions(const PaperResults& results);

// A paragraph of less weight; the text is escaped.
[[nodiscard]] std::string faint(std::string_view text);
// A table whose long titles are broken; the second one in small type, for numbers that carry over to no other machine.
[[nodiscard]] std::string tall(const pictures::HtmlTable& table);
[[nodiscard]] std::string small(const pictures::HtmlTable& table);

// "3.83", or "-" for what is not there.
[[nodiscard]] std::string ratio_or_dash(double ratio);
// Seconds of so many steps, as the paper prints them, and the threads: "0.53 (3x1)"; "-" for null.
[[nodiscard]] std::string run_text(const PaperTiming* timing, int steps);
// Time of a version, NaN for null.
[[nodiscard]] double seconds_of(const PaperTiming* timing);

// A number of ours, and one of the paper's.
[[nodiscard]] Measurement measured(const std::string& section, const PaperTiming& timing);
[[nodiscard]] Measurement of_the_paper(const std::string& section, int table, const PaperTiming& timing,
                                       std::string_view machine);

// Adds what was timed for these cells: the measurements, and a table of all of it that opens on demand.
void add_details(Section& section, const PaperResults& results, const std::vector<PaperCell>& cells);

// Sentence about rows of these cells that have no time here; "" if all have.
[[nodiscard]] std::string missing(const PaperResults& results, const std::vector<PaperCell>& cells);

}  // namespace assur::report
