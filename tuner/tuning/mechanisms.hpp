// Mechanisms that are made for measuring.
#pragma once

#include "assur/scene.hpp"

namespace assur::tuning {

// A level as wide as one likes of the smallest groups: dyads that hang on the end of one crank, n = 2 each.
[[nodiscard]] Scene dyads(int count);

}  // namespace assur::tuning
