// Mechanisms for measurements.
#pragma once

#include "assur/scene.hpp"

namespace assur::tuning {

// `count` of the smallest groups on one level: dyads (n = 2) at the end of one crank.
[[nodiscard]] Scene dyads(int count);

}  // namespace assur::tuning
