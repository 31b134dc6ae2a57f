#include "structure/idle_parts.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "index.hpp"
#include "scene/names.hpp"
#include "scene/outputs.hpp"
#include "structure/demand.hpp"

namespace assur {
namespace {

constexpr std::size_t kMostNamed = 12;

struct IdlePart {
  std::vector<Index> unknowns, equations;
  bool is_asked_for = false;
};

// Connected components of the underdetermined unknowns.
std::vector<IdlePart> idle_components(const System& s, const Blocks& blocks) {
  std::vector<Index> parent(s.coordinates.size(), -1);
  for (const Index u : blocks.surplus_unknowns) parent[idx(u)] = u;
  const auto root = [&](Index c) {
    while (parent[idx(c)] != c) c = parent[idx(c)] = parent[idx(parent[idx(c)])];
    return c;
  };
  std::vector<Index> mentioned;
  const auto own = [&](Index e) {
    s.mentioned(e, mentioned);
    std::erase_if(mentioned, [&](Index c) { return parent[idx(c)] < 0; });
  };
  for (const Index e : blocks.under_equations) {
    own(e);
    for (const Index c : mentioned) parent[idx(root(c))] = root(mentioned.front());
  }
  std::map<Index, IdlePart> parts;
  for (const Index u : blocks.surplus_unknowns) parts[root(u)].unknowns.push_back(u);
  for (const Index e : blocks.under_equations) {
    own(e);
    if (!mentioned.empty()) parts[root(mentioned.front())].equations.push_back(e);
  }
  std::vector<IdlePart> out;
  for (auto& [first, part] : parts) out.push_back(std::move(part));
  return out;
}

// The bodies that the part moves, else its points, vectors and scalars.
std::string names_of(const System& s, const IdlePart& part) {
  std::set<std::string> items, bodies;
  for (const Index u : part.unknowns) items.insert(s.items[idx(s.coordinates[idx(u)].item)].name);
  const auto is_own = [&](const std::string& name) { return items.count(name) != 0; };
  for (const Body& b : s.scene->bodies()) {
    if (is_own(b.origin) || std::any_of(b.frame.begin(), b.frame.end(), is_own) ||
        std::any_of(b.base.begin(), b.base.end(), is_own)) {
      bodies.insert(b.name);
    }
  }
  std::string text;
  std::size_t count = 0;
  const std::set<std::string>& all = bodies.empty() ? items : bodies;
  for (const std::string& name : all) {
    if (count++ == kMostNamed) return text + ", ... (" + std::to_string(all.size()) + " in all)";
    text += (text.empty() ? "" : ", ") + in_quotes(name);
  }
  return text;
}

}  // namespace

IdleParts find_idle_parts(const System& s, const Blocks& blocks) {
  IdleParts idle;
  if (blocks.surplus_unknowns.empty()) return idle;
  std::vector<std::int8_t> need = needed_by_outputs(s, wanted_outputs(s));
  for (const SystemGroup& g : s.groups) {
    for (const Index u : g.unknowns) need[idx(u)] = 0;
  }
  for (IdlePart& part : idle_components(s, blocks)) {
    const auto is_needed = [&](Index u) { return need[idx(u)] >= 0; };
    const auto is_of_driver = [&](Index e) { return s.equation_name(e).starts_with("driver "); };
    if (std::any_of(part.unknowns.begin(), part.unknowns.end(), is_needed) ||
        std::any_of(part.equations.begin(), part.equations.end(), is_of_driver)) {
      continue;
    }
    idle.notes.push_back({"/", "nothing determines the position of " + names_of(s, part) +
                                   "; no output and no driver depends on it, so it stays as written and is not "
                                   "computed"});
    idle.unknowns.insert(idle.unknowns.end(), part.unknowns.begin(), part.unknowns.end());
    idle.equations.insert(idle.equations.end(), part.equations.begin(), part.equations.end());
  }
  std::sort(idle.unknowns.begin(), idle.unknowns.end());
  std::sort(idle.equations.begin(), idle.equations.end());
  return idle;
}

}  // namespace assur
