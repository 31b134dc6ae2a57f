// Where +together can be used.
#pragma once

#include <string>

#include "assur/strategy.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

inline constexpr int kLeastTogetherLanes = 4;  // +together takes this W and the wider ones
// Larger groups gain too little to be chosen without a measurement: at n = 9 with one coupled row a fifth of the time.
// With as many coupled rows as unknowns, they lose.
inline constexpr int kMostChosenTogether = 3;  // unknowns

// The reason why +together cannot be used with the other settings of a strategy; "": it can.
[[nodiscard]] std::string why_not_together(const Strategy& strategy);
// The same for the groups of a structure, whatever the number of lanes.
[[nodiscard]] std::string why_not_together(const GroupedSystem& structure);
// The same, with a structure and a strategy.
[[nodiscard]] std::string why_not_together(const GroupedSystem& structure, const Strategy& strategy);

}  // namespace assur
