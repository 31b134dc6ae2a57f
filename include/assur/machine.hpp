// The machine that the process runs on, and the share of it that the process may use.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace assur {

// Threads that a call may use. It is an argument of each call, never a global setting.
struct ThreadBudget {
  std::int32_t threads = 1;  // at least 1
};

// One level of the cache hierarchy.
struct Cache {
  std::int32_t level = 1;  // 1 (data cache), 2 or 3
  std::int64_t bytes = 0;  // size of one such cache
  std::int32_t cores = 1;  // physical cores that share one such cache, including cores that this process may not use

  friend bool operator==(const Cache&, const Cache&) = default;
};

// Description of the machine, as far as plans depend on it.
struct Machine {
  std::string model;                // name of the processor, or of the board of an ARM processor; "" if unknown
  std::string instructions;         // widest set that this library can use, named as in Highway: "AVX2"
  std::vector<std::int32_t> cores;  // usable physical cores; for each, the number of one logical processor, for pinning
  std::int32_t processors = 1;      // logical processors in the affinity mask; more than cores with hyper-threading
  double quota = 0;                 // processors that the control groups allow, e.g. 1.5; 0: no limit
  std::int32_t openmp_limit = 0;    // OMP_NUM_THREADS; 0: not set
  std::vector<Cache> caches;        // of the first usable core, from level 1; empty if the system does not report them
  std::int32_t numa_nodes = 1;      // memory nodes that the usable cores belong to
  std::string source;               // origin of cores, caches and nodes: "hwloc 2.9.0" or "sysfs"

  // Default number of threads: one for each usable core, at most the quota (rounded up), at most OMP_NUM_THREADS, and
  // at least 1. PrepareOptions::budget replaces it.
  [[nodiscard]] ThreadBudget budget() const;

  friend bool operator==(const Machine&, const Machine&) = default;
};

// Reads the description from the system at each call. Takes 0.5 ms, or some 10 ms if sysfs does not report the caches
// and hwloc is asked (measured on two cores). Properties that the system does not report keep their defaults; there is
// at least one core. Needs the library assur::assur.
[[nodiscard]] Machine this_machine();

// The machine in one line, e.g. "AMD EPYC, AVX3: 2 cores, L1 48 KiB, L2 1 MiB, L3 32 MiB for 2 cores; budget: 2
// threads".
[[nodiscard]] std::string to_string(const Machine& machine);

}  // namespace assur
