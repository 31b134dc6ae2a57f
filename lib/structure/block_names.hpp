// Blocks by the points, vectors and scalars that they solve, for messages.
#pragma once

#include <string>

#include "structure/blocks.hpp"

namespace assur {

// At most four items: "B1+e1+r1", "A+B+C+D+...".
[[nodiscard]] std::string block_name(const System& system, const Blocks& blocks, Index block);
// All of them: "B1, e1, r1".
[[nodiscard]] std::string all_names(const System& system, const Blocks& blocks, Index block);
// The declared group that the block belongs to, else its own name.
[[nodiscard]] std::string group_or_block_name(const System& system, const Blocks& blocks, Index block);

}  // namespace assur
