#include "graph/spins.hpp"

#include <algorithm>

#include "index.hpp"
#include "scene/names.hpp"

namespace assur {
namespace {

constexpr std::size_t kMostNamed = 12;  // a choice: a message of a line or two

bool is_point(const System& s, const std::string& name) { return s.item(name).dimension == 1; }

}  // namespace

std::vector<Spin> spins(const System& s, std::span<const Index> free) {
  std::vector<Spin> out;
  if (s.dimension == 2) return out;
  std::vector<bool> is_free(s.coordinates.size(), false);
  for (const Index u : free) is_free[idx(u)] = true;
  const auto moves = [&](const std::string& name) {
    const Item& item = s.item(name);
    return std::any_of(item.form, item.form + item.components, [&](Index f) {
      const auto terms = s.form(f);
      return std::any_of(terms.begin(), terms.end(), [&](const Term& t) { return is_free[idx(t.coordinate)]; });
    });
  };
  for (const Body& b : s.scene->bodies()) {
    Spin spin{b.name, "", {}, {}};
    std::vector<std::string> held;
    std::vector<std::string> own = b.base;
    if (const std::string normal = b.name + ".normal"; s.find_item(normal) >= 0) own.push_back(normal);
    for (const std::string& name : own) {
      const Item& item = s.item(name);
      if (!moves(name)) {
        held.push_back(name);
        continue;
      }
      if (is_point(s, name)) spin.beside.push_back(name);
      for (int k = 0; k < item.components; ++k) {
        for (const Term& t : s.form(item.form[k])) {
          if (is_free[idx(t.coordinate)]) spin.unknowns.push_back(t.coordinate);
        }
      }
    }
    // the second point or direction of the line
    if (held.size() != 2 || spin.unknowns.empty()) continue;
    if (!is_point(s, held[0])) std::swap(held[0], held[1]);
    if (!is_point(s, held[0])) continue;
    spin.line =
        "the line through " + in_quotes(held[0]) + (is_point(s, held[1]) ? " and " : " along ") + in_quotes(held[1]);
    for (const Member& m : b.points) {
      if (moves(m.name)) spin.beside.push_back(m.name);
    }
    std::sort(spin.unknowns.begin(), spin.unknowns.end());
    spin.unknowns.erase(std::unique(spin.unknowns.begin(), spin.unknowns.end()), spin.unknowns.end());
    out.push_back(std::move(spin));
  }
  return out;
}

std::string some_of(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i == kMostNamed) return text + ", ... (" + std::to_string(names.size()) + " in all)";
    text += (i == 0 ? "" : ", ") + in_quotes(names[i]);
  }
  return text;
}

}  // namespace assur
