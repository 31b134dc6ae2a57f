// Groups in solving order: the declared ones, the irreducible ones, or one for everything.
#pragma once

#include <string>
#include <vector>

#include "assur/strategy.hpp"
#include "structure/blocks.hpp"

namespace assur {

// A group before it is known what the outputs need of it.
struct Draft {
  std::string name;
  std::vector<Index> blocks;
  Index of = 0;       // unknowns
  Index level = 0;    // above every group whose unknowns it reads
  bool keep = false;  // solved as a whole, whatever the outputs need
};

// Every block in exactly one group; a declared group may be without any (all its coordinates are driven). Throws Error
// (input) for a declared group that is no union of blocks, or that needs a block which needs it in turn.
[[nodiscard]] std::vector<Draft> form_groups(const System& system, const Blocks& blocks, Formulation formulation);

}  // namespace assur
