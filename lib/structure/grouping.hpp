// Groups in solving order: the declared ones, the irreducible ones, or one for everything.
#pragma once

#include <string>
#include <vector>

#include "assur/strategy.hpp"
#include "graph/blocks.hpp"

namespace assur {

// A group before the cut to the outputs.
struct Draft {
  std::string name;
  std::vector<Index> blocks;
  Index of = 0;       // unknowns
  Index level = 0;    // above every group whose unknowns it reads
  bool keep = false;  // solved as a whole, whatever the outputs need
};

// Puts every block into exactly one group. A declared group has no block if all its coordinates are driven. Throws
// Error (input) if a declared group is not a union of blocks, or if it and another block need each other.
[[nodiscard]] std::vector<Draft> form_groups(const System& system, const Blocks& blocks, Formulation formulation);

}  // namespace assur
