#include "structure/classes.hpp"

#include <algorithm>

#include "index.hpp"
#include "structure/class_gears.hpp"

namespace assur {
namespace {

constexpr Index kAbsent = -2;  // no index

class Hash {
 public:
  void add(Index v) { h_ = (h_ ^ static_cast<std::uint32_t>(v)) * 1099511628211ULL; }
  [[nodiscard]] std::size_t value() const { return static_cast<std::size_t>(h_); }

 private:
  std::uint64_t h_ = 1469598103934665603ULL;
};

std::size_t hash(const LocalEquations& e) {
  const GroupClass& c = e.outline;
  Hash h;
  for (const Index v : {c.n, c.inputs, c.constants, c.derivatives, c.first_wanted}) h.add(v);
  for (const auto m : c.input_moves) h.add(m);
  for (const Index f : e.form_start) h.add(f);
  for (const auto& t : e.terms) h.add(t.coordinate), h.add(t.constant);
  for (const auto& p : e.products) h.add(p.a), h.add(p.b), h.add(p.constant);
  for (const Index b : c.unknown_block) h.add(b);
  for (const Index b : c.equation_block) h.add(b);
  for (const auto& of : e.equations) h.add(of.products_end), h.add(of.linear);
  return h.value();
}

}  // namespace

ClassTable::ClassTable(const System& system, const std::vector<std::uint8_t>& moves)
    : system_(system), moves_(moves), local_coordinate_(system.coordinates.size(), kAbsent) {}

Index ClassTable::first_like(Index callback) {
  auto gear = gear_of_class(system_.callbacks[idx(callback)]);
  if (!gear) return callback;
  const auto found =
      std::find_if(gears_.begin(), gears_.end(), [&](const auto& known) { return known.first == *gear; });
  if (found != gears_.end()) return found->second;
  gears_.emplace_back(std::move(*gear), callback);
  return callback;
}

void ClassTable::classify(const GroupContent& content, SolvedGroup& group) {
  const System& s = system_;
  LocalEquations of;
  GroupClass& c = of.outline;
  c.n = static_cast<Index>(content.unknowns.size());
  c.derivatives = content.derivatives;
  c.first_wanted = content.first_wanted;
  c.blocks = content.blocks;
  c.unknown_block = content.unknown_block;
  c.equation_block = content.equation_block;

  group.unknowns = content.unknowns;
  group.equations = content.equations;
  group.inputs.clear();
  group.constants.clear();
  group.n = c.n;
  group.derivatives = content.derivatives;

  local_coordinate_[kOne] = -1;
  for (Index i = 0; i < c.n; ++i) local_coordinate_[idx(content.unknowns[idx(i)])] = i;
  std::unordered_map<Index, Index> local_constant;
  const auto constant = [&](Index global) -> Index {
    if (global == kPlus) return -1;
    if (global == kMinus) return -2;
    const auto [it, added] = local_constant.try_emplace(global, c.constants);
    if (added) {
      ++c.constants;
      group.constants.push_back(global);
    }
    return it->second;
  };
  const auto coordinate = [&](Index global) {
    Index& local = local_coordinate_[idx(global)];
    if (local == kAbsent) {
      local = c.n + c.inputs++;
      group.inputs.push_back(global);
      c.input_moves.push_back(moves_[idx(global)]);
    }
    return local;
  };
  // Equal forms are stored once: one difference of coordinates serves all equations of a group.
  std::unordered_multimap<std::size_t, Index> form_by_hash;
  const auto form = [&](Index global) -> Index {
    const std::size_t first = of.terms.size();
    Hash h;
    for (const Term& t : s.form(global)) {
      of.terms.push_back({coordinate(t.coordinate), constant(t.constant)});
      h.add(of.terms.back().coordinate);
      h.add(of.terms.back().constant);
    }
    const auto [begin, end] = form_by_hash.equal_range(h.value());
    for (auto it = begin; it != end; ++it) {
      const auto from = of.terms.begin() + of.form_start[idx(it->second)];
      const auto to = of.terms.begin() + of.form_start[idx(it->second) + 1];
      if (std::equal(from, to, of.terms.begin() + static_cast<std::ptrdiff_t>(first), of.terms.end())) {
        of.terms.resize(first);
        return it->second;
      }
    }
    of.form_start.push_back(static_cast<Index>(of.terms.size()));
    form_by_hash.emplace(h.value(), of.forms() - 1);
    return of.forms() - 1;
  };
  for (const Index id : content.equations) {
    const Equation& e = s.equations[idx(id)];
    LocalEquations::Equation local{static_cast<Index>(of.products.size()), 0, -1, -1, e.row};
    if (e.callback >= 0) {
      local.callback = first_like(e.callback);
      for (const Index f : s.callbacks[idx(e.callback)].coordinates) {
        const Index argument = form(f);
        of.products.push_back({argument, -1, -1});
      }
    } else {
      local.row = 0;
    }
    if (e.linear >= 0) local.linear = form(e.linear);
    for (const Product& p : s.products_of(e)) {
      const Index a = form(p.a), b = form(p.b);
      of.products.push_back({a, b, constant(p.constant)});
    }
    local.products_end = static_cast<Index>(of.products.size());
    of.equations.push_back(local);
  }
  for (LocalEquations::Equation& e : of.equations) {
    if (e.callback < 0) continue;
    auto gear = gear_of_class(s.callbacks[idx(e.callback)]);
    if (!gear) continue;
    e.gear = static_cast<Index>(of.gears.size());
    of.gears.push_back(std::move(*gear));
  }
  for (const Index u : content.unknowns) local_coordinate_[idx(u)] = kAbsent;
  for (const Index i : group.inputs) local_coordinate_[idx(i)] = kAbsent;

  const std::size_t h = hash(of);
  const auto [begin, end] = by_hash_.equal_range(h);
  for (auto it = begin; it != end; ++it) {
    if (written_[idx(it->second)] == of) {
      group.group_class = it->second;
      return;
    }
  }
  group.group_class = static_cast<Index>(classes_.size());
  by_hash_.emplace(h, group.group_class);
  classes_.push_back(write_class(of));
  written_.push_back(std::move(of));
}

}  // namespace assur
