#include "planning/together_rules.hpp"

#include <hwy/targets.h>

#include "backends/small_steps.hpp"
#include "equations/coefficients.hpp"
#include "equations/separable.hpp"
#include "program/needs.hpp"

namespace assur {
namespace {

// The steps in registers have the same conditions, see make_small_step().
std::string why_not(const Structure& s, std::int32_t group_class) {
  const GroupClass& c = s.classes[static_cast<std::size_t>(group_class)];
  if (!can_take(Path::together, needs_of(c))) return "has an equation that is not quadratic";
  if (c.n < 2 || c.n > 3) return "has " + std::to_string(c.n) + (c.n == 1 ? " unknown" : " unknowns");
  if (c.blocks != 1) return "can be divided further";
  if (c.first_wanted != 0) return "has unknowns whose highest derivative is not needed";
  if (!separate(c)) return "has products of different unknowns";
  return "";
}

}  // namespace

std::string why_not_together(const Strategy& strategy) {
  if ((hwy::SupportedTargets() & HWY_TARGETS & ~(HWY_SCALAR | HWY_EMU128)) == 0) {
    return "+together needs a processor with vector instructions that Highway supports";
  }
  if (!has_small_steps(strategy.solver)) {
    return "+together needs the solver lanes without +float, +refine, +reuse, +once and +separate";
  }
  if (strategy.solver.lanes < kLeastTogetherLanes) return "+together takes 4, 8 or 16 lanes";
  return "";
}

std::string why_not_together(const Structure& structure) {
  Strategy narrowest;
  narrowest.solver.backend = kLanes.id;
  narrowest.solver.lanes = kLeastTogetherLanes;
  return why_not_together(structure, narrowest);
}

std::string why_not_together(const Structure& structure, const Strategy& strategy) {
  if (std::string reason = why_not_together(strategy); !reason.empty()) return reason;
  for (std::size_t c = 0; c < structure.classes.size(); ++c) {
    const std::string reason = why_not(structure, static_cast<std::int32_t>(c));
    if (reason.empty()) continue;
    std::string name;
    for (const Group& g : structure.groups) {
      if (static_cast<std::size_t>(g.group_class) == c) name = g.name;
    }
    return "+together needs groups of 2 or 3 unknowns without products of different unknowns, but group " + name + " " +
           reason;
  }
  return "";
}

}  // namespace assur
