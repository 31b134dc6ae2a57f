#include "parallel/topology.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <locale>
#include <map>
#include <set>
#include <sstream>
#include <utility>

namespace assur {
namespace {

using std::filesystem::path;

constexpr const char* kProcessors = "sys/devices/system/cpu";
constexpr int kMostProcessors = 8192;  // largest number that Linux supports

std::string first_line(const path& name) {
  std::string line;
  std::ifstream file(name);
  std::getline(file, line);
  return line;
}

bool any_of_them(const std::vector<int>& some, const std::vector<int>& others) {
  std::vector<int> both;
  std::set_intersection(some.begin(), some.end(), others.begin(), others.end(), std::back_inserter(both));
  return !both.empty();
}

// A core is identified by its first processor. Each file is read once.
class Cores {
 public:
  explicit Cores(path cpus) : cpus_(std::move(cpus)) {}

  int of(int processor) {
    const auto [at, is_new] = known_.try_emplace(processor, 0);
    if (is_new) at->second = read(processor);
    return at->second;
  }

 private:
  // core_cpus_list was called thread_siblings_list before.
  [[nodiscard]] int read(int processor) const {
    for (const char* name : {"core_cpus_list", "thread_siblings_list"}) {
      const path folder = cpus_ / ("cpu" + std::to_string(processor)) / "topology";
      const std::vector<int> siblings = parse_processors(first_line(folder / name));
      if (!siblings.empty()) return siblings.front();
    }
    return processor;
  }

  path cpus_;
  std::map<int, int> known_;
};

std::vector<std::int32_t> cores_of(const std::vector<int>& allowed, Cores& known) {
  std::vector<std::int32_t> cores;
  std::set<int> seen;
  for (int processor : allowed) {
    if (seen.insert(known.of(processor)).second) cores.push_back(processor);
  }
  return cores;
}

// Parses "48K" or "1M"; 0 if it is neither.
std::int64_t parse_bytes(const std::string& text) {
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  std::int64_t number = 0;
  char unit = 0;
  if (!(stream >> number) || number < 0) return 0;
  stream >> unit;
  return number * (unit == 'K' ? 1024 : unit == 'M' ? 1024 * 1024 : 1);
}

std::vector<Cache> caches_of(const path& cpus, int processor, Cores& known) {
  std::vector<Cache> caches;
  for (int index = 0;; ++index) {
    const path folder = cpus / ("cpu" + std::to_string(processor)) / "cache" / ("index" + std::to_string(index));
    const std::string type = first_line(folder / "type");
    if (type.empty()) break;
    std::set<int> cores;
    for (int sharer : parse_processors(first_line(folder / "shared_cpu_list"))) cores.insert(known.of(sharer));
    Cache cache;
    cache.level = static_cast<std::int32_t>(parse_bytes(first_line(folder / "level")));
    cache.bytes = parse_bytes(first_line(folder / "size"));
    cache.cores = std::max(1, static_cast<std::int32_t>(cores.size()));
    if (type != "Instruction" && cache.level >= 1 && cache.level <= 3 && cache.bytes > 0) caches.push_back(cache);
  }
  std::sort(caches.begin(), caches.end(), [](const Cache& a, const Cache& b) { return a.level < b.level; });
  return caches;
}

}  // namespace

std::vector<int> parse_processors(const std::string& list) {
  std::set<int> processors;
  std::istringstream items(list);
  for (std::string item; std::getline(items, item, ',');) {
    std::istringstream stream(item);
    stream.imbue(std::locale::classic());
    int first = 0, last = 0;
    char dash = 0;
    if (!(stream >> first)) continue;
    if (!(stream >> dash))
      last = first;
    else if (dash != '-' || !(stream >> last))
      continue;
    if (first < 0 || last >= kMostProcessors) continue;
    for (int processor = first; processor <= last; ++processor) processors.insert(processor);
  }
  return {processors.begin(), processors.end()};
}

std::vector<std::int32_t> cores_by_sysfs(const std::vector<int>& allowed, const path& root) {
  Cores known(root / kProcessors);
  return cores_of(allowed, known);
}

Topology topology_by_sysfs(const std::vector<int>& allowed, const path& root) {
  Topology topology;
  topology.source = "sysfs";
  Cores known(root / kProcessors);
  topology.cores = cores_of(allowed, known);
  if (!allowed.empty()) topology.caches = caches_of(root / kProcessors, allowed.front(), known);
  const path nodes = root / "sys/devices/system/node";
  const std::vector<int> online = parse_processors(first_line(nodes / "online"));
  topology.numa_nodes = static_cast<std::int32_t>(std::count_if(online.begin(), online.end(), [&](int node) {
    return any_of_them(parse_processors(first_line(nodes / ("node" + std::to_string(node)) / "cpulist")), allowed);
  }));
  topology.numa_nodes = std::max(topology.numa_nodes, 1);
  return topology;
}

}  // namespace assur
