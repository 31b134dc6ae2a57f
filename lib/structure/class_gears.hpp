// Gears as numbers of a class.
#pragma once

#include <optional>

#include "assur/structure.hpp"
#include "scene/system.hpp"

namespace assur {

// The numbers of a gear for a class; empty: the callback is none.
[[nodiscard]] std::optional<GroupClass::Gear> gear_of_class(const CallbackBlock& block);
// Fills the gears of a class, whose callbacks are those of the system.
void find_gears(const System& system, GroupClass& group_class);

}  // namespace assur
