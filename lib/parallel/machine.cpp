#include "parallel/machine.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <locale>
#include <sstream>

#include "decimal.hpp"
#include "parallel/cgroup.hpp"
#include "parallel/instruction_set.hpp"
#include "parallel/thread_state.hpp"
#include "parallel/topology.hpp"

namespace assur {
namespace {

std::string model_name(const std::filesystem::path& root) {
  std::ifstream file(root / "proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const auto colon = line.find(": ");
    if (line.rfind("model name", 0) == 0 && colon != std::string::npos) return line.substr(colon + 2);
  }
  // Linux does not name 64-bit ARM processors, but the board: "Raspberry Pi 3 Model B Rev 1.2", which ends with NUL.
  std::ifstream board(root / "proc/device-tree/model");
  std::string name;
  std::getline(board, name, '\0');
  return name;
}

// 4 for "4" and for "4,2" (nested regions); 0 if it is not a number >= 1.
std::int32_t openmp_limit(const std::string& omp_num_threads) {
  std::int32_t threads = 0;
  std::istringstream text(omp_num_threads);
  text.imbue(std::locale::classic());  // other locales may read "4,2" as 42
  text >> threads;
  return std::max(threads, 0);
}

std::string omp_num_threads() {
  const char* const text = std::getenv("OMP_NUM_THREADS");
  return text != nullptr ? text : "";
}

// All limits of the budget except the cores.
Machine limits(const std::filesystem::path& root, const std::string& omp_num_threads) {
  Machine machine;
  machine.quota = cpu_quota(root);
  machine.openmp_limit = openmp_limit(omp_num_threads);
  return machine;
}

}  // namespace

void add_topology(Machine& machine, const Topology& topology) {
  machine.cores = topology.cores;
  machine.caches = topology.caches;
  machine.numa_nodes = topology.numa_nodes;
  machine.source = topology.source;
}

namespace {

std::string size_text(std::int64_t bytes) {
  const bool mega = bytes % (1024 * 1024) == 0;
  return std::to_string(bytes / (mega ? 1024 * 1024 : 1024)) + (mega ? " MiB" : " KiB");
}

std::string counted(std::int64_t number, const std::string& what) {
  return std::to_string(number) + " " + what + (number == 1 ? "" : "s");
}

}  // namespace

ThreadBudget Machine::budget() const {
  auto threads = static_cast<std::int32_t>(cores.size());
  if (quota > 0 && quota < threads) threads = static_cast<std::int32_t>(std::ceil(quota));
  if (openmp_limit > 0) threads = std::min(threads, openmp_limit);
  return {std::max(threads, 1)};
}

Machine read_machine(const std::filesystem::path& root, const std::vector<int>& allowed,
                     const std::string& omp_num_threads) {
  const std::vector<int> processors = allowed.empty() ? std::vector<int>{0} : allowed;
  Machine machine = limits(root, omp_num_threads);
  machine.model = model_name(root);
  machine.instructions = instruction_set();
  machine.processors = static_cast<std::int32_t>(processors.size());
  add_topology(machine, topology_by_sysfs(processors, root));
  return machine;
}

Machine machine_by_sysfs() { return read_machine("/", allowed_processors(), omp_num_threads()); }

ThreadBudget available_budget() {
  Machine machine = limits("/", omp_num_threads());
  machine.cores = cores_by_sysfs(allowed_processors());
  return machine.budget();
}

std::string to_string(const Machine& machine) {
  std::string text = (machine.model.empty() ? "unknown processor" : machine.model) + ", " + machine.instructions +
                     ": " + counted(static_cast<std::int64_t>(machine.cores.size()), "core");
  if (machine.processors != static_cast<std::int32_t>(machine.cores.size())) {
    text += " (" + counted(machine.processors, "processor") + ")";
  }
  for (const Cache& cache : machine.caches) {
    text += ", L" + std::to_string(cache.level) + " " + size_text(cache.bytes);
    if (cache.cores > 1) text += " for " + counted(cache.cores, "core");
  }
  if (machine.numa_nodes > 1) text += ", " + counted(machine.numa_nodes, "NUMA node");
  text += "; budget: " + counted(machine.budget().threads, "thread");
  if (machine.quota > 0) text += ", quota " + general(machine.quota, 6);
  if (machine.openmp_limit > 0) text += ", OMP_NUM_THREADS " + std::to_string(machine.openmp_limit);
  return text;
}

}  // namespace assur
