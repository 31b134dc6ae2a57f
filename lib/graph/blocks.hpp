// Irreducible blocks of the graph of equations and unknowns: maximum matching, Dulmage-Mendelsohn decomposition,
// strongly connected components (CXSparse).
#pragma once

#include <span>
#include <vector>

#include "equations/system.hpp"

namespace assur {

// The decomposition.
struct Blocks {
  // Block b has the unknowns and equations [start[b], start[b + 1]). Blocks are in solving order: by level, then by
  // their first unknown.
  std::vector<Index> start = {0};
  std::vector<Index> equations;
  std::vector<Index> unknowns;
  std::vector<Index> level;              // blocks
  std::vector<Index> needs_start = {0};  // blocks + 1
  std::vector<Index> needs;              // blocks whose unknowns a block reads

  // Structurally over- and underdetermined parts: both empty if every unknown is matched with an equation.
  std::vector<Index> surplus_equations;  // equations of the overdetermined part, more than unknowns
  std::vector<Index> surplus_unknowns;   // unknowns of the underdetermined part
  std::vector<Index> over_unknowns;      // unknowns of the overdetermined part
  std::vector<Index> under_equations;

  [[nodiscard]] Index size() const { return static_cast<Index>(start.size()) - 1; }
  [[nodiscard]] bool square() const { return surplus_equations.empty() && surplus_unknowns.empty(); }
  [[nodiscard]] std::span<const Index> equations_of(Index b) const { return slice(equations, start, b); }
  [[nodiscard]] std::span<const Index> unknowns_of(Index b) const { return slice(unknowns, start, b); }
  [[nodiscard]] std::span<const Index> needs_of(Index b) const { return slice(needs, needs_start, b); }

 private:
  static std::span<const Index> slice(const std::vector<Index>& v, const std::vector<Index>& s, Index b) {
    return {v.data() + s[static_cast<std::size_t>(b)], v.data() + s[static_cast<std::size_t>(b) + 1]};
  }
};

[[nodiscard]] Blocks decompose(const System& system, std::span<const Index> equations, std::span<const Index> unknowns);

}  // namespace assur
