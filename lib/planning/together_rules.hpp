// Where +together can be used.
#pragma once

#include <string>

#include "assur/strategy.hpp"
#include "assur/structure.hpp"

namespace assur {

// The reason why +together cannot be used with the other settings of a strategy; "": it can.
[[nodiscard]] std::string why_not_together(const Strategy& strategy);
// The same, with the groups of a structure.
[[nodiscard]] std::string why_not_together(const Structure& structure, const Strategy& strategy);

}  // namespace assur
