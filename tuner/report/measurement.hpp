// Numbers of the report as text.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "pictures/html.hpp"
#include "report/section.hpp"

namespace assur::report {

// "2.36 µs", "0.0123", "12.1 J"
[[nodiscard]] std::string value_text(const Measurement& m);

// Its origin in one line: "irreducible/lanes:8: 2.36 µs; 21 repetitions, spread 0.4 %, error 1.8e-15, measured".
[[nodiscard]] std::string about(const Measurement& m);

// Every column of report.csv but the section, in the order of the measurements; the first `most` of them.
[[nodiscard]] pictures::HtmlTable table_of(const std::vector<Measurement>& measurements, std::size_t most);

// "1.2 %", "12 %"
[[nodiscard]] std::string percent(double share);

// Nearest rank: the smallest value that at least this share of them do not exceed; NaN of none.
[[nodiscard]] double quantile(std::vector<double> values, double share);
[[nodiscard]] double mean(const std::vector<double>& values);  // NaN of none

// "<p>text</p>", escaped.
[[nodiscard]] std::string paragraph(std::string_view text, std::string_view css_class = {});

}  // namespace assur::report
