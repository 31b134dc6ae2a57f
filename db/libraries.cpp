#include "db/libraries.hpp"

#include <algorithm>

#include "assur/backend.hpp"
#include "assur/version.hpp"
#include "backends/backends.hpp"

namespace assur::db {
namespace {

const Backend* row(std::string_view id) {
  const auto table = backends();
  const auto found = std::find_if(table.begin(), table.end(), [&](const Backend& backend) { return backend.id == id; });
  return found == table.end() ? nullptr : &*found;
}

}  // namespace

std::string_view assur_version() { return ASSUR_VERSION; }

Library library_at_hand(std::string_view name) {
  // The equations use the same lanes as this backend.
  const Backend* const backend = row(name == "assur" ? kLanes.id : name);
  if (!backend) return {std::string(name), "", ""};
  std::string version = backend->version();
  if (version.empty()) return {std::string(name), "", ""};
  if (name == "assur" || backend->own_loops) version += ", assur " ASSUR_VERSION;
  return {std::string(name), version, ASSUR_BUILD};
}

std::string library_name(const Sample& sample) {
  const bool solves = sample.kernel == Kernel::factor || sample.kernel == Kernel::solve ||
                      sample.kernel == Kernel::pack || sample.kernel == Kernel::step;
  return solves ? sample.strategy.solver.backend : "assur";
}

}  // namespace assur::db
