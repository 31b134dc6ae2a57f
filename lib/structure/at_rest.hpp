// Groups at rest: no driver moves them, or their drivers have constant laws.
#pragma once

#include <algorithm>
#include <cstdint>

#include "assur/structure.hpp"

namespace assur {

// How a structure has the groups at rest that its outputs need.
enum class AtRest : std::uint8_t {
  left_out,  // as static coordinates, which are solved with the start posture
  in_front,  // as groups before all others, so that many mechanisms can solve them side by side
};

[[nodiscard]] Structure analyze(const Scene& scene, const StructureOptions& options, AtRest at_rest);

[[nodiscard]] inline bool rests(const GroupClass& c) {
  return std::none_of(c.input_moves.begin(), c.input_moves.end(), [](std::uint8_t moves) { return moves != 0; });
}

}  // namespace assur
