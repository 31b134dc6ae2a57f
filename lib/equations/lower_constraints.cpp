#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <unordered_set>

#include "decimal.hpp"
#include "equations/lowering_parts.hpp"
#include "scene/names.hpp"

namespace assur {
namespace {

using triple::dot;
using triple::subtract;

// lambda of e = lambda d.
Number ratio(const Triple& d, const Triple& e) {
  const Number dd = dot(d, d);
  return dd > 0 ? dot(d, e) / dd : Number(0);
}

}  // namespace

// ---- before the equations

void ConstraintWriter::note_lengths() {
  std::unordered_set<std::string_view> in_bases;
  for (const Body& b : forms_.scene().bodies()) in_bases.insert(b.base.begin(), b.base.end());
  for (const Constraint& c : forms_.scene().constraints()) {
    const auto* d = c.as<Distance>();
    if (d == nullptr || in_bases.count(d->p) == 0 || in_bases.count(d->q) == 0) continue;
    shared_.distances.insert(pair_key(d->p, d->q));
    if (d->value) shared_.lengths[pair_key(d->p, d->q)] = *d->value;
  }
}

void ConstraintWriter::declare_auxiliaries() {
  for (const Constraint& c : forms_.scene().constraints()) {
    c.visit([&](const auto& kind) { declare(c.name, kind); });
  }
}

void ConstraintWriter::declare(const std::string& name, const Parallel& c) {
  const Forms& f = forms_;
  forms_.declare_scalar(name + ".lambda", f.power(c.e) - f.power(c.d), ratio(f.at(c.d), f.at(c.e)));
}

void ConstraintWriter::declare(const std::string& name, const OnLine& c) {
  const Forms& f = forms_;
  forms_.declare_scalar(name + ".lambda", 1 - f.power(c.d), ratio(f.at(c.d), subtract(f.at(c.p), f.at(c.a))));
}

void ConstraintWriter::declare(const std::string& name, const OnPlane& c) {
  const Triple d = forms_.at(c.d), e = forms_.at(c.e), r = subtract(forms_.at(c.p), forms_.at(c.a));
  const Number dd = dot(d, d), de = dot(d, e), ee = dot(e, e), det = dd * ee - de * de;
  const Number lambda = det > 0 ? (dot(d, r) * ee - dot(e, r) * de) / det : Number(0);
  const Number mu = det > 0 ? (dot(e, r) * dd - dot(d, r) * de) / det : Number(0);
  forms_.declare_scalar(name + ".lambda", 1 - forms_.power(c.d), lambda);
  forms_.declare_scalar(name + ".mu", 1 - forms_.power(c.e), mu);
}

void ConstraintWriter::absorb_distances() {
  std::map<Pair, std::string> angle_of;
  std::unordered_set<std::string_view> ends;
  for (const Driver& d : forms_.scene().drivers()) {
    const auto* a = std::get_if<PointAngle>(&d.kind);
    if (a == nullptr) continue;
    angle_of[pair_key(a->a, a->b)] = d.name;
    ends.insert({a->a, a->b});
  }
  for (const Constraint& c : forms_.scene().constraints()) {
    const auto* d = c.as<Distance>();
    if (d == nullptr || ends.count(d->p) == 0 || ends.count(d->q) == 0) continue;
    const auto found = angle_of.find(pair_key(d->p, d->q));
    if (found == angle_of.end()) continue;
    shared_.absorbed.insert(c.name);
    if (d->value) shared_.radius[found->second] = *d->value;
    angle_of.erase(found);  // a second constraint is an equation
  }
}

// ---- equations

void ConstraintWriter::write_equations() {
  for (const Constraint& c : forms_.scene().constraints()) {
    if (shared_.absorbed.count(c.name) != 0) continue;
    c.visit([&](const auto& kind) { write(c.name, kind); });
  }
}

void ConstraintWriter::write(const std::string& name, const Distance& c) {
  const Number written = triple::length(subtract(forms_.at(c.p), forms_.at(c.q)));
  const Number length = c.value ? *c.value : written;
  // Only a note depends on this comparison.
  if (std::abs(length.value() - written.value()) > kDisagree * length.value()) {
    note_new_shape(name, c, written.value());
  }
  forms_.distance_equation(forms_.source(name), forms_.item(c.p), forms_.item(c.q), length);
}

// A distance between two points of one base gives the body another shape than the posture as written.
void ConstraintWriter::note_new_shape(const std::string& name, const Distance& c, double written) {
  for (const Body& b : forms_.scene().bodies()) {
    const auto has = [&](const std::string& point) {
      return std::find(b.base.begin(), b.base.end(), point) != b.base.end();
    };
    const bool has_shape = b.base.size() > 2 || !b.points.empty() || !b.vectors.empty();
    if (!has_shape || !has(c.p) || !has(c.q)) continue;
    forms_.system().notes.push_back(
        {"/constraints/" + name, "the distance and `at` disagree: " + in_quotes(c.p) + " and " + in_quotes(c.q) +
                                     " of body " + in_quotes(b.name) + " are " + general(written, 6) +
                                     " m apart by `at` and " + general(c.value->value(), 6) +
                                     " m by the constraint; the constraint wins, and the body has another shape"});
    return;
  }
}

void ConstraintWriter::write(const std::string& name, const EqualDistance& c) {
  std::vector<Product> products;
  forms_.add_square(products, forms_.item(c.p), forms_.item(c.q), kPlus);
  forms_.add_square(products, forms_.item(c.r), forms_.item(c.s), kMinus);
  forms_.equation(forms_.source(name), products, {});
}

void ConstraintWriter::write(const std::string& name, const Dot& c) {
  const Forms::Components d = forms_.direction(c.d), e = forms_.direction(c.e);
  std::vector<Product> products;
  forms_.add_dot(products, d.form, e.form);
  const Number value = c.value ? *c.value : dot(forms_.at(c.d), forms_.at(c.e));
  const Index known = forms_.constant(-value, d.power + e.power);
  forms_.equation(forms_.source(name), products, {{kOne, known}});
}

// e - lambda d = 0
void ConstraintWriter::write(const std::string& name, const Parallel& c) {
  const Forms::Components d = forms_.direction(c.d), e = forms_.direction(c.e);
  const Index lambda = forms_.item(name + ".lambda").form[0];
  const Index from = forms_.source(name);
  for (int k = 0; k < forms_.dimension(); ++k) {
    Terms linear;
    forms_.append(linear, e.form[k], kPlus);
    forms_.equation(from, {{lambda, d.form[k], kMinus}}, linear);
  }
}

// P - A - lambda d = 0
void ConstraintWriter::write(const std::string& name, const OnLine& c) {
  const Forms::Components d = forms_.direction(c.d);
  const Item &p = forms_.item(c.p), &a = forms_.item(c.a);
  const Index lambda = forms_.item(name + ".lambda").form[0];
  const Index from = forms_.source(name);
  for (int k = 0; k < forms_.dimension(); ++k) {
    Terms linear;
    forms_.append(linear, p.form[k], kPlus);
    forms_.append(linear, a.form[k], kMinus);
    forms_.equation(from, {{lambda, d.form[k], kMinus}}, linear);
  }
}

// P - A - lambda d - mu e = 0
void ConstraintWriter::write(const std::string& name, const OnPlane& c) {
  const Forms::Components d = forms_.direction(c.d), e = forms_.direction(c.e);
  const Item &p = forms_.item(c.p), &a = forms_.item(c.a);
  const Index lambda = forms_.item(name + ".lambda").form[0], mu = forms_.item(name + ".mu").form[0];
  const Index from = forms_.source(name);
  for (int k = 0; k < forms_.dimension(); ++k) {
    Terms linear;
    forms_.append(linear, p.form[k], kPlus);
    forms_.append(linear, a.form[k], kMinus);
    forms_.equation(from, {{lambda, d.form[k], kMinus}, {mu, e.form[k], kMinus}}, linear);
  }
}

void ConstraintWriter::write(const std::string& name, const Linear& c) {
  const auto is_point = [&](const auto& term) { return forms_.item(term.first).dimension == 1; };
  const bool points = std::any_of(c.terms.begin(), c.terms.end(), is_point);
  const Index from = forms_.source(name);
  std::vector<Index> factor;
  for (const auto& term : c.terms) factor.push_back(forms_.constant(term.second, points && !is_point(term) ? 1 : 0));
  for (int k = 0; k < forms_.dimension(); ++k) {
    Terms linear;
    for (std::size_t i = 0; i < c.terms.size(); ++i) {
      forms_.append(linear, forms_.item(c.terms[i].first).form[k], factor[i]);
    }
    // A zero is kept, so that the pattern does not depend on values.
    forms_.append(linear, forms_.constant_form(-c.value[static_cast<std::size_t>(k)], points), kPlus);
    forms_.equation(from, {}, linear);
  }
}

void ConstraintWriter::write(const std::string& name, const FixedCoordinate& c) {
  Terms linear;
  forms_.append(linear, forms_.scalar_form(c.coordinate), kPlus);
  forms_.append(linear, forms_.constant_form(-c.value, forms_.scalar_dimension(c.coordinate)), kPlus);
  forms_.equation(forms_.source(name), {}, linear);
}

void ConstraintWriter::write(const std::string& name, const Callback& c) {
  System& s = forms_.system();
  CallbackBlock block;
  block.callback = &c;
  for (const std::string& coordinate : c.coordinates) {
    block.coordinates.push_back(forms_.scalar_form(coordinate));
    block.unit.push_back(s.unit(forms_.scalar_dimension(coordinate)));
  }
  block.first_equation = static_cast<Index>(s.equations.size());
  const Index from = forms_.source(name);
  for (Index row = 0; row < c.equations; ++row) {
    forms_.callback_row(from, static_cast<Index>(s.callbacks.size()), row);
  }
  s.callbacks.push_back(std::move(block));
  s.teeth = std::max(s.teeth, c.teeth);
}

}  // namespace assur
