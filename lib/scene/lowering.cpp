#include "scene/lowering.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "decimal.hpp"
#include "scene/drive.hpp"
#include "scene/lowering_parts.hpp"
#include "scene/names.hpp"
#include "scene/own_values.hpp"

namespace assur {
namespace {

constexpr double kDisagree = 1e-3;  // relative: guesses are written with three digits or more

std::size_t idx(Index i) { return static_cast<std::size_t>(i); }

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
    for (const Member& m : b.points) see(length_of(m.local));
  }
  const auto see_pair = [&](const std::string& a, const std::string& b) {
    const auto i = at.find(a), j = at.find(b);
    if (i != at.end() && j != at.end()) see(length_of(triple::subtract(*i->second, *j->second)));
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
    for (const Point& p : scene.points()) see(length_of(p.at));
  }
  if (exponents.empty()) return 0;
  const auto middle = exponents.begin() + static_cast<std::ptrdiff_t>(exponents.size() / 2);
  std::nth_element(exponents.begin(), middle, exponents.end());
  return *middle;
}

void declare_points_and_vectors(Forms& forms, Shared& shared) {
  for (const Point& p : forms.scene().points()) forms.declare(p.name, p.at, p.fixed, 1);
  for (const Vector& v : forms.scene().vectors()) {
    forms.declare(v.name, v.at, v.fixed, 0);
    if (v.fixed || !v.unit) shared.without_norm.insert(v.name);
  }
}

void declare_groups(Forms& forms, Shared& shared) {
  for (const DeclaredGroup& g : forms.scene().groups()) {
    SystemGroup group{g.name, {}, g.keep};
    for (const std::string& name : g.unknowns) {
      const Item& item = forms.item(name);
      for (int k = 0; k < item.components; ++k) {
        group.unknowns.push_back(forms.system().form(item.form[k])[0].coordinate);
      }
    }
    shared.in_groups.insert(group.unknowns.begin(), group.unknowns.end());
    forms.system().groups.push_back(std::move(group));
  }
}

void write_norms(Forms& forms, const Shared& shared) {
  for (const Vector& v : forms.scene().vectors()) {
    const Item& item = forms.item(v.name);
    if (shared.without_norm.count(v.name) != 0 || forms.all_known(item)) continue;
    forms.unit_equation(forms.source("|" + v.name + "| = 1"), item);
  }
}

void declare_measures(Forms& forms) {
  using K = MeasureForms::Kind;
  const int dim = forms.dimension();
  for (const Measure& m : forms.scene().measures()) {
    MeasureForms out;
    out.name = m.name;
    const auto take = [&](const Direction& d) {
      const Forms::Components c = forms.direction(d);
      out.forms.insert(out.forms.end(), c.form, c.form + dim);
    };
    if (const auto* a = std::get_if<AbsoluteAngle>(&m.kind)) {
      out.kind = K::absolute_angle;
      take({a->a, a->b});
    } else if (const auto* b = std::get_if<AngleBetween>(&m.kind)) {
      out.kind = dim == 2 || !b->axis.empty() ? K::signed_angle : K::unsigned_angle;
      take(b->d);
      take(b->e);
      if (!b->axis.empty()) take(Direction(b->axis));
    } else if (const auto* d = std::get_if<MeasuredDistance>(&m.kind)) {
      out.kind = K::distance;
      out.dimension = 1;
      take({d->a, d->b});
    } else if (const auto* c = std::get_if<MeasuredCoordinate>(&m.kind)) {
      out.kind = K::form;
      out.dimension = static_cast<std::int8_t>(forms.scalar_dimension(c->coordinate));
      out.forms.push_back(forms.scalar_form(c->coordinate));
    }
    forms.system().measures.push_back(std::move(out));
  }
}

// Driven coordinates start where their laws say; a guess that disagrees is overruled, with a note.
void set_driven_guess(System& s) {
  const std::vector<double> written = s.guess;
  (void)drive(s, s.scene->time().start, s.guess.data(), nullptr, nullptr);
  std::vector<double> posture = written;  // as written, with what the laws ask for
  for (DriverInput& in : s.inputs) {
    std::copy_n(s.guess.begin() + in.first, in.count, posture.begin() + in.first);
    in.written = own_values(s, in, written);
    if (!why_undefined(s, in, posture).empty()) continue;
    const std::optional<Mismatch> off = mismatch(s, in, posture, kDisagree);
    if (!off || !std::isfinite(off->wanted)) continue;
    const std::string unit = off->unit.empty() ? "" : " " + off->unit;
    s.notes.push_back({"/drivers/" + s.drivers[idx(in.driver)], "the law's value at the start and `at` disagree: its " +
                                                                    off->what + " is " + general(off->wanted, 6) +
                                                                    unit + " by the law and " + general(off->has, 6) +
                                                                    unit + " by `at`; the law wins"});
  }
}

}  // namespace

System lower(std::shared_ptr<const Scene> scene, std::span<const std::string> controlled, bool declared_groups) {
  const int exponent = length_exponent(*scene);
  Forms forms(std::move(scene), exponent);
  Shared shared;
  BodyWriter bodies(forms, shared);
  ConstraintWriter constraints(forms, shared);
  DriverWriter drivers(forms, shared, controlled);

  constraints.note_lengths();
  declare_points_and_vectors(forms, shared);
  bodies.declare_members();
  constraints.declare_auxiliaries();
  drivers.declare_auxiliaries();
  if (declared_groups) declare_groups(forms, shared);

  constraints.absorb_distances();
  drivers.declare_inputs();
  drivers.fix_coordinates();

  bodies.write_equations();
  write_norms(forms, shared);
  constraints.write_equations();
  drivers.write_equations();

  declare_measures(forms);
  drivers.note_own_forms();
  set_driven_guess(forms.system());
  for (Item& item : forms.system().items) item.fixed = forms.is_fixed(item);
  forms.give_back();
  return std::move(forms.system());
}

}  // namespace assur
