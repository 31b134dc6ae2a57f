// What a report is made of: sections of a page, and beside them every number with where it comes from.
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
  std::string item;      // what was measured: "table 2, total 102", "stewart"
  std::string strategy;  // text of the strategy that was run; of a paper's figure its name there: "GEOMP+MKL 3x1"
  std::string quantity;  // "seconds per step", "energy", "regret"
  std::string unit;      // "s", "J", "1"
  double value = 0;
  std::string origin;   // "measured", "estimated from ...", "paper, table 2, Core i5-2400"
  int repetitions = 0;  // 0: not measured here (a figure of the paper, an estimate)
  double spread = 0;    // median absolute deviation of the repetitions over their median; of fewer than two: none
  double error = kNan;  // relative forward error or deviation that was verified before the time counted; NaN: none
};

// A ratio of times, with what is known of the one it is about.
[[nodiscard]] Measurement derived(Measurement of, const std::string& quantity, double ratio, const std::string& origin);

struct Section {
  std::string id;  // of its anchor
  std::string title;
  std::string body = {};  // HTML: tables, figures, sentences
  std::vector<Measurement> measurements = {};
};

// "2.36 µs", "0.0123", "12.1 J"
[[nodiscard]] std::string value_text(const Measurement& m);

// Its origin in one line: "irreducible/lanes:8: 2.36 µs; 21 repetitions, spread 0.4 %, error 1.8e-15, measured".
[[nodiscard]] std::string about(const Measurement& m);

// Every column of report.csv but the section, in the order of the measurements; the first `most` of them.
[[nodiscard]] HtmlTable table_of(std::span<const Measurement> measurements, std::size_t most);

// "1.2 %", "12 %"
[[nodiscard]] std::string percent(double share);

// report.csv: a row for each number, all 17 digits; what is not known is an empty cell.
[[nodiscard]] std::string csv_of(std::span<const Section> sections);

// report.json: the same numbers as Google Benchmark writes them, {"context": ..., "benchmarks": [...]}, so that its
// tools can compare two reports. Times are medians: of quantity "seconds ...", aggregates in ns, by the clock (cpu_time
// is the same). A number of another unit is a counter named as its quantity, of a benchmark that takes no time. `date`:
// ISO 8601.
[[nodiscard]] output::Json benchmark_json(std::span<const Section> sections, const Machine& machine,
                                          const std::string& date);

}  // namespace assur::report
