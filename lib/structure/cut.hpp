// The part of a structure that is solved at each step: blocks that move and that the outputs need.
#pragma once

#include <cstdint>
#include <vector>

#include "graph/blocks.hpp"
#include "structure/grouping.hpp"

namespace assur {

// Needs of coordinates, blocks and groups.
struct Cut {
  // Highest derivative, 0 to 2; -1: not even positions.
  struct Derivatives {
    int wanted = -1;    // highest derivative that the outputs need, directly or through other groups
    int computed = -1;  // including derivatives for the predictor
  };
  std::vector<std::uint8_t> moves;         // coordinates: 0 if the value never changes
  std::vector<std::uint8_t> block_moves;   // blocks
  std::vector<std::uint8_t> block_needed;  // blocks
  std::vector<std::int8_t> need;           // coordinates: highest derivative that is needed; -1: none
  std::vector<Derivatives> groups;         // in the order of the drafts

  [[nodiscard]] bool is_static(Index block) const { return block_moves[static_cast<std::size_t>(block)] == 0; }
  [[nodiscard]] bool is_needed(Index block) const { return block_needed[static_cast<std::size_t>(block)] != 0; }
  [[nodiscard]] bool solved_each_step(Index block) const { return is_needed(block) && !is_static(block); }
};

// `checks`: watched equations; their coordinates must be computed, too.
[[nodiscard]] Cut cut_to_outputs(const System& system, const Blocks& blocks, const std::vector<Draft>& drafts,
                                 std::span<const Index> checks, int predictor_derivatives);

}  // namespace assur
