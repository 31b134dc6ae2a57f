#include "structure/class_gears.hpp"

#include <cstdint>
#include <utility>

#include "index.hpp"
#include "scene/gear.hpp"

namespace assur {

std::optional<GroupClass::Gear> gear_of_class(const CallbackBlock& block) {
  const auto numbers = numbers_of(*block.callback);
  if (!numbers) return {};
  GroupClass::Gear gear{{}, numbers->is_periodic, block.unit};
  for (const GearNumbers::Side& side : numbers->sides) {
    gear.sides.push_back({side.factor, static_cast<std::int32_t>(side.arguments())});
  }
  return gear;
}

void find_gears(const System& s, GroupClass& c) {
  for (GroupClass::Equation& e : c.equations) {
    if (e.callback < 0) continue;
    auto gear = gear_of_class(s.callbacks[idx(e.callback)]);
    if (!gear) continue;
    e.gear = static_cast<Index>(c.gears.size());
    c.gears.push_back(std::move(*gear));
  }
}

}  // namespace assur
