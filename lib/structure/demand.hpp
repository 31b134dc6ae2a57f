// What the outputs need, traced back through the structure.
#pragma once

#include <cstdint>
#include <vector>

#include "scene/outputs.hpp"
#include "structure/blocks.hpp"

namespace assur {

// Highest derivative needed of each coordinate by the outputs themselves; -1: none.
[[nodiscard]] std::vector<std::int8_t> needed_by_outputs(const System& system, const std::vector<Output>& outputs);

// A set of equations solved together reads all its coordinates up to the derivative that it computes.
// Raises `need` of the coordinates that the equations mention to at least `derivatives`.
void require_inputs(const System& system, std::span<const Index> equations, int derivatives,
                    std::vector<std::int8_t>& need);

// The blocks whose unknowns are needed, 1 each; `need` is raised at everything that they read.
[[nodiscard]] std::vector<std::uint8_t> needed_blocks(const System& system, const Blocks& blocks,
                                                      std::vector<std::int8_t>& need);

}  // namespace assur
