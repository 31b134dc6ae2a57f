#include "parallel/topology.hpp"

namespace assur {

std::optional<Topology> topology_by_hwloc(const std::vector<int>&, const std::string&) { return std::nullopt; }

}  // namespace assur
