#include "structure/demand.hpp"

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

}  // namespace assur
