// What this process may use of the machine that it runs on.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "assur/backend.hpp"

namespace assur {

struct Cache {
  std::int32_t level = 1;  // 1 (of data), 2, 3
  std::int64_t bytes = 0;
  std::int32_t cores = 1;  // that share one, those included that this process may not use

  friend bool operator==(const Cache&, const Cache&) = default;
};

struct Machine {
  std::string model;                // of the processor, as it calls itself; "" if it does not
  std::string instructions;         // widest of those that this library has code for, as Highway calls it: "AVX2", ...
  std::vector<std::int32_t> cores;  // physical ones that the affinity mask allows: a processor of each, to pin to
  std::int32_t processors = 1;      // logical ones that the mask allows: more than cores where a core runs two threads
  double quota = 0;                 // processors' time that the control groups allow; 0: no limit
  std::int32_t openmp_limit = 0;    // OMP_NUM_THREADS; 0: not set
  std::vector<Cache> caches;        // of the first core, from level 1; empty if the system does not tell
  std::int32_t numa_nodes = 1;      // that the cores belong to
  std::string source;               // of cores, caches and nodes: "hwloc 2.9.0" or "sysfs"

  // Threads that work at once without disturbing each other: as many as cores, but no more than the quota, rounded up,
  // nor than OMP_NUM_THREADS, which so is an upper bound for this library too; at least 1. A budget that the user gives
  // (PrepareOptions::budget) takes its place, whatever it is.
  [[nodiscard]] ThreadBudget budget() const;

  friend bool operator==(const Machine&, const Machine&) = default;
};

// Asks the system anew each time: some 10 ms with hwloc, 0.5 ms without (two cores). What it does not tell stays as it
// is above; a machine that tells nothing has one core. In assur::assur.
[[nodiscard]] Machine this_machine();

// One line, e.g. "AMD EPYC, AVX3: 2 cores, L1 48 KiB, L2 1 MiB, L3 32 MiB for 2 cores; budget: 2 threads".
[[nodiscard]] std::string to_string(const Machine& machine);

}  // namespace assur
