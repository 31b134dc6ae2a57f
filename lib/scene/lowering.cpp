#include "scene/lowering.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <unordered_set>

#include "scene/drive.hpp"

namespace assur {
namespace {

using Triple3 = std::array<Triple, 3>;

Triple operator-(const Triple& a, const Triple& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Triple operator*(double s, const Triple& a) { return {s * a[0], s * a[1], s * a[2]}; }
double dot(const Triple& a, const Triple& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double norm(const Triple& a) { return std::sqrt(dot(a, a)); }
Triple cross(const Triple& a, const Triple& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

constexpr Index kNext[3] = {1, 2, 0};
constexpr Index kAfter[3] = {2, 0, 1};

// Median binary exponent of the lengths that the scene shows: typical lengths become about 1, and scaling all of
// them by 2^k moves the median by exactly k.
int length_exponent(const Scene& scene) {
  std::vector<int> exponents;
  const auto see = [&](double length) {
    if (length > 0 && std::isfinite(length)) exponents.push_back(std::ilogb(length));
  };
  std::unordered_map<std::string_view, const Triple*> at;
  for (const Point& p : scene.points()) at.emplace(p.name, &p.at);
  for (const Body& b : scene.bodies()) {
    for (const Member& m : b.points) see(norm(m.local));
  }
  const auto see_pair = [&](const std::string& a, const std::string& b) {
    const auto i = at.find(a), j = at.find(b);
    if (i != at.end() && j != at.end()) see(norm(*i->second - *j->second));
  };
  for (const Constraint& c : scene.constraints()) {
    if (const auto* d = std::get_if<Distance>(&c.kind)) {
      if (d->value) {
        see(*d->value);
      } else {
        see_pair(d->p, d->q);
      }
    }
    if (const auto* l = std::get_if<OnLine>(&c.kind)) see_pair(l->p, l->a);
  }
  for (const Driver& d : scene.drivers()) {
    if (const auto* a = std::get_if<PointAngle>(&d.kind)) see_pair(a->a, a->b);
    if (const auto* a = std::get_if<DrivenDistance>(&d.kind)) see_pair(a->a, a->b);
  }
  if (exponents.empty()) {
    for (const Point& p : scene.points()) see(norm(p.at));
  }
  if (exponents.empty()) return 0;
  const auto middle = exponents.begin() + static_cast<std::ptrdiff_t>(exponents.size() / 2);
  std::nth_element(exponents.begin(), middle, exponents.end());
  return *middle;
}

class Lowering {
 public:
  Lowering(std::shared_ptr<const Scene> scene, std::span<const std::string> controlled, bool declared_groups)
      : with_groups_(declared_groups), controlled_(controlled.begin(), controlled.end()) {
    s_.scene = std::move(scene);
    s_.dimension = scene_().dimension();
    s_.length_exponent = length_exponent(scene_());
    s_.constants = {1.0, -1.0};
    s_.coordinates.push_back({-1, -1, 0, Role::one, false});
    s_.guess.push_back(1.0);
  }

  System run() {
    note_lengths();
    declare_points_and_vectors();
    declare_bodies();
    declare_auxiliaries();
    declare_groups();
    absorb_distances();
    fix_driven_coordinates();
    body_equations();
    unit_equations();
    for (const Constraint& c : scene_().constraints()) constrain(c);
    drive_what_is_left();
    declare_measures();
    set_driven_guess();
    for (Item& it : s_.items) it.fixed = is_fixed(it);
    return std::move(s_);
  }

 private:
  const Scene& scene_() const { return *s_.scene; }
  int dim() const { return s_.dimension; }

  // ---- constants, forms, items

  double scaled(double value, int power) const { return std::ldexp(value, -s_.length_exponent * power); }

  Index constant(double value, int power = 0) {
    s_.constants.push_back(scaled(value, power));
    return static_cast<Index>(s_.constants.size()) - 1;
  }

  using Terms = std::vector<Term>;

  Index form(const Terms& terms) {
    s_.terms.insert(s_.terms.end(), terms.begin(), terms.end());
    s_.form_start.push_back(static_cast<Index>(s_.terms.size()));
    return s_.forms() - 1;
  }
  Index constant_form(double value, int power) { return form({{kOne, constant(value, power)}}); }

  double value(Index id) const { return s_.constants[static_cast<std::size_t>(id)]; }

  // A literal times a value is the value's constant, or a new one.
  Index times(Index a, Index b) {
    if (a == kPlus) return b;
    if (b == kPlus) return a;
    if (a == kMinus && b == kMinus) return kPlus;
    s_.constants.push_back(value(a) * value(b));
    return static_cast<Index>(s_.constants.size()) - 1;
  }

  void append(Terms& out, Index f, Index factor) {
    const auto [begin, end] = std::pair(s_.form_start[idx(f)], s_.form_start[idx(f) + 1]);
    for (Index i = begin; i < end; ++i) {
      const Term t = s_.terms[idx(i)];
      const Index c = times(factor, t.constant);
      const auto same = std::find_if(out.begin(), out.end(), [&](const Term& o) { return o.coordinate == t.coordinate; });
      if (same == out.end()) {
        out.push_back({t.coordinate, c});
      } else if (t.coordinate == kOne) {
        s_.constants.push_back(value(same->constant) + value(c));
        same->constant = static_cast<Index>(s_.constants.size()) - 1;
      } else {
        // Both ends on one body: the coefficients add up; a literal sum of zero drops out by type.
        const bool literal = same->constant < kLiterals && c < kLiterals;
        if (literal && same->constant != c) {
          out.erase(same);
        } else {
          s_.constants.push_back(value(same->constant) + value(c));
          same->constant = static_cast<Index>(s_.constants.size()) - 1;
        }
      }
    }
  }

  Index combination(std::initializer_list<std::pair<Index, Index>> parts) {  // (form, constant)
    Terms terms;
    for (const auto& [f, c] : parts) append(terms, f, c);
    return form(terms);
  }
  Index difference(Index a, Index b) { return combination({{a, kPlus}, {b, kMinus}}); }

  static std::size_t idx(Index i) { return static_cast<std::size_t>(i); }

  Index add_item(Item item) {
    const Index id = static_cast<Index>(s_.items.size());
    s_.item_of.emplace(item.name, id);
    s_.items.push_back(std::move(item));
    return id;
  }
  const Item& item(const std::string& name) const { return s_.items[idx(s_.item_of.at(name))]; }

  Index add_coordinate(Index item, int component, int power, Role role, double guess, bool moving = true) {
    s_.coordinates.push_back(
        {item, static_cast<std::int8_t>(component), static_cast<std::int8_t>(power), role, moving});
    s_.guess.push_back(scaled(guess, power));
    return static_cast<Index>(s_.coordinates.size()) - 1;
  }
  Index coordinate_form(Index coordinate) { return form({{coordinate, kPlus}}); }

  Index add_scalar(const std::string& name, int power, Role role, double guess, bool hidden = false) {
    Item it;
    it.name = name;
    it.dimension = static_cast<std::int8_t>(power);
    it.hidden = hidden;
    const Index id = add_item(it);
    s_.items[idx(id)].form[0] = coordinate_form(add_coordinate(id, -1, power, role, guess));
    return id;
  }

  void declare(const std::string& name, const Triple& at, bool fixed, int power) {
    Item it;
    it.name = name;
    it.components = static_cast<std::int8_t>(dim());
    it.dimension = static_cast<std::int8_t>(power);
    const Index id = add_item(it);
    for (int k = 0; k < dim(); ++k) {
      const double a = at[static_cast<std::size_t>(k)];
      s_.items[idx(id)].form[k] =
          fixed ? constant_form(a, power) : coordinate_form(add_coordinate(id, k, power, Role::unknown, a));
    }
  }

  // Posture as written, SI units.
  Triple at(const Item& it) const {
    Triple r{};
    for (int k = 0; k < it.components; ++k) {
      r[static_cast<std::size_t>(k)] =
          std::ldexp(form_value<double>(s_, it.form[k], s_.guess), s_.length_exponent * it.dimension);
    }
    return r;
  }
  Triple at(const std::string& name) const { return at(item(name)); }
  Triple at(const Direction& d) const { return d.is_pair() ? at(d.second) - at(d.first) : at(d.first); }

  bool is_point(const Item& it) const { return it.dimension == 1; }

  struct Components {
    Index form[3];
    int power;
  };
  Components direction(const Direction& d) {
    Components c{};
    if (!d.is_pair()) {
      const Item& it = item(d.first);
      std::copy_n(it.form, 3, c.form);
      c.power = it.dimension;
      return c;
    }
    const Item a = item(d.first), b = item(d.second);
    for (int k = 0; k < dim(); ++k) c.form[k] = difference(b.form[k], a.form[k]);
    c.power = 1;
    return c;
  }

  // ---- equations

  Index source(std::string name) {
    s_.sources.push_back({std::move(name)});
    row_ = 0;
    return static_cast<Index>(s_.sources.size()) - 1;
  }
  void equation(Index source, const std::vector<Product>& products, const Terms& linear) {
    Equation e;
    e.products_begin = static_cast<Index>(s_.products.size());
    s_.products.insert(s_.products.end(), products.begin(), products.end());
    e.products_end = static_cast<Index>(s_.products.size());
    e.linear = linear.empty() ? -1 : form(linear);
    e.source = source;
    e.row = row_++;
    s_.equations.push_back(e);
  }
  void add_dot(std::vector<Product>& out, const Index* d, const Index* e, Index factor = kPlus) {
    for (int k = 0; k < dim(); ++k) out.push_back({d[k], e[k], factor});
  }

  // ---- declarations

  void note_lengths() {
    for (const Constraint& c : scene_().constraints()) {
      const auto* d = std::get_if<Distance>(&c.kind);
      if (d != nullptr && d->value) given_length_[pair_key(d->p, d->q)] = *d->value;
    }
  }

  void declare_points_and_vectors() {
    for (const Point& p : scene_().points()) declare(p.name, p.at, p.fixed, 1);
    for (const Vector& v : scene_().vectors()) {
      declare(v.name, v.at, v.fixed, 0);
      if (v.fixed || !v.unit) no_unit_.insert(v.name);
    }
  }

  void declare_member(const Member& m, int power, const Index (&f)[3]) {
    Item it;
    it.name = m.name;
    it.components = static_cast<std::int8_t>(dim());
    it.dimension = static_cast<std::int8_t>(power);
    it.derived = true;
    std::copy_n(f, 3, it.form);
    add_item(it);
  }

  void declare_bodies() {
    for (const Body& b : scene_().bodies()) {
      if (b.name == "ground") {
        for (const Member& m : b.points) declare(m.name, m.local, true, 1);
        for (const Member& m : b.vectors) declare(m.name, m.local, true, 0);
      } else if (!b.frame.empty()) {
        declare_frame_members(b);
      } else if (!b.base.empty()) {
        declare_base_members(b);
      } else {
        declare_translating_members(b);
      }
    }
  }

  void declare_translating_members(const Body& b) {
    const Item o = item(b.origin);
    for (const Member& m : b.points) {
      Index f[3] = {-1, -1, -1};
      for (int k = 0; k < dim(); ++k) {
        f[k] = combination({{o.form[k], kPlus}, {constant_form(m.local[static_cast<std::size_t>(k)], 1), kPlus}});
      }
      declare_member(m, 1, f);
    }
    for (const Member& m : b.vectors) {
      Index f[3] = {-1, -1, -1};
      for (int k = 0; k < dim(); ++k) f[k] = constant_form(m.local[static_cast<std::size_t>(k)], 0);
      declare_member(m, 0, f);
    }
  }

  void declare_frame_members(const Body& b) {
    const Item o = item(b.origin);
    std::vector<Item> axes;
    for (const std::string& a : b.frame) axes.push_back(item(a));
    const auto member = [&](const Member& m, bool point) {
      Index f[3] = {-1, -1, -1};
      for (int k = 0; k < dim(); ++k) {
        Terms terms;
        if (point) append(terms, o.form[k], kPlus);
        if (dim() == 3) {
          for (std::size_t j = 0; j < 3; ++j) append(terms, axes[j].form[k], constant(m.local[j], point));
        } else {  // v = u turned left
          append(terms, axes[0].form[k], constant(m.local[0], point));
          append(terms, axes[0].form[1 - k], constant(k == 0 ? -m.local[1] : m.local[1], point));
        }
        f[k] = form(terms);
      }
      declare_member(m, point ? 1 : 0, f);
    };
    for (const Member& m : b.points) member(m, true);
    for (const Member& m : b.vectors) member(m, false);
  }

  // Local axes of a base of points, in ground coordinates as written.
  Triple3 base_axes(const Body& b) const {
    const Triple x = at(b.base[1]) - at(b.base[0]);
    const Triple e1 = (1 / norm(x)) * x;
    if (dim() == 2) return {e1, Triple{-e1[1], e1[0], 0}, Triple{0, 0, 1}};
    const Triple n = cross(e1, at(b.base[2]) - at(b.base[0]));
    const Triple e3 = (1 / norm(n)) * n;
    return {e1, cross(e3, e1), e3};
  }

  // Local coordinates of a base of points: (0, 0), (length, 0) and in space (x, y). Lengths are those of distance
  // constraints with a value, else of the points as written.
  struct BaseShape {
    double length, x = 0, y = 0;
  };
  BaseShape base_shape(const Body& b) const {
    const auto given = [&](std::size_t i, std::size_t j) { return given_length_.find(pair_key(b.base[i], b.base[j])); };
    const auto length = [&](std::size_t i, std::size_t j) {
      const auto found = given(i, j);
      return found != given_length_.end() ? found->second : norm(at(b.base[j]) - at(b.base[i]));
    };
    BaseShape shape{length(0, 1)};
    if (dim() == 2) return shape;
    const auto none = given_length_.end();
    if (given(0, 1) == none && given(0, 2) == none && given(1, 2) == none) {
      const Triple3 axes = base_axes(b);
      const Triple third = at(b.base[2]) - at(b.base[0]);
      shape.x = dot(third, axes[0]);
      shape.y = dot(third, axes[1]);
      return shape;
    }
    const double p = shape.length, q = length(0, 2), r = length(1, 2);
    if (!(p < q + r && q < p + r && r < p + q)) {
      throw Error(Error::Kind::input, {{"/bodies/" + b.name + "/base",
                                        "the distances between its three points make no triangle; each must be smaller "
                                        "than the sum of the others"}});
    }
    shape.x = ((p - r) * (p + r) + q * q) / (2 * p);
    shape.y = std::sqrt((q - shape.x) * (q + shape.x));
    return shape;
  }

  void declare_base_members(const Body& b) {
    const Item a = item(b.base[0]), second = item(b.base[1]);
    const auto [length, cx, cy] = base_shape(b);
    if (dim() == 2) {
      const auto member = [&](const Member& m, bool point) {
        const double alpha = m.local[0] / length, beta = m.local[1] / length;
        Index f[3] = {-1, -1, -1};
        for (int k = 0; k < 2; ++k) {
          const Index along = difference(second.form[k], a.form[k]);
          const Index across = difference(second.form[1 - k], a.form[1 - k]);
          Terms terms;
          if (point) append(terms, a.form[k], kPlus);
          append(terms, along, constant(alpha, point ? 0 : -1));
          append(terms, across, constant(k == 0 ? -beta : beta, point ? 0 : -1));
          f[k] = form(terms);
        }
        declare_member(m, point ? 1 : 0, f);
      };
      for (const Member& m : b.points) member(m, true);
      for (const Member& m : b.vectors) member(m, false);
      return;
    }
    const Item third = item(b.base[2]);
    const auto out_of_plane = [](const Member& m) { return m.local[2] != 0; };
    const bool with_normal = std::any_of(b.points.begin(), b.points.end(), out_of_plane) ||
                             std::any_of(b.vectors.begin(), b.vectors.end(), out_of_plane);
    if (with_normal) {
      declare(b.name + ".normal", base_axes(b)[2], false, 0);
      no_unit_.insert(b.name + ".normal");
      area_[b.name] = length * cy;
    }
    const auto member = [&](const Member& m, bool point) {
      const double beta = m.local[1] / cy, alpha = (m.local[0] - beta * cx) / length;
      Index f[3] = {-1, -1, -1};
      for (int k = 0; k < 3; ++k) {
        Terms terms;
        if (point) append(terms, a.form[k], kPlus);
        append(terms, difference(second.form[k], a.form[k]), constant(alpha, point ? 0 : -1));
        append(terms, difference(third.form[k], a.form[k]), constant(beta, point ? 0 : -1));
        if (with_normal) append(terms, item(b.name + ".normal").form[k], constant(m.local[2], point ? 1 : 0));
        f[k] = form(terms);
      }
      declare_member(m, point ? 1 : 0, f);
    };
    for (const Member& m : b.points) member(m, true);
    for (const Member& m : b.vectors) member(m, false);
  }

  double guess_lambda(const Triple& d, const Triple& e) const {
    const double dd = dot(d, d);
    return dd > 0 ? dot(d, e) / dd : 0;
  }

  void declare_auxiliaries() {
    const auto power = [&](const Direction& d) { return d.is_pair() ? 1 : int{item(d.first).dimension}; };
    for (const Constraint& c : scene_().constraints()) {
      if (const auto* p = std::get_if<Parallel>(&c.kind)) {
        add_scalar(c.name + ".lambda", power(p->e) - power(p->d), Role::unknown, guess_lambda(at(p->d), at(p->e)));
      } else if (const auto* l = std::get_if<OnLine>(&c.kind)) {
        add_scalar(c.name + ".lambda", 1 - power(l->d), Role::unknown, guess_lambda(at(l->d), at(l->p) - at(l->a)));
      } else if (const auto* o = std::get_if<OnPlane>(&c.kind)) {
        const Triple d = at(o->d), e = at(o->e), r = at(o->p) - at(o->a);
        const double dd = dot(d, d), de = dot(d, e), ee = dot(e, e), det = dd * ee - de * de;
        const double lambda = det > 0 ? (dot(d, r) * ee - dot(e, r) * de) / det : 0;
        const double mu = det > 0 ? (dot(e, r) * dd - dot(d, r) * de) / det : 0;
        add_scalar(c.name + ".lambda", 1 - power(o->d), Role::unknown, lambda);
        add_scalar(c.name + ".mu", 1 - power(o->e), Role::unknown, mu);
      }
    }
    for (const Driver& d : scene_().drivers()) {
      const auto* r = std::get_if<RelativeAngle>(&d.kind);
      if (r == nullptr) continue;
      add_scalar(d.name + ".rho", power(r->d) + power(r->e), Role::unknown, norm(at(r->d)) * norm(at(r->e)));
      if (dim() == 3 && !is_fixed(item(r->axis))) {
        declare(d.name + ".across", cross(at(r->axis), at(r->d)), false, power(r->d));
        no_unit_.insert(d.name + ".across");
      }
    }
  }

  void declare_groups() {
    if (!with_groups_) return;
    for (const DeclaredGroup& g : scene_().groups()) {
      SystemGroup group{g.name, {}, g.keep};
      for (const std::string& name : g.unknowns) {
        const Item& it = item(name);
        for (int k = 0; k < it.components; ++k) {
          const Index c = s_.form(it.form[k])[0].coordinate;
          group.unknowns.push_back(c);
          declared_.insert(c);
        }
      }
      s_.groups.push_back(std::move(group));
    }
  }

  // ---- what is known

  bool known(Index f) const {
    const auto terms = s_.form(f);
    return std::all_of(terms.begin(), terms.end(),
                       [&](const Term& t) { return s_.coordinates[idx(t.coordinate)].role != Role::unknown; });
  }
  bool is_fixed(const Item& it) const {
    for (int k = 0; k < it.components; ++k) {
      for (const Term& t : s_.form(it.form[k])) {
        if (t.coordinate != kOne) return false;
      }
    }
    return true;
  }
  bool all_known(const Item& it) const {
    for (int k = 0; k < it.components; ++k) {
      if (!known(it.form[k])) return false;
    }
    return true;
  }
  // A coordinate of its own that may vanish: not derived, not declared in a group.
  Index own_coordinate(Index f) const {
    const auto terms = s_.form(f);
    if (terms.size() != 1 || terms[0].constant != kPlus || terms[0].coordinate == kOne) return -1;
    return s_.coordinates[idx(terms[0].coordinate)].role == Role::unknown ? terms[0].coordinate : -1;
  }

  bool may_vanish(const Item& it) const {
    for (int k = 0; k < it.components; ++k) {
      const Index c = own_coordinate(it.form[k]);
      if (c < 0 || declared_.count(c) != 0) return false;
    }
    return true;
  }

  bool form_moves(Index f) const {
    const auto terms = s_.form(f);
    return std::any_of(terms.begin(), terms.end(),
                       [&](const Term& t) { return s_.coordinates[idx(t.coordinate)].moving && t.coordinate != kOne; });
  }

  void assign(Index coordinate, Index f) {
    s_.coordinates[idx(coordinate)].role = Role::driven;
    s_.coordinates[idx(coordinate)].moving = form_moves(f);
    s_.assignments.push_back({coordinate, f});
  }

  // The driver's known scalars, as hidden coordinates.
  const DriverInput& add_input(const Driver& driver, Index driver_index, DriverInput::Kind kind, std::vector<Law> laws,
                               int power, Index count) {
    DriverInput in;
    in.driver = driver_index;
    in.kind = kind;
    in.first = static_cast<Index>(s_.coordinates.size());
    in.count = count;
    in.dimension = static_cast<std::int8_t>(power);
    const bool moving = controlled_.count(driver.name) != 0 ||
                        !std::all_of(laws.begin(), laws.end(), [](const Law& l) { return l.is_constant(); });
    in.laws = std::move(laws);
    Item it;
    it.name = driver.name;
    it.dimension = static_cast<std::int8_t>(power);
    it.hidden = true;
    const Index id = add_item(it);
    for (Index k = 0; k < count; ++k) {
      const bool translation = kind == DriverInput::Kind::frame && k < dim();
      const bool scalar = kind == DriverInput::Kind::scalar;
      const Index c =
          add_coordinate(id, scalar ? -1 : static_cast<int>(k), translation || scalar ? power : 0, Role::driven, 0, moving);
      const Index f = coordinate_form(c);
      if (k < 3) s_.items[idx(id)].form[k] = f;
      if (k == 0) input_form_[driver_index] = f;
    }
    s_.inputs.push_back(std::move(in));
    return s_.inputs.back();
  }
  Index input_form(Index driver, Index k) const { return input_form_.at(driver) + k; }

  static std::pair<std::string, std::string> pair_key(const std::string& a, const std::string& b) {
    return std::minmax(a, b);
  }

  void absorb_distances() {
    std::map<std::pair<std::string, std::string>, std::string> angle_of;
    for (const Driver& d : scene_().drivers()) {
      if (const auto* a = std::get_if<PointAngle>(&d.kind)) angle_of[pair_key(a->a, a->b)] = d.name;
    }
    for (const Constraint& c : scene_().constraints()) {
      const auto* d = std::get_if<Distance>(&c.kind);
      if (d == nullptr) continue;
      written_.insert(pair_key(d->p, d->q));
      const auto found = angle_of.find(pair_key(d->p, d->q));
      if (found == angle_of.end()) continue;
      absorbed_.insert(c.name);
      if (d->value) radius_[found->second] = *d->value;
    }
  }

  // Inputs of the drivers; then, as long as something changes, coordinates that drivers fix become known.
  void fix_driven_coordinates() {
    const auto& drivers = scene_().drivers();
    for (std::size_t i = 0; i < drivers.size(); ++i) {
      const Driver& d = drivers[i];
      const Index n = static_cast<Index>(i);
      using K = DriverInput::Kind;
      if (const auto* a = std::get_if<PointAngle>(&d.kind)) {
        add_input(d, n, K::direction, {a->law}, 0, 2);
      } else if (const auto* r = std::get_if<RelativeAngle>(&d.kind)) {
        add_input(d, n, K::direction, {r->law}, 0, 2);
      } else if (const auto* l = std::get_if<DrivenDistance>(&d.kind)) {
        add_input(d, n, K::scalar, {l->law}, 1, 1);
        s_.inputs.back().must_not_vanish = true;
      } else if (const auto* c = std::get_if<DrivenCoordinate>(&d.kind)) {
        add_input(d, n, K::scalar, {c->law}, scalar_dimension(c->coordinate), 1);
      } else if (const auto* p = std::get_if<Pose>(&d.kind)) {
        std::vector<Law> laws = p->translation;
        laws.insert(laws.end(), p->rotation.begin(), p->rotation.end());
        const Index count = p->rotation.empty() ? dim() : (dim() == 3 ? 12 : 4);
        add_input(d, n, K::frame, std::move(laws), 1, count);
      }
    }
    done_.assign(drivers.size(), false);
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t i = 0; i < drivers.size(); ++i) {
        if (!done_[i] && try_fix(drivers[i], static_cast<Index>(i))) changed = done_[i] = true;
      }
    }
  }

  int scalar_dimension(const std::string& coordinate) const {
    const auto whole = s_.item_of.find(coordinate);
    if (whole != s_.item_of.end()) return s_.items[idx(whole->second)].dimension;
    return item(coordinate.substr(0, coordinate.rfind('.'))).dimension;
  }
  Index scalar_form(const std::string& coordinate) const {
    const auto whole = s_.item_of.find(coordinate);
    if (whole != s_.item_of.end()) return s_.items[idx(whole->second)].form[0];
    const std::size_t point = coordinate.rfind('.');
    return item(coordinate.substr(0, point)).form[coordinate[point + 1] - 'x'];
  }

  bool try_fix(const Driver& d, Index n) {
    if (const auto* c = std::get_if<DrivenCoordinate>(&d.kind)) {
      const Index own = own_coordinate(scalar_form(c->coordinate));
      if (own < 0 || declared_.count(own) != 0) return false;
      assign(own, input_form(n, 0));
      return true;
    }
    if (const auto* a = std::get_if<PointAngle>(&d.kind)) {
      const Item from = item(a->a), to = item(a->b);
      if (!all_known(from) || !may_vanish(to)) return false;
      for (int k = 0; k < dim(); ++k) assign(s_.form(to.form[k])[0].coordinate, arm_end(d, *a, n, k));
      return true;
    }
    if (const auto* p = std::get_if<Pose>(&d.kind)) {
      const Body& b = body(p->body);
      const std::vector<PoseTarget> targets = pose_targets(b, n);
      if (!std::all_of(targets.begin(), targets.end(), [&](const PoseTarget& t) { return may_vanish(item(t.item)); })) {
        return false;
      }
      for (const PoseTarget& t : targets) {
        const Item it = item(t.item);
        for (int k = 0; k < dim(); ++k) assign(s_.form(it.form[k])[0].coordinate, t.form[k]);
      }
      posed_.insert(b.name);
      return true;
    }
    return false;
  }

  const Body& body(const std::string& name) const {
    const auto& bodies = scene_().bodies();
    return *std::find_if(bodies.begin(), bodies.end(), [&](const Body& b) { return b.name == name; });
  }

  // B = A + r (cos, sin) in the plane; A + z n + r (cos e1 + sin e2) about a fixed axis n in space.
  Index arm_end(const Driver& d, const PointAngle& a, Index n, int k) {
    const Triple ab = at(a.b) - at(a.a);
    const auto given = radius_.find(d.name);
    const double length = given != radius_.end() ? given->second : norm(ab);
    const Item from = item(a.a);
    Terms terms;
    append(terms, from.form[k], kPlus);
    if (dim() == 2) {
      append(terms, input_form(n, k), constant(length, 1));
      return form(terms);
    }
    const Triple axis = at(a.axis);
    const double z = dot(ab, axis);
    const Triple across = ab - z * axis;
    const Triple e1 = (1 / norm(across)) * across, e2 = cross(axis, e1);
    const double r = std::sqrt(length * length - z * z);
    const auto at_k = [&](const Triple& v) { return v[static_cast<std::size_t>(k)]; };
    append(terms, constant_form(z * at_k(axis), 1), kPlus);
    append(terms, input_form(n, 0), constant(r * at_k(e1), 1));
    append(terms, input_form(n, 1), constant(r * at_k(e2), 1));
    return form(terms);
  }

  struct PoseTarget {
    std::string item;
    Index form[3];
  };
  // The base of a body as forms of its driver's frame.
  std::vector<PoseTarget> pose_targets(const Body& b, Index n) {
    std::vector<PoseTarget> out;
    const auto axis = [&](int j, int k) { return input_form(n, dim() + j * dim() + k); };
    const auto add = [&](const std::string& name, bool point, std::initializer_list<std::pair<int, double>> local) {
      PoseTarget t{name, {-1, -1, -1}};
      for (int k = 0; k < dim(); ++k) {
        Terms terms;
        if (point) append(terms, input_form(n, k), kPlus);
        for (const auto& [j, l] : local) append(terms, axis(j, k), point ? constant(l, 1) : kPlus);
        t.form[k] = form(terms);
      }
      out.push_back(t);
    };
    if (!b.frame.empty()) {
      add(b.origin, true, {});
      for (std::size_t j = 0; j < b.frame.size(); ++j) add(b.frame[j], false, {{static_cast<int>(j), 1}});
    } else if (!b.base.empty()) {
      const BaseShape shape = base_shape(b);
      add(b.base[0], true, {});
      add(b.base[1], true, {{0, shape.length}});
      if (b.base.size() > 2) add(b.base[2], true, {{0, shape.x}, {1, shape.y}});
    } else {
      add(b.origin, true, {});
    }
    return out;
  }

  // ---- equations of bodies and vectors

  void body_equations() {
    std::set<std::vector<std::string>> framed;
    for (std::size_t i = 0; i < scene_().bodies().size(); ++i) {
      const Body& b = scene_().bodies()[i];
      if (b.name == "ground") continue;
      if (!b.frame.empty() && dim() == 3) {
        for (const std::string& a : b.frame) no_unit_.insert(a);
        if (framed.insert(b.frame).second) frame_equations(b, static_cast<Index>(i));
      } else if (!b.frame.empty() && posed_by_equations(b)) {
        no_unit_.insert(b.frame[0]);
      } else if (!b.base.empty()) {
        base_equations(b);
      }
    }
  }

  void unit_equation(Index from, const Item& v) {
    std::vector<Product> products;
    add_dot(products, v.form, v.form);
    equation(from, products, {{kOne, kMinus}});
  }

  // w - u x v = 0 for a cyclic triple.
  void cross_equations(Index from, const Item& w, const Item& u, const Item& v) {
    for (int k = 0; k < 3; ++k) {
      Terms linear;
      append(linear, w.form[k], kPlus);
      const Index a = kNext[k], b = kAfter[k];
      equation(from, {{u.form[a], v.form[b], kMinus}, {u.form[b], v.form[a], kPlus}}, linear);
    }
  }

  bool posed_by_equations(const Body& b) const {
    const auto& drivers = scene_().drivers();
    for (std::size_t i = 0; i < drivers.size(); ++i) {
      const auto* p = std::get_if<Pose>(&drivers[i].kind);
      if (p != nullptr && p->body == b.name && !done_[i]) return true;
    }
    return false;
  }

  void frame_equations(const Body& b, Index index) {
    const Item axis[3] = {item(b.frame[0]), item(b.frame[1]), item(b.frame[2])};
    if (all_known(axis[0]) && all_known(axis[1]) && all_known(axis[2])) return;
    s_.frames.push_back({{s_.item_of.at(b.frame[0]), s_.item_of.at(b.frame[1]), s_.item_of.at(b.frame[2])}, index});
    if (posed_by_equations(b)) return;  // drive_what_is_left() writes them
    const Index from = source("body " + b.name);
    // With one axis fixed: a unit vector across it and the third by the cross product.
    int fixed = -1;
    for (int j = 0; j < 3; ++j) {
      if (all_known(axis[j])) fixed = j;
    }
    if (fixed < 0) {
      unit_equation(from, axis[0]);
      unit_equation(from, axis[1]);
      std::vector<Product> products;
      add_dot(products, axis[0].form, axis[1].form);
      equation(from, products, {});
      cross_equations(from, axis[2], axis[0], axis[1]);
      return;
    }
    const Item& f = axis[fixed];
    const Item& u = axis[kNext[fixed]];
    const Item& v = axis[kAfter[fixed]];
    if (!all_known(u)) {
      unit_equation(from, u);
      std::vector<Product> products;
      add_dot(products, u.form, f.form);
      equation(from, products, {});
    }
    if (!all_known(v)) cross_equations(from, v, f, u);
  }

  void base_equations(const Body& b) {
    const auto rigid = [&](const std::string& p, const std::string& q) {
      const Item a = item(p), c = item(q);
      if ((all_known(a) && all_known(c)) || !written_.insert(pair_key(p, q)).second) return;
      distance_equation(source("body " + b.name), a, c, norm(at(p) - at(q)));
    };
    if (!posed_by_equations(b)) {
      rigid(b.base[0], b.base[1]);
      if (dim() == 3) {
        rigid(b.base[0], b.base[2]);
        rigid(b.base[1], b.base[2]);
      }
    }
    const auto area = area_.find(b.name);
    if (area == area_.end()) return;
    // area * normal = (B - A) x (C - A)
    const Item n = item(b.name + ".normal"), p = item(b.base[0]), q = item(b.base[1]), r = item(b.base[2]);
    const Index from = source("body " + b.name);
    Index x[3], y[3];
    for (int k = 0; k < 3; ++k) {
      x[k] = difference(q.form[k], p.form[k]);
      y[k] = difference(r.form[k], p.form[k]);
    }
    for (int k = 0; k < 3; ++k) {
      Terms linear;
      append(linear, n.form[k], constant(area->second, 2));
      equation(from, {{x[kNext[k]], y[kAfter[k]], kMinus}, {x[kAfter[k]], y[kNext[k]], kPlus}}, linear);
    }
  }

  void unit_equations() {
    for (const Vector& v : scene_().vectors()) {
      if (no_unit_.count(v.name) != 0 || all_known(item(v.name))) continue;
      unit_equation(source("|" + v.name + "| = 1"), item(v.name));
    }
  }

  // ---- constraints

  void distance_equation(Index from, const Item& p, const Item& q, double length) {
    std::vector<Product> products;
    for (int k = 0; k < dim(); ++k) {
      const Index d = difference(p.form[k], q.form[k]);
      products.push_back({d, d, kPlus});
    }
    const Index l = constant_form(length, 1);
    products.push_back({l, l, kMinus});
    equation(from, products, {});
  }

  void constrain(const Constraint& c) {
    if (absorbed_.count(c.name) != 0) return;
    std::visit([&](const auto& kind) { constrain(c.name, kind); }, c.kind);
  }

  void constrain(const std::string& name, const Distance& c) {
    const Item p = item(c.p), q = item(c.q);
    distance_equation(source(name), p, q, c.value ? *c.value : norm(at(c.p) - at(c.q)));
  }

  void constrain(const std::string& name, const EqualDistance& c) {
    const Item p = item(c.p), q = item(c.q), r = item(c.r), s = item(c.s);
    std::vector<Product> products;
    for (int k = 0; k < dim(); ++k) {
      const Index d = difference(p.form[k], q.form[k]);
      products.push_back({d, d, kPlus});
    }
    for (int k = 0; k < dim(); ++k) {
      const Index d = difference(r.form[k], s.form[k]);
      products.push_back({d, d, kMinus});
    }
    equation(source(name), products, {});
  }

  void constrain(const std::string& name, const Dot& c) {
    const Components d = direction(c.d), e = direction(c.e);
    std::vector<Product> products;
    add_dot(products, d.form, e.form);
    const double v = c.value ? *c.value : dot(at(c.d), at(c.e));
    equation(source(name), products, {{kOne, constant(-v, d.power + e.power)}});
  }

  // P - A - lambda d (- mu e) = 0, and e - lambda d = 0
  void constrain(const std::string& name, const Parallel& c) {
    const Components d = direction(c.d), e = direction(c.e);
    const Index lambda = item(name + ".lambda").form[0];
    const Index from = source(name);
    for (int k = 0; k < dim(); ++k) {
      Terms linear;
      append(linear, e.form[k], kPlus);
      equation(from, {{lambda, d.form[k], kMinus}}, linear);
    }
  }
  void constrain(const std::string& name, const OnLine& c) {
    const Components d = direction(c.d);
    const Item p = item(c.p), a = item(c.a);
    const Index lambda = item(name + ".lambda").form[0];
    const Index from = source(name);
    for (int k = 0; k < dim(); ++k) {
      Terms linear;
      append(linear, p.form[k], kPlus);
      append(linear, a.form[k], kMinus);
      equation(from, {{lambda, d.form[k], kMinus}}, linear);
    }
  }
  void constrain(const std::string& name, const OnPlane& c) {
    const Components d = direction(c.d), e = direction(c.e);
    const Item p = item(c.p), a = item(c.a);
    const Index lambda = item(name + ".lambda").form[0], mu = item(name + ".mu").form[0];
    const Index from = source(name);
    for (int k = 0; k < dim(); ++k) {
      Terms linear;
      append(linear, p.form[k], kPlus);
      append(linear, a.form[k], kMinus);
      equation(from, {{lambda, d.form[k], kMinus}, {mu, e.form[k], kMinus}}, linear);
    }
  }

  void constrain(const std::string& name, const Linear& c) {
    const bool points = std::any_of(c.terms.begin(), c.terms.end(), [&](const auto& t) { return is_point(item(t.first)); });
    const Index from = source(name);
    std::vector<Index> factor;
    for (const auto& [what, f] : c.terms) factor.push_back(constant(f, points && !is_point(item(what)) ? 1 : 0));
    for (int k = 0; k < dim(); ++k) {
      Terms linear;
      for (std::size_t i = 0; i < c.terms.size(); ++i) append(linear, item(c.terms[i].first).form[k], factor[i]);
      append(linear, constant_form(-c.value[static_cast<std::size_t>(k)], points), kPlus);  // a zero stays in the pattern
      equation(from, {}, linear);
    }
  }

  void constrain(const std::string& name, const FixedCoordinate& c) {
    Terms linear;
    append(linear, scalar_form(c.coordinate), kPlus);
    append(linear, constant_form(-c.value, scalar_dimension(c.coordinate)), kPlus);
    equation(source(name), {}, linear);
  }

  void constrain(const std::string& name, const Callback& c) {
    CallbackBlock block;
    block.callback = &c;
    for (const std::string& coordinate : c.coordinates) {
      block.coordinates.push_back(scalar_form(coordinate));
      block.unit.push_back(s_.unit(scalar_dimension(coordinate)));
    }
    block.first_equation = static_cast<Index>(s_.equations.size());
    const Index from = source(name);
    for (int r = 0; r < c.equations; ++r) {
      Equation e;
      e.products_begin = e.products_end = static_cast<Index>(s_.products.size());
      e.source = from;
      e.row = r;
      e.callback = static_cast<Index>(s_.callbacks.size());
      s_.equations.push_back(e);
    }
    s_.callbacks.push_back(std::move(block));
  }

  // ---- drivers that do not fix coordinates but add equations

  void drive_what_is_left() {
    const auto& drivers = scene_().drivers();
    for (std::size_t i = 0; i < drivers.size(); ++i) {
      if (done_[i]) continue;
      const Index n = static_cast<Index>(i);
      const Index from = source("driver " + drivers[i].name);
      std::visit([&](const auto& kind) { drive_by_equations(from, drivers[i], kind, n); }, drivers[i].kind);
    }
  }

  void equal(Index from, Index f, Index g) {
    Terms linear;
    append(linear, f, kPlus);
    append(linear, g, kMinus);
    equation(from, {}, linear);
  }

  void drive_by_equations(Index from, const Driver&, const DrivenCoordinate& c, Index n) {
    equal(from, scalar_form(c.coordinate), input_form(n, 0));
  }

  void drive_by_equations(Index from, const Driver& d, const PointAngle& a, Index n) {
    const Item to = item(a.b);
    for (int k = 0; k < dim(); ++k) equal(from, to.form[k], arm_end(d, a, n, k));
  }

  void drive_by_equations(Index from, const Driver&, const DrivenDistance& c, Index n) {
    const Item p = item(c.a), q = item(c.b);
    std::vector<Product> products;
    for (int k = 0; k < dim(); ++k) {
      const Index f = difference(p.form[k], q.form[k]);
      products.push_back({f, f, kPlus});
    }
    products.push_back({input_form(n, 0), input_form(n, 0), kMinus});
    equation(from, products, {});
  }

  // d . e = rho cos, axis . (d x e) = rho sin with the auxiliary rho = |d||e| > 0: regular in every posture.
  void drive_by_equations(Index from, const Driver& driver, const RelativeAngle& r, Index n) {
    const Components d = direction(r.d), e = direction(r.e);
    const Index rho = item(driver.name + ".rho").form[0];
    std::vector<Product> products;
    add_dot(products, d.form, e.form);
    products.push_back({rho, input_form(n, 0), kMinus});
    equation(from, products, {});
    products.clear();
    if (dim() == 2) {
      products = {{d.form[0], e.form[1], kPlus}, {d.form[1], e.form[0], kMinus}};
    } else if (is_fixed(item(r.axis))) {
      const Triple a = at(r.axis);
      for (int k = 0; k < 3; ++k) {
        const double c = a[static_cast<std::size_t>(k)];
        products.push_back({d.form[kNext[k]], e.form[kAfter[k]], constant(c)});
        products.push_back({d.form[kAfter[k]], e.form[kNext[k]], constant(-c)});
      }
    } else {
      const Item across = item(driver.name + ".across"), axis = item(r.axis);
      for (int k = 0; k < 3; ++k) {  // across = axis x d
        Terms linear;
        append(linear, across.form[k], kPlus);
        equation(from,
                 {{axis.form[kNext[k]], d.form[kAfter[k]], kMinus}, {axis.form[kAfter[k]], d.form[kNext[k]], kPlus}},
                 linear);
      }
      add_dot(products, across.form, e.form);
    }
    products.push_back({rho, input_form(n, 1), kMinus});
    equation(from, products, {});
  }

  // In a declared group the base stays unknown. For a frame: O = o, |u|=|v|=|w|=1, u.v=u.w=v.w=0, v.a=w.a=w.b=0.
  void drive_by_equations(Index from, const Driver&, const Pose& p, Index n) {
    const Body& b = body(p.body);
    if (b.frame.size() < 3) {
      for (const PoseTarget& t : pose_targets(b, n)) {
        const Item it = item(t.item);
        for (int k = 0; k < dim(); ++k) equal(from, it.form[k], t.form[k]);
      }
      return;
    }
    const Item o = item(b.origin);
    for (int k = 0; k < 3; ++k) equal(from, o.form[k], input_form(n, k));
    const Item axis[3] = {item(b.frame[0]), item(b.frame[1]), item(b.frame[2])};
    for (const Item& a : axis) unit_equation(from, a);
    const auto normal_to = [&](const Index* x, const Index* y) {
      std::vector<Product> products;
      add_dot(products, x, y);
      equation(from, products, {});
    };
    normal_to(axis[0].form, axis[1].form);
    normal_to(axis[0].form, axis[2].form);
    normal_to(axis[1].form, axis[2].form);
    const Index a[3] = {input_form(n, 3), input_form(n, 4), input_form(n, 5)};
    const Index c[3] = {input_form(n, 6), input_form(n, 7), input_form(n, 8)};
    normal_to(axis[1].form, a);
    normal_to(axis[2].form, a);
    normal_to(axis[2].form, c);
  }

  // ---- measures and start

  void declare_measures() {
    using K = MeasureForms::Kind;
    for (const Measure& m : scene_().measures()) {
      MeasureForms out;
      out.name = m.name;
      const auto take = [&](const Components& c) {
        for (int k = 0; k < dim(); ++k) out.forms.push_back(c.form[k]);
      };
      if (const auto* a = std::get_if<AbsoluteAngle>(&m.kind)) {
        out.kind = K::absolute_angle;
        take(direction({a->a, a->b}));
      } else if (const auto* b = std::get_if<AngleBetween>(&m.kind)) {
        out.kind = dim() == 2 || !b->axis.empty() ? K::signed_angle : K::unsigned_angle;
        take(direction(b->d));
        take(direction(b->e));
        if (!b->axis.empty()) take(direction(Direction(b->axis)));
      } else if (const auto* d = std::get_if<MeasuredDistance>(&m.kind)) {
        out.kind = K::distance;
        out.dimension = 1;
        take(direction({d->a, d->b}));
      } else if (const auto* c = std::get_if<MeasuredCoordinate>(&m.kind)) {
        out.kind = K::form;
        out.dimension = static_cast<std::int8_t>(scalar_dimension(c->coordinate));
        out.forms.push_back(scalar_form(c->coordinate));
      }
      s_.measures.push_back(std::move(out));
    }
  }

  // Driven coordinates start where their laws say; a guess that disagrees is overruled, with a note.
  void set_driven_guess() {
    const std::vector<double> written = s_.guess;
    (void)drive(s_, scene_().time().start, s_.guess.data(), nullptr, nullptr);
    for (const DriverInput& in : s_.inputs) {
      const Driver& d = scene_().drivers()[idx(in.driver)];
      double off = 0;
      for (const Assignment& a : s_.assignments) {
        for (const Term& t : s_.form(a.form)) {
          if (t.coordinate >= in.first && t.coordinate < in.first + in.count) {
            off = std::max(off, std::abs(s_.guess[idx(a.coordinate)] - written[idx(a.coordinate)]));
          }
        }
      }
      if (off > 1e-6) {
        s_.notes.push_back({"/drivers/" + d.name,
                            "the law's value at the start and `at` disagree; the law wins"});
      }
    }
  }

  System s_;
  bool with_groups_;
  Index row_ = 0;
  std::unordered_set<std::string> controlled_;
  std::unordered_set<std::string> no_unit_;
  std::unordered_set<Index> declared_;
  std::unordered_set<std::string> absorbed_;
  std::set<std::pair<std::string, std::string>> written_;  // pairs whose distance is an equation already
  std::map<std::pair<std::string, std::string>, double> given_length_;  // of distance constraints, by their points
  std::unordered_map<std::string, double> radius_;         // of angle drivers
  std::unordered_map<std::string, double> area_;           // of bodies with a normal
  std::unordered_set<std::string> posed_;
  std::unordered_map<Index, Index> input_form_;  // driver -> form of its first input
  std::vector<bool> done_;
};

}  // namespace

System lower(std::shared_ptr<const Scene> scene, std::span<const std::string> controlled, bool declared_groups) {
  return Lowering(std::move(scene), controlled, declared_groups).run();
}

}  // namespace assur
