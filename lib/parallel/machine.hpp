// Reads a Machine from given sources.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "assur/machine.hpp"
#include "parallel/topology.hpp"

namespace assur {

// The machine without hwloc. root: root of a file system with proc and sys; allowed: processors of the affinity mask,
// ascending, empty if unknown; omp_num_threads: text of the variable, "" if it is not set.
[[nodiscard]] Machine read_machine(const std::filesystem::path& root, const std::vector<int>& allowed,
                                   const std::string& omp_num_threads);

// this_machine() without hwloc.
[[nodiscard]] Machine machine_by_sysfs();

// Copies the topology to the machine.
void add_topology(Machine& machine, const Topology& topology);

// this_machine().budget() without hwloc, which takes milliseconds.
[[nodiscard]] ThreadBudget available_budget();

}  // namespace assur
