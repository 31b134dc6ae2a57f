// Bodies in space that turn freely about a line.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "equations/system.hpp"

namespace assur {

// A body with free unknowns, in whose base two entries are determined: a point, and a second point or a direction.
struct Spin {
  std::string body;
  std::string line;                 // "the line through 'P' and 'Q'"
  std::vector<std::string> beside;  // points of the body that the turn moves
  std::vector<Index> unknowns;      // free unknowns of the body; ascending
};

// The bodies that spin if these unknowns are free.
[[nodiscard]] std::vector<Spin> spins(const System& system, std::span<const Index> free);

// "'A', 'B', ... (20 in all)"
[[nodiscard]] std::string some_of(const std::vector<std::string>& names);

}  // namespace assur
