#include "graph/idle_parts.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "equations/outputs.hpp"
#include "graph/demand.hpp"
#include "graph/spins.hpp"
#include "index.hpp"

namespace assur {
namespace {

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

// A note for each body that spins, and one for all others that the part moves.
void describe(const System& s, const IdlePart& part, std::vector<Diagnostic>& notes) {
  std::set<std::string> items, bodies, spinning;
  std::set<Index> rest(part.unknowns.begin(), part.unknowns.end());
  for (const Spin& spin : spins(s, part.unknowns)) {
    spinning.insert(spin.body);
    for (const Index u : spin.unknowns) rest.erase(u);
    notes.push_back(
        {"/bodies/" + spin.body,
         "the body may turn about " + spin.line + "; no output and no driver depends on this turn, so " +
             (spin.beside.empty() ? "it is" : "its points beside the line, " + some_of(spin.beside) + ", are") +
             " not computed"});
  }
  if (rest.empty()) return;
  for (const Index u : rest) items.insert(s.items[idx(s.coordinates[idx(u)].item)].name);
  const auto is_own = [&](const std::string& name) { return items.count(name) != 0; };
  for (const Body& b : s.scene->bodies()) {
    if (spinning.count(b.name) != 0) continue;
    if (is_own(b.origin) || std::any_of(b.frame.begin(), b.frame.end(), is_own) ||
        std::any_of(b.base.begin(), b.base.end(), is_own)) {
      bodies.insert(b.name);
    }
  }
  const std::set<std::string>& all = bodies.empty() ? items : bodies;
  notes.push_back({"/", "nothing determines the position of " + some_of({all.begin(), all.end()}) +
                            "; no output and no driver depends on it, so it stays as written and is not computed"});
}

// Removes the terms with the coefficient 0 whose coordinate is listed in `of`. False: there are none.
bool remove_zeros(System& s, const std::vector<bool>& of) {
  std::vector<Term> terms;
  std::vector<Index> start = {0};
  for (Index f = 0; f < s.forms(); ++f) {
    for (const Term& t : s.form(f)) {
      if (!of[idx(t.coordinate)] || s.constants[idx(t.constant)] != 0) terms.push_back(t);
    }
    start.push_back(static_cast<Index>(terms.size()));
  }
  if (terms.size() == s.terms.size()) return false;
  s.terms = std::move(terms);
  s.form_start = std::move(start);
  return true;
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
    describe(s, part, idle.notes);
    idle.unknowns.insert(idle.unknowns.end(), part.unknowns.begin(), part.unknowns.end());
    idle.equations.insert(idle.equations.end(), part.equations.begin(), part.equations.end());
  }
  std::sort(idle.unknowns.begin(), idle.unknowns.end());
  std::sort(idle.equations.begin(), idle.equations.end());
  return idle;
}

bool separate_idle_parts(System& s, std::span<const Index> unknowns) {
  System without = s;
  std::vector<bool> of(s.coordinates.size(), false);
  for (const Index u : unknowns) of[idx(u)] = true;
  if (!remove_zeros(without, of)) return false;
  std::vector<Index> equations, mentioned;
  for (Index e = 0; e < static_cast<Index>(without.equations.size()); ++e) {
    without.mentioned(e, mentioned);
    if (std::any_of(mentioned.begin(), mentioned.end(), [&](Index c) { return of[idx(c)]; })) equations.push_back(e);
  }
  const IdleParts idle = find_idle_parts(without, decompose(without, equations, unknowns));
  std::fill(of.begin(), of.end(), false);
  for (const Index u : idle.unknowns) of[idx(u)] = true;
  return remove_zeros(s, of);
}

}  // namespace assur
