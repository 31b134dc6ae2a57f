#include "side_by_side/parts.hpp"

#include <algorithm>
#include <memory>
#include <numeric>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "program/needs.hpp"

namespace assur {
namespace {

constexpr Index kNobody = -1;
Index by_assignment(std::size_t a) { return -2 - static_cast<Index>(a); }

// Numbers things of the whole in the order in which a part needs them.
class Renumber {
 public:
  explicit Renumber(std::vector<Index>& numbers) : numbers_(numbers) {}
  ~Renumber() {
    for (const Index i : taken_) numbers_[idx(i)] = -1;
  }
  Renumber(const Renumber&) = delete;
  Renumber& operator=(const Renumber&) = delete;

  Index operator()(Index i) {
    Index& number = numbers_[idx(i)];
    if (number < 0) {
      number = static_cast<Index>(taken_.size());
      taken_.push_back(i);
    }
    return number;
  }
  void replace(std::vector<Index>& list) {
    for (Index& i : list) i = (*this)(i);
  }
  [[nodiscard]] bool has(Index i) const { return numbers_[idx(i)] >= 0; }
  [[nodiscard]] const std::vector<Index>& taken() const { return taken_; }  // in the order of their numbers

 private:
  std::vector<Index>& numbers_;
  std::vector<Index> taken_;
};

bool divisible(const Prepared& whole) {
  const std::vector<Group>& groups = whole.structure->groups;
  Needs needs = needs_of(*whole.structure);
  needs.add(Need::targets, !whole.controlled.empty());
  return can_take(Path::parts, needs) &&
         std::none_of(groups.begin(), groups.end(), [](const Group& g) { return g.unknowns.empty(); });
}

}  // namespace

Parts::Parts(const Prepared& whole, std::size_t unknowns)
    : whole_(whole), structure_(*whole.structure), system_(*structure_.system) {
  if (!divisible(whole)) return;
  joined_to_.resize(system_.coordinates.size());
  std::iota(joined_to_.begin(), joined_to_.end(), 0);
  maker_.assign(system_.coordinates.size(), kNobody);
  for (std::size_t i = 0; i < system_.inputs.size(); ++i) {
    const DriverInput& in = system_.inputs[i];
    std::fill_n(maker_.begin() + in.first, in.count, static_cast<Index>(i));
  }
  for (std::size_t a = 0; a < system_.assignments.size(); ++a) {
    maker_[idx(system_.assignments[a].coordinate)] = by_assignment(a);
  }
  for (const Group& g : structure_.groups) {
    for (const Index u : g.unknowns) join(g.unknowns[0], u);
    for (const Index c : g.inputs) {
      if (system_.coordinates[idx(c)].role == Role::unknown) join(g.unknowns[0], c);
    }
  }
  const std::vector<Output> outputs = wanted_outputs(system_);
  const std::vector<Index> unknown_of = join_readings(outputs);
  divide(unknowns);
  if (contents_.size() < 2 || !place(outputs, unknown_of)) contents_.clear();
}

// The component of a coordinate, which all its coordinates share.
Index Parts::component(Index c) {
  while (joined_to_[idx(c)] != c) c = joined_to_[idx(c)] = joined_to_[idx(joined_to_[idx(c)])];
  return c;
}

void Parts::join(Index a, Index b) { joined_to_[idx(component(b))] = component(a); }

template <class Use>
void Parts::each_unknown(std::span<const Index> forms, const Use& use) const {
  for (const Index f : forms) {
    for (const Term& t : system_.form(f)) {
      if (system_.coordinates[idx(t.coordinate)].role == Role::unknown) use(t.coordinate);
    }
  }
}

// Joins the components that one output reads. Returns an unknown of each output, -1 if it has none.
std::vector<Index> Parts::join_readings(std::span<const Output> outputs) {
  std::vector<Index> unknown_of(outputs.size(), -1);
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    const auto use = [&](Index c) {
      if (unknown_of[o] >= 0) join(unknown_of[o], c);
      unknown_of[o] = c;
    };
    for (const OutputPart& part : outputs[o].parts()) each_unknown(part.forms, use);
    for (std::size_t i = 0; outputs[o].sum != nullptr && i < outputs[o].sum->terms.size(); ++i) {
      each_unknown(system_.measures[idx(outputs[o].sum->terms[i].measure)].forms, use);
    }
  }
  return unknown_of;
}

// Gives each component to a part, in the order of the coordinates, and each group to the part of its component.
void Parts::divide(std::size_t unknowns_of_part) {
  std::size_t lanes = 1;
  for (const Plan::Choice& c : whole_.plan.choices) lanes = std::max(lanes, static_cast<std::size_t>(c.solver.lanes));
  std::vector<std::size_t> unknowns(system_.coordinates.size(), 0);  // of a component
  for (const Group& g : structure_.groups) unknowns[idx(component(g.unknowns[0]))] += g.unknowns.size();
  part_.assign(system_.coordinates.size(), -1);
  std::size_t parts = 0, components = 0, size = 0;  // components and unknowns of the last part
  for (Index c = 0; idx(c) < part_.size(); ++c) {
    const Index of = component(c);
    if (unknowns[idx(of)] == 0 || part_[idx(of)] >= 0) continue;
    const bool is_full = components % lanes == 0 && size + lanes * unknowns[idx(of)] > unknowns_of_part;
    if (parts == 0 || is_full) {
      ++parts;
      components = size = 0;
    }
    part_[idx(of)] = static_cast<std::int32_t>(parts) - 1;
    ++components;
    size += unknowns[idx(of)];
  }
  contents_.resize(parts);
  for (std::size_t g = 0; g < structure_.groups.size(); ++g) {
    const Index of = component(structure_.groups[g].unknowns[0]);
    contents_[idx(part_[idx(of)])].groups.push_back(static_cast<std::int32_t>(g));
  }
}

// Coordinates: a part that reads it, or another coordinate of its driver; -1: none.
std::vector<std::int32_t> Parts::readers() const {
  std::vector<std::int32_t> reader(system_.coordinates.size(), -1);
  for (std::size_t p = 0; p < contents_.size(); ++p) {
    for (const std::int32_t g : contents_[p].groups) {
      for (const Index c : structure_.groups[idx(g)].inputs) reader[idx(c)] = static_cast<std::int32_t>(p);
    }
  }
  for (const DriverInput& in : system_.inputs) {
    const std::span<std::int32_t> of = std::span(reader).subspan(idx(in.first), idx(in.count));
    const auto read = std::find_if(of.begin(), of.end(), [](std::int32_t p) { return p >= 0; });
    if (read != of.end()) std::fill(of.begin(), of.end(), std::int32_t{*read});
  }
  return reader;
}

// Gives each output and its columns to a part. False if an output reads several parts, or if a part has none.
bool Parts::place(std::span<const Output> outputs, std::span<const Index> unknown_of) {
  std::unordered_map<std::string_view, Index> measures;
  for (std::size_t m = 0; m < system_.measures.size(); ++m) {
    measures.emplace(system_.measures[m].name, static_cast<Index>(m));
  }
  const std::vector<std::int32_t> reader = readers();
  const auto part_of = [&](std::size_t o) {
    if (unknown_of[o] >= 0) return idx(part_[idx(component(unknown_of[o]))]);
    for (const OutputPart& part : outputs[o].parts()) {
      for (const Index f : part.forms) {
        for (const Term& t : system_.form(f)) {
          if (reader[idx(t.coordinate)] >= 0 && t.coordinate != kOne) return idx(reader[idx(t.coordinate)]);
        }
      }
    }
    return std::size_t{0};
  };
  std::size_t column = 0;  // of the whole
  std::vector<std::size_t> columns(contents_.size(), 0);
  std::unordered_map<std::string_view, std::size_t> part_of_name;
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    const Output& output = outputs[o];
    const std::size_t p = part_of(o);
    Contents& to = contents_[p];
    const auto [place, is_new] = part_of_name.emplace(output.name, p);
    bool in_one_part = place->second == p;
    for (std::size_t i = 0; output.sum != nullptr && i < output.sum->terms.size(); ++i) {
      const auto term =
          part_of_name.find(system_.measures[idx(output.sum->terms[i].measure)].name);  // precedes the sum
      in_one_part = in_one_part && term != part_of_name.end() && term->second == p;
    }
    if (!in_one_part) return false;
    if (is_new) {
      const auto measure = measures.find(output.name);
      if (measure != measures.end()) {
        to.measures.push_back(measure->second);
      } else {
        to.items.push_back(system_.find_item(output.name));
      }
    }
    const auto derivatives = static_cast<std::size_t>(std::count(output.wanted, output.wanted + 3, true));
    const std::size_t count = output.part_count * derivatives;
    if (!to.columns.empty() && to.columns.back().to + to.columns.back().count == column) {
      to.columns.back().count += count;
    } else {
      to.columns.push_back({columns[p], column, count});
    }
    columns[p] += count;
    column += count;
  }
  for (std::size_t i = 0; i < system_.outputs.size(); ++i) {
    const std::string_view text = system_.outputs[i];
    auto found = part_of_name.find(text);
    if (found == part_of_name.end()) found = part_of_name.find(text.substr(0, text.rfind('.')));
    if (found == part_of_name.end()) return false;
    contents_[found->second].outputs.push_back(i);
  }
  // An empty list of outputs would mean all of them.
  const auto asks_nothing = [](const Contents& c) { return c.outputs.empty(); };
  return system_.outputs.empty() || std::none_of(contents_.begin(), contents_.end(), asks_nothing);
}

// The coordinates that a part reads or solves, ascending, with the drivers behind them.
std::vector<Index> Parts::needed_coordinates(const Contents& contents, std::vector<Index>& inputs,
                                             std::vector<Index>& assignments) const {
  std::vector<Index> all = {kOne};
  const auto add_form = [&](Index form) {
    for (const Term& t : system_.form(form)) all.push_back(t.coordinate);
  };
  for (const std::int32_t g : contents.groups) {
    const Group& group = structure_.groups[idx(g)];
    all.insert(all.end(), group.unknowns.begin(), group.unknowns.end());
    all.insert(all.end(), group.inputs.begin(), group.inputs.end());
  }
  for (const Index i : contents.items) {
    const Item& item = system_.items[idx(i)];
    for (int k = 0; k < item.components; ++k) add_form(item.form[k]);
  }
  for (const Index m : contents.measures) {
    for (const Index f : system_.measures[idx(m)].forms) add_form(f);
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Index by = maker_[idx(all[i])];
    if (by == kNobody) continue;
    if (by < 0) {
      assignments.push_back(-2 - by);
      add_form(system_.assignments[idx(-2 - by)].form);
    } else {
      inputs.push_back(by);
    }
  }
  const auto once = [](std::vector<Index>& list) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  };
  once(inputs);
  once(assignments);
  for (const Index i : inputs) {
    for (Index k = 0; k < system_.inputs[idx(i)].count; ++k) all.push_back(system_.inputs[idx(i)].first + k);
  }
  once(all);
  return all;
}

Part Parts::cut(std::size_t p) {
  const Contents& contents = contents_[p];
  for (std::vector<Index>* v : {&new_coordinate_, &new_constant_, &new_form_}) {
    const std::size_t size = v == &new_coordinate_ ? system_.coordinates.size()
                             : v == &new_constant_ ? system_.constants.size()
                                                   : idx(system_.forms());
    v->resize(size, -1);
  }
  Renumber coordinate(new_coordinate_), constant(new_constant_), form(new_form_);
  std::vector<Index> inputs, assignments;
  for (const Index c : needed_coordinates(contents, inputs, assignments)) (void)coordinate(c);
  for (Index k = 0; k < kLiterals; ++k) (void)constant(k);

  auto structure = std::make_shared<Structure>();
  structure->formulation = structure_.formulation;
  structure->levels = structure_.levels;
  Plan plan = whole_.plan;
  plan.choices.clear();
  plan.run.threads = 1;
  plan.level_threads.clear();
  std::vector<std::int32_t> new_class(structure_.classes.size(), -1);
  for (const std::int32_t g : contents.groups) {
    Group& group = structure->groups.emplace_back(structure_.groups[idx(g)]);
    std::int32_t& of = new_class[idx(group.group_class)];
    if (of < 0) {
      of = static_cast<std::int32_t>(structure->classes.size());
      structure->classes.push_back(structure_.classes[idx(group.group_class)]);
      plan.choices.push_back(whole_.plan.choices[idx(group.group_class)]);
      plan.choices.back().group_class = of;
    }
    group.group_class = of;
    coordinate.replace(group.unknowns);
    coordinate.replace(group.inputs);
    constant.replace(group.constants);
    group.equations.clear();
  }

  auto system = std::make_shared<System>();
  system->dimension = system_.dimension;
  system->length_exponent = system_.length_exponent;
  system->teeth = system_.teeth;
  for (const std::size_t i : contents.outputs) system->outputs.push_back(system_.outputs[i]);
  for (const Index i : contents.items) {
    Item& item = system->items.emplace_back(system_.items[idx(i)]);
    for (int k = 0; k < item.components; ++k) item.form[k] = form(item.form[k]);
  }
  system->index_names();
  for (const Index m : contents.measures) {
    MeasureForms& measure = system->measures.emplace_back(system_.measures[idx(m)]);
    form.replace(measure.forms);
    for (MeasureForms::SumTerm& term : measure.terms) {
      const auto at = std::find(contents.measures.begin(), contents.measures.end(), term.measure);
      term.measure = static_cast<Index>(at - contents.measures.begin());
    }
  }
  for (const Index i : inputs) {
    DriverInput& in = system->inputs.emplace_back(system_.inputs[idx(i)]);
    system->drivers.push_back(system_.drivers[idx(in.driver)]);
    in.driver = static_cast<Index>(system->drivers.size()) - 1;
    in.first = coordinate(in.first);
    in.own.clear();
  }
  for (const Index a : assignments) {
    const Assignment& of = system_.assignments[idx(a)];
    system->assignments.push_back({coordinate(of.coordinate), form(of.form)});
  }
  for (const Positive& positive : system_.positive) {
    if (coordinate.has(positive.coordinate))
      system->positive.push_back({coordinate(positive.coordinate), 0, positive.dimension});
  }
  for (const Index f : form.taken()) {
    for (const Term& t : system_.form(f)) system->terms.push_back({coordinate(t.coordinate), constant(t.constant)});
    system->form_start.push_back(static_cast<Index>(system->terms.size()));
  }
  for (const Index c : coordinate.taken()) {
    system->coordinates.push_back(system_.coordinates[idx(c)]);
    system->coordinates.back().item = -1;
    system->guess.push_back(system_.guess[idx(c)]);
    structure->start.push_back(structure_.start[idx(c)]);
  }
  for (const Index k : constant.taken()) system->constants.push_back(system_.constants[idx(k)]);
  structure->system = std::move(system);

  Part out;
  out.prepared.name = whole_.name;
  out.prepared.time = whole_.time;
  out.prepared.structure = std::move(structure);
  out.prepared.plan = std::move(plan);
  out.prepared.table = whole_.table;
  out.prepared.start_time = whole_.start_time;
  out.coordinates = coordinate.taken();
  out.columns = contents.columns;
  return out;
}

}  // namespace assur
