#include "equations/lowering.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "decimal.hpp"
#include "equations/drive.hpp"
#include "equations/lowering_parts.hpp"
#include "equations/own_values.hpp"
#include "index.hpp"
#include "scene/axes.hpp"
#include "scene/law_sum.hpp"
#include "scene/names.hpp"

namespace assur {
namespace {

// Median binary exponent of the lengths in the scene. Typical lengths become about 1, and scaling all lengths by 2^k
// moves the median by exactly k.
int length_exponent(const Scene& scene) {
  std::vector<int> exponents;
  const auto see = [&](double length) {
    if (length > 0 && std::isfinite(length)) exponents.push_back(std::ilogb(length));
  };
  std::unordered_map<std::string_view, const Triple*> at;
  for (const Point& p : scene.points()) at.emplace(p.name, &p.at);
  for (const Body& b : scene.bodies()) {
    for (const Member& m : b.points) see(triple::length(m.local).value());
  }
  const auto see_pair = [&](const std::string& a, const std::string& b) {
    const auto i = at.find(a), j = at.find(b);
    if (i != at.end() && j != at.end()) see(triple::length(triple::subtract(*i->second, *j->second)).value());
  };
  for (const Constraint& c : scene.constraints()) {
    if (const auto* d = c.as<Distance>()) {
      if (d->value) {
        see(d->value->value());
      } else {
        see_pair(d->p, d->q);
      }
    }
    if (const auto* l = c.as<OnLine>()) see_pair(l->p, l->a);
  }
  for (const Driver& d : scene.drivers()) {
    if (const auto* a = std::get_if<PointAngle>(&d.kind)) see_pair(a->a, a->b);
    if (const auto* a = std::get_if<DrivenDistance>(&d.kind)) see_pair(a->a, a->b);
  }
  if (exponents.empty()) {
    for (const Point& p : scene.points()) see(triple::length(p.at).value());
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

void write_norms(Forms& forms, const Shared& shared, BodyWriter& bodies) {
  for (const Vector& v : forms.scene().vectors()) {
    const Item& item = forms.item(v.name);
    if (shared.without_norm.count(v.name) != 0) continue;
    if (forms.all_known(item) && bodies.is_constant(v.name, v.name)) continue;
    forms.unit_equation(forms.source("|" + v.name + "| = 1"), item);
  }
}

void append(Forms& forms, MeasureForms& out, const Direction& d) {
  const Forms::Components c = forms.direction(d);
  out.forms.insert(out.forms.end(), c.form, c.form + forms.dimension());
}

void declare(Forms& forms, MeasureForms& out, const AbsoluteAngle& a) {
  out.kind = MeasureForms::Kind::absolute_angle;
  append(forms, out, {a.a, a.b});
}

void declare(Forms& forms, MeasureForms& out, const AngleBetween& b) {
  const bool is_signed = forms.dimension() == 2 || !axis_of(b).empty();
  out.kind = is_signed ? MeasureForms::Kind::signed_angle : MeasureForms::Kind::unsigned_angle;
  append(forms, out, b.d);
  append(forms, out, b.e);
  if (!axis_of(b).empty()) append(forms, out, axis_of(b));
}

void declare(Forms& forms, MeasureForms& out, const MeasuredDistance& d) {
  out.kind = MeasureForms::Kind::distance;
  out.dimension = 1;
  append(forms, out, {d.a, d.b});
}

void declare(Forms& forms, MeasureForms& out, const MeasuredCoordinate& c) {
  out.kind = MeasureForms::Kind::form;
  out.dimension = static_cast<std::int8_t>(forms.scalar_dimension(c.coordinate));
  out.forms.push_back(forms.scalar_form(c.coordinate));
}

void declare(Forms& forms, MeasureForms& out, const Orientation& o) {
  using Kind = MeasureForms::Kind;
  static constexpr Kind kKinds[] = {Kind::absolute_angle, Kind::quaternion_w, Kind::quaternion_x, Kind::quaternion_y,
                                    Kind::quaternion_z,   Kind::turn_x,       Kind::turn_y,       Kind::turn_z};
  out.kind = kKinds[static_cast<std::size_t>(o.part)];
  append(forms, out, o.body + ".ex");
  if (o.part == Orientation::Part::angle) return;
  append(forms, out, o.body + ".ey");
  append(forms, out, o.body + ".ez");
}

void declare(Forms&, MeasureForms&, const Combination&) {}  // declare_sums()

void declare_measures(Forms& forms) {
  for (const Measure& m : forms.scene().measures()) {
    MeasureForms out;
    out.name = m.name;
    std::visit([&](const auto& kind) { declare(forms, out, kind); }, m.kind);
    forms.system().measures.push_back(std::move(out));
  }
}

// Called after all other measures are declared.
void declare_sums(System& s) {
  std::unordered_map<std::string_view, Index> measure;
  for (std::size_t i = 0; i < s.measures.size(); ++i) measure.emplace(s.measures[i].name, static_cast<Index>(i));
  for (std::size_t i = 0; i < s.measures.size(); ++i) {
    const auto* sum = std::get_if<Combination>(&s.scene->measures()[i].kind);
    if (sum == nullptr) continue;
    MeasureForms& out = s.measures[i];
    const MeasureForms& first = s.measures[idx(measure.at(sum->terms.front().first))];
    const std::string unit = unit_of(first);
    for (const auto& [name, factor] : sum->terms) {
      out.terms.push_back({measure.at(name), factor});
      const std::string other = unit_of(s.measures[idx(out.terms.back().measure)]);
      if (other == unit) continue;
      throw Error(Error::Kind::input, {{"/measures/" + out.name + "/sum",
                                        in_quotes(first.name) + " is in " + unit + ", " + in_quotes(name) + " in " +
                                            other + "; all measures of a sum must have the same unit"}});
    }
    out.kind = unit == "rad" ? MeasureForms::Kind::sum_of_angles : MeasureForms::Kind::sum;
    out.dimension = first.dimension;
    out.constant = sum->constant;
  }
}

void declare_limits(System& s) {
  if (s.scene->limits().empty()) return;
  std::unordered_map<std::string_view, Index> measure;
  for (std::size_t i = 0; i < s.measures.size(); ++i) measure.emplace(s.measures[i].name, static_cast<Index>(i));
  for (const Limit& l : s.scene->limits()) {
    Bound bound{measure.at(l.quantity), 0, false, l.reaction == Limit::Reaction::end};
    for (std::size_t i = 0; i < s.inputs.size(); ++i) {
      if (!l.driver.empty() && s.drivers[idx(s.inputs[i].driver)] == l.driver) bound.input = static_cast<Index>(i);
    }
    for (const bool is_max : {false, true}) {
      bound.is_max = is_max;
      bound.value = is_max ? l.max : l.min;
      if (isfinite(bound.value)) s.bounds.push_back(bound);
    }
  }
}

// Adds the value in the posture as written to laws that are relative to it.
void count_from_guess(const System& s, DriverInput& in, std::span<const Number> guess) {
  const std::string where = "/drivers/" + s.drivers[idx(in.driver)];
  if (const std::string why = why_undefined(s, in, guess); !why.empty()) {
    throw Error(Error::Kind::input,
                {{where, "the law is relative to an undefined angle: in the posture as written " + why}});
  }
  const std::vector<Number> from = own_values(s, in, guess);
  for (std::size_t k = 0; k < in.laws.size(); ++k) in.laws[k] = Law::constant(from[k]) + in.laws[k];
  if (s.scene->drivers()[idx(in.driver)].sets_difference) in.zero = from[0];
  const Number start = value_of(in.laws[0], s.scene->time().start);
  if (in.must_not_vanish && start <= 0) {
    throw Error(Error::Kind::input, {{where + "/law", "the distance at the start is " + general(start.value(), 6) +
                                                          " m; a driven distance must stay > 0"}});
  }
}

// Driven coordinates start at the values of their laws. A guess that disagrees is replaced, with a note.
void set_driven_guess(System& s) {
  std::vector<Number> written;
  for (Index c = 0; c < static_cast<Index>(s.guess.size()); ++c) written.push_back(s.guess_of(c));
  std::vector<double> posture = s.guess;  // the posture as written, with the values of the laws
  for (DriverInput& in : s.inputs) {
    if (s.scene->drivers()[idx(in.driver)].relative) count_from_guess(s, in, written);
  }
  (void)drive(s, s.scene->time().start, s.guess.data(), nullptr, nullptr);
  for (DriverInput& in : s.inputs) {
    std::copy_n(s.guess.begin() + in.first, in.count, posture.begin() + in.first);
    in.written = written_values(s, in, written);
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
  write_norms(forms, shared, bodies);
  constraints.write_equations();
  drivers.write_equations();

  declare_measures(forms);
  declare_sums(forms.system());
  declare_limits(forms.system());
  drivers.note_own_forms();
  set_driven_guess(forms.system());
  for (Item& item : forms.system().items) item.fixed = forms.is_fixed(item);
  return forms.finish();
}

}  // namespace assur
