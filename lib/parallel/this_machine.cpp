#include "parallel/machine.hpp"
#include "parallel/thread_state.hpp"
#include "parallel/topology.hpp"

namespace assur {

Machine this_machine() {
  Machine machine = machine_by_sysfs();
  // If sysfs lists caches, it lists everything; hwloc takes milliseconds to load its plugins.
  if (!machine.caches.empty()) return machine;
  if (const auto topology = topology_by_hwloc(allowed_processors())) add_topology(machine, *topology);
  return machine;
}

}  // namespace assur
