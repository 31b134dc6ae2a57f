// How a Machine is read, with what it is read from as arguments.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "assur/machine.hpp"
#include "parallel/topology.hpp"

namespace assur {

// root: of a file system with proc and sys; allowed: processors by the affinity mask, ascending, empty if not known;
// omp_num_threads: the text of the variable, "" if it is not set. Without hwloc.
[[nodiscard]] Machine read_machine(const std::filesystem::path& root, const std::vector<int>& allowed,
                                   const std::string& omp_num_threads);

// this_machine() without hwloc.
[[nodiscard]] Machine machine_by_sysfs();

// What `topology` knows.
void take(Machine& machine, const Topology& topology);

// this_machine().budget() without hwloc, which takes its time.
[[nodiscard]] ThreadBudget available_budget();

}  // namespace assur
