// What a report is made of: sections of a page, and beside them every number with where it comes from.
#pragma once

#include <string>
#include <vector>

namespace assur::report {

// One number of the page: a row of report.csv and a benchmark of report.json.
struct Measurement {
  std::string section;   // id of the section
  std::string item;      // what was measured: "table 2, total 102", "stewart"
  std::string strategy;  // text of the strategy that was run; of a paper's figure its name there: "GEOMP+MKL 3x1"
  std::string quantity;  // "seconds per step", "energy", "regret"
  std::string unit;      // "s", "J", "1"
  double value = 0;
  int repetitions = 0;  // 0: not measured here (a figure of the paper, an estimate)
  double spread = 0;    // median absolute deviation of the repetitions over their median; of fewer than two: none
  double error = 0;     // relative forward error or deviation that was verified before the time counted; NaN: none
  std::string origin;   // "measured", "estimated from ...", "paper, table 2, Core i5-2400"
};

struct Section {
  std::string id;  // of its anchor
  std::string title;
  std::string body;  // HTML: tables, figures, sentences
  std::vector<Measurement> measurements;
};

}  // namespace assur::report
