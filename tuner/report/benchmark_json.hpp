// report.json: the same numbers as Google Benchmark writes them, so that its tools can compare two reports.
#pragma once

#include <span>
#include <string>

#include "assur/machine.hpp"
#include "output/json.hpp"
#include "report/section.hpp"

namespace assur::report {

// {"context": ..., "benchmarks": [...]}. Times are medians: of quantity "seconds ...", aggregates in ns, by the clock
// (cpu_time is the same). A number of another unit is a counter named as its quantity, of a benchmark that takes no
// time. `date`: ISO 8601.
[[nodiscard]] output::Json benchmark_json(std::span<const Section> sections, const Machine& machine,
                                          const std::string& date);

}  // namespace assur::report
