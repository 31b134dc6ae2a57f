// Whether this processor can use +together, which needs vector instructions with doubles; 32-bit ARM has none.
#pragma once

#include <string>

#include "assur/strategy.hpp"
#include "planning/together_rules.hpp"

namespace assur::test {

// The reason why it cannot; "": it can.
inline std::string why_not_together_here() { return why_not_together(parse_strategy("irreducible/lanes:8+together")); }

}  // namespace assur::test
