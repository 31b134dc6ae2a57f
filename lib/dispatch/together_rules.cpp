#include "dispatch/together_rules.hpp"

#include <algorithm>

#include "backends/lanes_order.hpp"
#include "backends/small_steps.hpp"
#include "index.hpp"
#include "program/needs.hpp"
#include "program/together_step.hpp"

namespace assur {
namespace {

std::string why_not(const GroupClass& c) {
  if (!can_take(Path::together, needs_of(c))) return "has an equation that is not quadratic";
  if (c.n < 1 || c.n > lanes::kMostReserved) return "has " + std::to_string(c.n) + " unknowns";
  if (c.blocks != 1) return "can be divided further";
  return "";
}
std::string why_not(const Couplings& couplings) {
  if (idx(couplings.rows()) <= kMostCoupledRows) return "";
  return "has " + std::to_string(couplings.rows()) + " of them";
}

}  // namespace

std::string why_not_together(const Strategy& strategy) {
  if (!has_small_steps(strategy.solver)) {
    return "+together needs the solver lanes without +float, +refine, +reuse, +once and +separate";
  }
  if (strategy.solver.lanes < kLeastTogetherLanes) return "+together takes 4, 8 or 16 lanes";
  return "";
}

std::string why_not_together(const GroupedSystem& structure) {
  Strategy narrowest;
  narrowest.solver.backend = kLanes.id;
  narrowest.solver.lanes = kLeastTogetherLanes;
  return why_not_together(structure, narrowest);
}

std::string why_not_together(const GroupedSystem& structure, const Strategy& strategy) {
  if (std::string reason = why_not_together(strategy); !reason.empty()) return reason;
  const auto refusal = [&](const auto& of_classes) -> std::string {
    for (std::size_t c = 0; c < of_classes.size(); ++c) {
      const std::string reason = why_not(of_classes[c]);
      if (reason.empty()) continue;
      const auto group = std::find_if(structure.groups.begin(), structure.groups.end(),
                                      [&](const SolvedGroup& g) { return idx(g.group_class) == c; });
      return "+together needs groups of up to " + std::to_string(lanes::kMostReserved) + " unknowns, with up to " +
             std::to_string(kMostCoupledRows) + " equations that read other groups, but group " + group->name + " " +
             reason;
    }
    return "";
  };
  const std::string reason = refusal(structure.classes);
  return !reason.empty() ? reason : refusal(couplings_of(structure));
}

}  // namespace assur
