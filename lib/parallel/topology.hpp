// Cores, caches and memory nodes among the processors that a process may use.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "assur/machine.hpp"

namespace assur {

// The members of Machine that have these names.
struct Topology {
  std::vector<std::int32_t> cores;
  std::vector<Cache> caches;
  std::int32_t numa_nodes = 1;
  std::string source;
};

// allowed: processors by the affinity mask, ascending. As Linux tells it in sys/devices/system below root. What is
// missing there or makes no sense: each processor is a core, caches are not known, there is one node.
[[nodiscard]] Topology topology_by_sysfs(const std::vector<int>& allowed, const std::filesystem::path& root = "/");

// Its cores alone: a file for each processor.
[[nodiscard]] std::vector<std::int32_t> cores_by_sysfs(const std::vector<int>& allowed,
                                                       const std::filesystem::path& root = "/");

// The topology from hwloc; empty if this build is without, or if hwloc finds nothing that is allowed. synthetic: a
// machine in hwloc's words to take instead of this one, e.g. "numa:2 l3:1 core:4 pu:2".
[[nodiscard]] std::optional<Topology> topology_by_hwloc(const std::vector<int>& allowed,
                                                        const std::string& synthetic = "");

// "0-3,8" -> 0 1 2 3 8, ascending; what is no such list, or beyond the most processors of Linux, is left out.
[[nodiscard]] std::vector<int> parse_processors(const std::string& list);

}  // namespace assur
