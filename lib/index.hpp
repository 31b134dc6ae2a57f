// Indices into the lists of a scene, a system or a structure; -1 where there is none.
#pragma once

#include <cstddef>
#include <cstdint>

namespace assur {

using Index = std::int32_t;

// The index as a subscript of a container.
constexpr std::size_t idx(Index i) { return static_cast<std::size_t>(i); }

}  // namespace assur
