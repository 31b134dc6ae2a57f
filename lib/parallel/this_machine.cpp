#include "parallel/machine.hpp"
#include "parallel/thread_state.hpp"
#include "parallel/topology.hpp"

namespace assur {

Machine this_machine() {
  Machine machine = machine_by_sysfs();
  if (const auto topology = topology_by_hwloc(allowed_processors())) take(machine, *topology);
  return machine;
}

}  // namespace assur
