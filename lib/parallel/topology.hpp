// Cores, caches and memory nodes among the processors that a process may use.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "assur/machine.hpp"

namespace assur {

// The topology; members as in Machine.
struct Topology {
  std::vector<std::int32_t> cores;
  std::vector<Cache> caches;
  std::int32_t numa_nodes = 1;
  std::string source;
};

// The topology from sys/devices/system below root. allowed: processors of the affinity mask, ascending. Defaults for
// missing or invalid files: each processor is a core, caches are unknown, there is one node.
[[nodiscard]] Topology topology_by_sysfs(const std::vector<int>& allowed, const std::filesystem::path& root = "/");

// The cores of topology_by_sysfs() only, which needs one file for each processor.
[[nodiscard]] std::vector<std::int32_t> cores_by_sysfs(const std::vector<int>& allowed,
                                                       const std::filesystem::path& root = "/");

// The topology from hwloc; empty if the library is built without hwloc, or if hwloc finds none of the allowed
// processors. synthetic: description of another machine for hwloc, e.g. "numa:2 l3:1 core:4 pu:2"; "": this machine.
[[nodiscard]] std::optional<Topology> topology_by_hwloc(const std::vector<int>& allowed,
                                                        const std::string& synthetic = "");

// Reads a list of processors: "0-3,8" -> 0 1 2 3 8, ascending. Skips invalid parts and impossible numbers.
[[nodiscard]] std::vector<int> parse_processors(const std::string& list);

}  // namespace assur
