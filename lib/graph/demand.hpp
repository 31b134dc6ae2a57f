// Coordinates that the outputs need, traced back through the structure.
#pragma once

#include <cstdint>
#include <vector>

#include "equations/outputs.hpp"
#include "graph/blocks.hpp"

namespace assur {

// For each coordinate, the highest derivative that the outputs themselves need; -1: none.
[[nodiscard]] std::vector<std::int8_t> needed_by_outputs(const System& system, const std::vector<Output>& outputs);

// Raises `need` of the coordinates that the equations mention to at least `derivatives`: equations that are solved
// together read all their coordinates up to the derivative that they compute.
void require_inputs(const System& system, std::span<const Index> equations, int derivatives,
                    std::vector<std::int8_t>& need);

// For each block, 1 if its unknowns are needed. Raises `need` of all coordinates that these blocks read.
[[nodiscard]] std::vector<std::uint8_t> needed_blocks(const System& system, const Blocks& blocks,
                                                      std::vector<std::int8_t>& need);

}  // namespace assur
