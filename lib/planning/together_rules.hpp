// Where +together can be used.
#pragma once

#include <string>

#include "assur/strategy.hpp"
#include "assur/structure.hpp"

namespace assur {

// The reason why a strategy with +together cannot solve a structure; "": it can.
[[nodiscard]] std::string why_not_together(const Structure& structure, const Strategy& strategy);

}  // namespace assur
