#include "graph/demand.hpp"

#include <algorithm>

namespace assur {

std::vector<std::int8_t> needed_by_outputs(const System& s, const std::vector<Output>& outputs) {
  std::vector<std::int8_t> need(s.coordinates.size(), -1);
  for (const Output& o : outputs) {
    for (const OutputPart& part : o.parts()) {
      for (const Index f : part.forms) {
        for (const Term& t : s.form(f)) {
          std::int8_t& n = need[static_cast<std::size_t>(t.coordinate)];
          n = std::max(n, static_cast<std::int8_t>(o.derivatives()));
        }
      }
    }
  }
  return need;
}

void require_inputs(const System& s, std::span<const Index> equations, int derivatives,
                    std::vector<std::int8_t>& need) {
  std::vector<Index> mentioned;
  for (const Index e : equations) {
    s.mentioned(e, mentioned);
    for (const Index c : mentioned) {
      std::int8_t& n = need[static_cast<std::size_t>(c)];
      n = std::max(n, static_cast<std::int8_t>(derivatives));
    }
  }
}

std::vector<std::uint8_t> needed_blocks(const System& s, const Blocks& blocks, std::vector<std::int8_t>& need) {
  std::vector<std::uint8_t> needed(static_cast<std::size_t>(blocks.size()), 0);
  for (Index b = blocks.size() - 1; b >= 0; --b) {
    const auto u = blocks.unknowns_of(b);
    if (std::none_of(u.begin(), u.end(), [&](Index c) { return need[static_cast<std::size_t>(c)] >= 0; })) continue;
    needed[static_cast<std::size_t>(b)] = 1;
    require_inputs(s, blocks.equations_of(b), 0, need);
  }
  return needed;
}

}  // namespace assur
