// What a pack costs where nothing has been measured.
#pragma once

#include "assur/backend.hpp"
#include "assur/strategy.hpp"

namespace assur {

// Seconds for one step of a pack: equations, two factorisations, three solutions, on one thread. From counts and from
// times seen on one processor of 2024; good to a factor of about two, which is enough to share packs out.
[[nodiscard]] double expected_seconds(const Shape& shape, const Strategy& strategy);

}  // namespace assur
