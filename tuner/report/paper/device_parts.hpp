// Where the time of the backend `cusolver` goes: copies, computation, launches. For table 5 of the paper.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "backends/cusolver.hpp"
#include "report/section.hpp"

namespace assur::report {

// The times for a random matrix of order n, in s.
struct DeviceParts {
  int n = 0, calls = 0;
  cusolver::Breakdown times;
  double cpu_lu = kNan, cpu_solution = kNan;  // of the processor, just after those of the GPU
  std::string why_not = {};                   // the reason why the GPU has no times; "": it has
};

// For the groups of table 5. on_cpu: strategy for the times of the processor. cusolver must run here. Ends early if it
// is interrupted, or at the first n that the GPU cannot solve.
[[nodiscard]] std::vector<DeviceParts> measure_device_parts(const std::string& on_cpu,
                                                            const std::function<bool()>& interrupted);

// Appends a table and its numbers to a section, unless there are no times.
void add_device_parts(Section& section, const std::vector<DeviceParts>& parts, const std::string& on_cpu);

// The strategy of the processor for these comparisons: two threads of the dense solver, or one.
[[nodiscard]] std::string cpu_beside_device(const std::string& dense, int threads);

}  // namespace assur::report
