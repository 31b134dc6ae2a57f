// Gears as numbers of a class.
#pragma once

#include <optional>

#include "equations/system.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

// The numbers of a gear for a class; without arguments. Empty: the callback is none.
[[nodiscard]] std::optional<GroupClass::Gear> gear_of_class(const CallbackBlock& block);

}  // namespace assur
