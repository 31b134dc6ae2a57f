// Sections of a report: parts of the page, with every number and its origin.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "assur/machine.hpp"
#include "numbers.hpp"
#include "output/json.hpp"
#include "pictures/html.hpp"

namespace assur::report {

using pictures::HtmlTable;
using pictures::paragraph;

// One number of the page: a row of report.csv and a benchmark of report.json.
struct Measurement {
  std::string item;      // measured object: "table 2, total 102", "stewart"
  std::string strategy;  // text of the strategy; for a figure of the paper its name there: "GEOMP+MKL 3x1"
  std::string quantity;  // "seconds per step", "energy", "regret"
  std::string unit;      // "s", "J", "1"
  double value = 0;
  std::string origin;   // "measured", "estimated from ...", "paper, table 2, Core i5-2400"
  int repetitions = 0;  // 0: not measured here (a figure of the paper, an estimate)
  double spread = 0;    // median absolute deviation of the repetitions over their median; 0 for fewer than two
  double error = kNan;  // verified relative forward error or deviation; NaN: none
};

// A ratio of times, with the other data of `of`.
[[nodiscard]] Measurement derived(Measurement of, const std::string& quantity, double ratio, const std::string& origin);

struct Section {
  std::string id;  // of its anchor
  std::string title;
  std::string body = {};  // HTML: tables, figures, sentences
  std::vector<Measurement> measurements = {};
};

// "2.36 µs", "0.0123", "12.1 J"
[[nodiscard]] std::string value_text(const Measurement& m);

// The origin of a number in one line: "irreducible/lanes:8: 2.36 µs; 21 repetitions, spread 0.4 %, error 1.8e-15,
// measured".
[[nodiscard]] std::string about(const Measurement& m);

// A table with the columns of report.csv except the section, for the first `most` measurements.
[[nodiscard]] HtmlTable table_of(std::span<const Measurement> measurements, std::size_t most);

// "1.2 %", "12 %"
[[nodiscard]] std::string percent(double share);

// report.csv: a row for each number with 17 digits; unknown cells are empty.
[[nodiscard]] std::string csv_of(std::span<const Section> sections);

// report.json: the same numbers in the format of Google Benchmark, {"context": ..., "benchmarks": [...]}, so that its
// tools can compare two reports. Times (quantity "seconds ...") are medians: aggregates in ns by the clock, with equal
// cpu_time. A number in another unit becomes a benchmark with a time of 0 and a counter, which has the name of the
// quantity. `date`: ISO 8601.
[[nodiscard]] output::Json benchmark_json(std::span<const Section> sections, const Machine& machine,
                                          const std::string& date);

}  // namespace assur::report
