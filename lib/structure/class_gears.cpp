#include "structure/class_gears.hpp"

#include <cstdint>

#include "joints/gear.hpp"

namespace assur {

std::optional<GroupClass::Gear> gear_of_class(const CallbackBlock& block) {
  const auto numbers = numbers_of(*block.callback);
  if (!numbers) return {};
  GroupClass::Gear gear{{}, numbers->is_periodic, block.unit, {}};
  for (const GearNumbers::Side& side : numbers->sides) {
    gear.sides.push_back({side.factor, static_cast<std::int32_t>(side.arguments())});
  }
  return gear;
}

}  // namespace assur
