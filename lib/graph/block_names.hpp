// Names of blocks for messages, made of the points, vectors and scalars that they solve.
#pragma once

#include <string>

#include "graph/blocks.hpp"

namespace assur {

// A name of at most four items: "B1+e1+r1", "A+B+C+D+...".
[[nodiscard]] std::string block_name(const System& system, const Blocks& blocks, Index block);
// All items: "B1, e1, r1".
[[nodiscard]] std::string all_names(const System& system, const Blocks& blocks, Index block);
// Name of the declared group of the block, else block_name().
[[nodiscard]] std::string group_or_block_name(const System& system, const Blocks& blocks, Index block);

}  // namespace assur
