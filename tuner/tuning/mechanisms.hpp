// Mechanisms for measurements.
#pragma once

#include "assur/scene.hpp"

namespace assur::tuning {

// `count` of the smallest groups on one level: dyads (n = 2) at the end of one crank.
[[nodiscard]] Scene dyads(int count);

// `count` tripods (n = 3) in series: a rod leads from the end of a crank to the first, and from each to the next.
[[nodiscard]] Scene tripods(int count);

}  // namespace assur::tuning
