#include <hwloc.h>
#include <unistd.h>

#include <algorithm>
#include <memory>

#include "parallel/topology.hpp"

namespace assur {
namespace {

using Handle = std::unique_ptr<hwloc_topology, void (*)(hwloc_topology_t)>;

// Cores, caches and nodes of the whole machine, including those that this process may not use; null if hwloc fails.
Handle load(const std::string& synthetic) {
  hwloc_topology_t topology = nullptr;
  // Without sysfs hwloc finds nothing, and prints an error.
  if (synthetic.empty() && access("/sys/devices/system/cpu", R_OK) != 0) return {nullptr, nullptr};
  if (hwloc_topology_init(&topology) != 0) return {nullptr, nullptr};
  Handle handle(topology, hwloc_topology_destroy);
  const bool ready = hwloc_topology_set_flags(topology, HWLOC_TOPOLOGY_FLAG_INCLUDE_DISALLOWED) == 0 &&
                     (synthetic.empty() || hwloc_topology_set_synthetic(topology, synthetic.c_str()) == 0) &&
                     hwloc_topology_load(topology) == 0;
  if (!ready) handle.reset();
  return handle;
}

int inside(hwloc_topology_t topology, hwloc_obj_t object, hwloc_obj_type_t type) {
  return hwloc_get_nbobjs_inside_cpuset_by_type(topology, object->cpuset, type);
}

std::vector<Cache> caches_above(hwloc_topology_t topology, hwloc_obj_t processor) {
  std::vector<Cache> caches;
  for (const auto type : {HWLOC_OBJ_L1CACHE, HWLOC_OBJ_L2CACHE, HWLOC_OBJ_L3CACHE}) {
    const hwloc_obj_t cache = hwloc_get_ancestor_obj_by_type(topology, type, processor);
    if (!cache || cache->attr->cache.size == 0) continue;
    caches.push_back({static_cast<std::int32_t>(cache->attr->cache.depth),
                      static_cast<std::int64_t>(cache->attr->cache.size),
                      std::max(1, inside(topology, cache, HWLOC_OBJ_CORE))});
  }
  return caches;
}

}  // namespace

std::optional<Topology> topology_by_hwloc(const std::vector<int>& allowed, const std::string& synthetic) {
  const Handle handle = load(synthetic);
  if (!handle) return std::nullopt;
  hwloc_topology_t topology = handle.get();

  Topology found;
  found.source = "hwloc " HWLOC_VERSION;
  std::vector<hwloc_obj_t> cores, nodes;  // seen so far
  const auto is_new = [](std::vector<hwloc_obj_t>& seen, hwloc_obj_t object) {
    if (std::find(seen.begin(), seen.end(), object) != seen.end()) return false;
    seen.push_back(object);
    return true;
  };
  for (const int number : allowed) {
    const hwloc_obj_t processor = hwloc_get_pu_obj_by_os_index(topology, static_cast<unsigned>(number));
    if (!processor) continue;
    if (found.cores.empty()) found.caches = caches_above(topology, processor);
    const hwloc_obj_t core = hwloc_get_ancestor_obj_by_type(topology, HWLOC_OBJ_CORE, processor);
    if (is_new(cores, core ? core : processor)) found.cores.push_back(number);
    for (hwloc_obj_t node = nullptr; (node = hwloc_get_next_obj_by_type(topology, HWLOC_OBJ_NUMANODE, node));) {
      if (hwloc_bitmap_isset(node->cpuset, static_cast<unsigned>(number))) is_new(nodes, node);
    }
  }
  if (found.cores.empty()) return std::nullopt;
  found.numa_nodes = std::max(1, static_cast<std::int32_t>(nodes.size()));
  return found;
}

}  // namespace assur
