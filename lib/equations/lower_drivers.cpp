#include <algorithm>

#include "equations/lowering_parts.hpp"
#include "index.hpp"
#include "scene/axes.hpp"

namespace assur {

// ---- declarations

void DriverWriter::declare_auxiliaries() {
  find_partners();
  const auto& drivers = forms_.scene().drivers();
  for (std::size_t i = 0; i < drivers.size(); ++i) {
    const Driver& d = drivers[i];
    if (const auto* a = std::get_if<PointAngle>(&d.kind); a != nullptr && forms_.dimension() == 3 && partner_[i] >= 0) {
      const Triple axis = forms_.at(axis_of(*a));
      const Triple across = triple::cross(axis, triple::subtract(forms_.at(a->b), forms_.at(a->a)));
      declare_rho(static_cast<Index>(i), 1, triple::length(across));
    }
    const auto* r = std::get_if<RelativeAngle>(&d.kind);
    if (r == nullptr) continue;
    const Triple from = forms_.at(r->d), to = forms_.at(r->e);
    const int power = forms_.power(r->d) + forms_.power(r->e);
    declare_rho(static_cast<Index>(i), power, triple::length(from) * triple::length(to));
    if (forms_.dimension() == 3 && !forms_.is_fixed(forms_.item(axis_of(*r)))) {
      const std::string across = d.name + ".across";
      forms_.declare(across, triple::cross(forms_.at(axis_of(*r)), from), false, forms_.power(r->d));
      shared_.without_norm.insert(across);
    }
  }
}

void DriverWriter::declare_rho(Index driver, int power, const Number& guess) {
  const std::string name = forms_.scene().drivers()[idx(driver)].name + ".rho";
  forms_.declare_scalar(name, power, guess);
  const Index rho = forms_.system().form(forms_.item(name).form[0])[0].coordinate;
  forms_.system().positive.push_back({rho, driver, static_cast<std::int8_t>(power)});
}

void DriverWriter::find_partners() {
  const auto& drivers = forms_.scene().drivers();
  partner_.assign(drivers.size(), -1);
  std::map<Pair, Index> distance_of;
  for (std::size_t i = 0; i < drivers.size(); ++i) {
    const auto* d = std::get_if<DrivenDistance>(&drivers[i].kind);
    if (d != nullptr) distance_of.emplace(pair_key(d->a, d->b), static_cast<Index>(i));
  }
  if (distance_of.empty()) return;
  for (std::size_t i = 0; i < drivers.size(); ++i) {
    const auto* a = std::get_if<PointAngle>(&drivers[i].kind);
    const auto found = a == nullptr ? distance_of.end() : distance_of.find(pair_key(a->a, a->b));
    if (found == distance_of.end()) continue;
    partner_[i] = found->second;
    partner_[idx(found->second)] = static_cast<Index>(i);
  }
}

void DriverWriter::declare_inputs() {
  const auto& drivers = forms_.scene().drivers();
  for (std::size_t i = 0; i < drivers.size(); ++i) {
    std::visit([&](const auto& kind) { declare_input(drivers[i], static_cast<Index>(i), input(kind)); },
               drivers[i].kind);
  }
}

DriverWriter::Input DriverWriter::input(const PointAngle& a) const {
  return {DriverInput::Kind::direction, {a.law}, 0, 2};
}

DriverWriter::Input DriverWriter::input(const RelativeAngle& r) const {
  return {DriverInput::Kind::direction, {r.law}, 0, 2};
}

DriverWriter::Input DriverWriter::input(const DrivenDistance& d) const {
  return {DriverInput::Kind::scalar, {d.law}, 1, 1, true};
}

DriverWriter::Input DriverWriter::input(const DrivenCoordinate& c) const {
  return {DriverInput::Kind::scalar, {c.law}, forms_.scalar_dimension(c.coordinate), 1};
}

DriverWriter::Input DriverWriter::input(const Pose& p) const {
  std::vector<Law> laws = p.translation;
  laws.insert(laws.end(), p.rotation.begin(), p.rotation.end());
  const int dim = forms_.dimension();
  return {DriverInput::Kind::frame, std::move(laws), 1, p.rotation.empty() ? dim : dim == 3 ? 12 : 4};
}

void DriverWriter::declare_input(const Driver& driver, Index index, const Input& input) {
  const auto& [kind, laws, power, count, must_not_vanish] = input;
  System& s = forms_.system();
  DriverInput in;
  in.driver = index;
  in.kind = kind;
  in.first = static_cast<Index>(s.coordinates.size());
  in.count = count;
  in.dimension = static_cast<std::int8_t>(power);
  const bool moving = controlled_.count(driver.name) != 0 ||
                      !std::all_of(laws.begin(), laws.end(), [](const Law& l) { return l.is_constant(); });
  in.laws = laws;
  in.must_not_vanish = must_not_vanish;
  Item item;
  item.name = driver.name;
  item.dimension = static_cast<std::int8_t>(power);
  item.hidden = true;
  const Index id = forms_.add_item(item);
  first_form_.push_back(s.forms());
  const bool scalar = kind == DriverInput::Kind::scalar;
  for (Index k = 0; k < count; ++k) {
    const bool translation = kind == DriverInput::Kind::frame && k < forms_.dimension();
    const Index f = forms_.coordinate_form(
        forms_.add_coordinate(id, scalar ? -1 : k, translation || scalar ? power : 0, Role::driven, 0, moving));
    if (k < 3) s.items[idx(id)].form[k] = f;
  }
  s.inputs.push_back(std::move(in));
}

// ---- coordinates that drivers fix

void DriverWriter::fix_coordinates() {
  const auto& drivers = forms_.scene().drivers();
  shared_.fixes.assign(drivers.size(), false);
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < drivers.size(); ++i) {
      if (shared_.fixes[i]) continue;
      const auto fixes = [&](const auto& kind) { return fix(drivers[i], kind, static_cast<Index>(i)); };
      if (std::visit(fixes, drivers[i].kind)) changed = shared_.fixes[i] = true;
    }
  }
}

bool DriverWriter::fix(const Driver&, const DrivenCoordinate& c, Index n) {
  const Index coordinate = forms_.own_coordinate(forms_.scalar_form(c.coordinate));
  if (coordinate < 0 || shared_.in_groups.count(coordinate) != 0) return false;
  assign(coordinate, input_form(n, 0));
  return true;
}

bool DriverWriter::fix(const Driver& d, const PointAngle& a, Index n) {
  if (partner(n) >= 0) return false;
  const Item &from = forms_.item(a.a), &to = forms_.item(a.b);
  if (!forms_.all_known(from) || !can_be_fixed(to)) return false;
  for (int k = 0; k < forms_.dimension(); ++k) assign(forms_.own_coordinate(to.form[k]), arm_end(d, a, n, k));
  return true;
}

bool DriverWriter::fix(const Driver&, const Pose& p, Index n) {
  const std::vector<PoseTarget> targets = pose_targets(body(p.body), n);
  const auto free = [&](const PoseTarget& t) { return can_be_fixed(forms_.item(t.item)); };
  if (!std::all_of(targets.begin(), targets.end(), free)) return false;
  for (const PoseTarget& t : targets) {
    for (int k = 0; k < forms_.dimension(); ++k) {
      assign(forms_.own_coordinate(forms_.item(t.item).form[k]), t.form[k]);
    }
  }
  return true;
}

// True if drivers can replace all coordinates of the item: they are its own, and not in a declared group.
bool DriverWriter::can_be_fixed(const Item& item) const {
  for (int k = 0; k < item.components; ++k) {
    const Index c = forms_.own_coordinate(item.form[k]);
    if (c < 0 || shared_.in_groups.count(c) != 0) return false;
  }
  return true;
}

void DriverWriter::assign(Index coordinate, Index form) {
  System& s = forms_.system();
  const auto terms = s.form(form);
  s.coordinates[idx(coordinate)].role = Role::driven;
  s.coordinates[idx(coordinate)].moving =
      std::any_of(terms.begin(), terms.end(), [&](const Term& t) { return s.coordinates[idx(t.coordinate)].moving; });
  s.assignments.push_back({coordinate, form});
}

// The direction from A to B at the angle 0.
Triple DriverWriter::zero_of(const PointAngle& a) const {
  if (forms_.dimension() == 2) return {1, 0, 0};
  const Triple ab = triple::subtract(forms_.at(a.b), forms_.at(a.a)), axis = forms_.at(axis_of(a));
  return direction_of(triple::subtract(ab, triple::scale(triple::dot(ab, axis), axis)));
}

// The part of AB along the axis; 0 in the plane.
Number DriverWriter::along_axis(const PointAngle& a) const {
  if (forms_.dimension() == 2) return 0;
  return triple::dot(triple::subtract(forms_.at(a.b), forms_.at(a.a)), forms_.at(axis_of(a)));
}

// B = A + r (cos, sin) in the plane; A + z n + r (cos e1 + sin e2) about a fixed axis n in space.
Index DriverWriter::arm_end(const Driver& d, const PointAngle& a, Index n, int k) {
  const Triple ab = triple::subtract(forms_.at(a.b), forms_.at(a.a));
  const auto given = shared_.radius.find(d.name);
  const Number length = given != shared_.radius.end() ? given->second : triple::length(ab);
  Terms terms;
  forms_.append(terms, forms_.item(a.a).form[k], kPlus);
  if (forms_.dimension() == 2) {
    forms_.append(terms, input_form(n, k), forms_.constant(length, 1));
    return forms_.form(terms);
  }
  const Triple axis = forms_.at(axis_of(a));
  const Number z = along_axis(a);
  const Triple e1 = zero_of(a), e2 = triple::cross(axis, e1);
  const Number r = sqrt(length * length - z * z);
  const auto at_k = [&](const Triple& v) { return v[static_cast<std::size_t>(k)]; };
  forms_.append(terms, forms_.constant_form(z * at_k(axis), 1), kPlus);
  forms_.append(terms, input_form(n, 0), forms_.constant(r * at_k(e1), 1));
  forms_.append(terms, input_form(n, 1), forms_.constant(r * at_k(e2), 1));
  return forms_.form(terms);
}

std::vector<DriverWriter::PoseTarget> DriverWriter::pose_targets(const Body& b, Index n) {
  using Local = std::initializer_list<std::pair<Index, Number>>;  // (axis, local coordinate), zeros left out
  const Index dim = forms_.dimension();
  std::vector<PoseTarget> out;
  const auto add = [&](const std::string& name, bool point, Local local) {
    PoseTarget t{name, {-1, -1, -1}};
    for (Index k = 0; k < dim; ++k) {
      Terms terms;
      if (point) forms_.append(terms, input_form(n, k), kPlus);
      for (const auto& [j, l] : local) {
        forms_.append(terms, input_form(n, dim + j * dim + k),
                      point || l != 1 ? forms_.constant(l, point ? 1 : 0) : kPlus);
      }
      t.form[k] = forms_.form(terms);
    }
    out.push_back(t);
  };
  if (b.base.empty()) {
    add(b.origin, true, {});
    for (std::size_t j = 0; j < b.frame.size(); ++j) add(b.frame[j], false, {{static_cast<Index>(j), 1}});
    return out;
  }
  const BaseShape shape = base_shape(forms_, shared_, b);
  add(b.base[0], true, {});
  const auto is_point = [&](std::size_t i) { return forms_.item(b.base[i]).dimension == 1; };
  add(b.base[1], is_point(1), {{0, shape.length}});
  if (b.base.size() > 2) add(b.base[2], is_point(2), {{0, shape.x}, {1, shape.y}});
  return out;
}

const Body& DriverWriter::body(const std::string& name) const {
  const auto& bodies = forms_.scene().bodies();
  return *std::find_if(bodies.begin(), bodies.end(), [&](const Body& b) { return b.name == name; });
}

}  // namespace assur
