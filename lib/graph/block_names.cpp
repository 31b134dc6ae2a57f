#include "graph/block_names.hpp"

#include <algorithm>

#include "index.hpp"

namespace assur {
namespace {

std::string names(const System& s, std::span<const Index> unknowns, std::size_t most, const char* separator) {
  std::vector<std::string> found;
  for (std::size_t k = 0; k < unknowns.size() && found.size() <= most;) {
    // Names a whole point or vector if possible, else single coordinates.
    const Index id = s.coordinates[idx(unknowns[k])].item;
    std::size_t end = k;
    while (end < unknowns.size() && s.coordinates[idx(unknowns[end])].item == id) ++end;
    if (static_cast<int>(end - k) == s.items[idx(id)].components) {
      found.push_back(s.items[idx(id)].name);
    } else {
      for (std::size_t i = k; i < end; ++i) found.push_back(s.coordinate_name(unknowns[i]));
    }
    k = end;
  }
  std::string out;
  for (std::size_t i = 0; i < std::min(found.size(), most); ++i) out += (i == 0 ? "" : separator) + found[i];
  return found.size() > most ? out + separator + "..." : out;
}

}  // namespace

std::string block_name(const System& s, const Blocks& blocks, Index b) {
  return names(s, blocks.unknowns_of(b), 4, "+");
}

std::string all_names(const System& s, const Blocks& blocks, Index b) {
  return names(s, blocks.unknowns_of(b), 1000, ", ");
}

std::string group_or_block_name(const System& s, const Blocks& blocks, Index b) {
  const Index u = blocks.unknowns_of(b).front();
  for (const SystemGroup& g : s.groups) {
    if (std::find(g.unknowns.begin(), g.unknowns.end(), u) != g.unknowns.end()) return g.name;
  }
  return block_name(s, blocks, b);
}

}  // namespace assur
