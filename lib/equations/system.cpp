#include "equations/system.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>

#include "equations/drive.hpp"
#include "equations/residual_scale.hpp"

namespace assur {

bool is_angle(MeasureForms::Kind kind) {
  using enum MeasureForms::Kind;
  switch (kind) {
    case form:
    case distance:
    case sum:
    case quaternion_w:
    case quaternion_x:
    case quaternion_y:
    case quaternion_z:
      return false;
    case absolute_angle:
    case signed_angle:
    case unsigned_angle:
    case sum_of_angles:
    case turn_x:
    case turn_y:
    case turn_z:
      return true;
  }
  return false;
}

std::string unit_of(const MeasureForms& m) {
  if (is_angle(m.kind)) return "rad";
  return m.dimension == 0 ? "1" : m.dimension == 1 ? "m" : "m^" + std::to_string(m.dimension);
}

double System::unit(int power) const { return std::ldexp(1.0, length_exponent * power); }

std::string System::coordinate_name(Index coordinate) const {
  const Coordinate& c = coordinates[static_cast<std::size_t>(coordinate)];
  if (c.item < 0) return "1";
  const std::string& name = items[static_cast<std::size_t>(c.item)].name;
  return c.component < 0 ? name : name + "." + "xyz"[c.component];
}

std::string System::equation_name(Index equation) const {
  const Equation& e = equations[static_cast<std::size_t>(equation)];
  return sources[static_cast<std::size_t>(e.source)].name;
}

namespace {

std::uint32_t hash_of(std::string_view name) { return static_cast<std::uint32_t>(std::hash<std::string_view>{}(name)); }

}  // namespace

void System::index_names() {
  by_name.clear();
  by_name.reserve(items.size());
  for (const Item& item : items) by_name.push_back({hash_of(item.name), static_cast<Index>(by_name.size())});
  std::sort(by_name.begin(), by_name.end(),
            [](const NamedItem& a, const NamedItem& b) { return std::tie(a.hash, a.item) < std::tie(b.hash, b.item); });
}

Index System::find_item(std::string_view name) const {
  const std::uint32_t hash = hash_of(name);
  const auto first = std::lower_bound(by_name.begin(), by_name.end(), hash,
                                      [](const NamedItem& n, std::uint32_t wanted) { return n.hash < wanted; });
  const auto found = std::find_if(first, by_name.end(), [&](const NamedItem& n) {
    return n.hash != hash || items[static_cast<std::size_t>(n.item)].name == name;
  });
  return found == by_name.end() || found->hash != hash ? -1 : found->item;
}

const Item& System::item(std::string_view name) const { return items.at(static_cast<std::size_t>(find_item(name))); }

void System::mentioned(Index equation, std::vector<Index>& out) const {
  out.clear();
  const Equation& e = equations[static_cast<std::size_t>(equation)];
  const auto take = [&](Index f) {
    for (const Term& t : form(f)) {
      if (t.coordinate != kOne) out.push_back(t.coordinate);
    }
  };
  if (e.callback >= 0) {
    for (const Index f : callbacks[static_cast<std::size_t>(e.callback)].coordinates) take(f);
  }
  if (e.linear >= 0) take(e.linear);
  for (const Product& p : products_of(e)) {
    take(p.a);
    take(p.b);
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
}

namespace {

bool is_constant(const System& s, Index form) {
  const auto terms = s.form(form);
  return std::all_of(terms.begin(), terms.end(), [](const Term& t) { return t.coordinate == kOne; });
}

double least_scale(const System& s, Index equation, std::span<const double> q) {
  const Equation& e = s.equations[static_cast<std::size_t>(equation)];
  const auto constant = [&](Index k) { return s.constants[static_cast<std::size_t>(k)]; };
  double sum = 0;
  if (e.callback >= 0) {
    gradient<double>(s, equation, q, [&](Index c, double g) { sum += c != kOne ? kLeastFactor * std::abs(g) : 0; });
    return sum;
  }
  for (const Term& t : e.linear >= 0 ? s.form(e.linear) : std::span<const Term>()) {
    if (t.coordinate != kOne) sum += std::abs(constant(t.constant));
  }
  double a = 0, b = 0;
  for (const Product& p : s.products_of(e)) {
    const bool a_varies = !is_constant(s, p.a), b_varies = !is_constant(s, p.b);
    if (p.a == p.b || !(a_varies || b_varies)) continue;
    const double first = constant(p.constant) * form_value<double>(s, b_varies ? p.a : p.b, q);
    const double second = form_value<double>(s, b_varies ? p.b : p.a, q);
    a += first * first;
    b += second * second;
  }
  a = std::sqrt(a);
  b = std::sqrt(b);
  return sum + a * b + kLeastFactor * (a + b);
}

}  // namespace

double residual_scale(const System& s, Index equation, std::span<const double> q) {
  const double terms = size_of_terms(s, equation, q), least = least_scale(s, equation, q);
  return least > terms && std::isfinite(least) ? least : terms;
}

double size_of_terms(const System& s, Index equation, std::span<const double> q) {
  const Equation& e = s.equations[static_cast<std::size_t>(equation)];
  if (e.callback >= 0) {
    double sum = 0;
    gradient<double>(s, equation, q, [&](Index c, double g) { sum += std::abs(g * q[static_cast<std::size_t>(c)]); });
    return sum;
  }
  const auto magnitude = [&](Index f) {
    double sum = 0;
    for (const Term& t : s.form(f)) {
      sum += std::abs(s.constants[static_cast<std::size_t>(t.constant)] * q[static_cast<std::size_t>(t.coordinate)]);
    }
    return sum;
  };
  double sum = e.linear >= 0 ? magnitude(e.linear) : 0;
  for (const Product& p : s.products_of(e)) {
    const double c = std::abs(s.constants[static_cast<std::size_t>(p.constant)]);
    const double a = std::abs(form_value<double>(s, p.a, q)), b = std::abs(form_value<double>(s, p.b, q));
    // A constant factor has no derivative; a product of constants is a constant.
    const bool a_varies = !is_constant(s, p.a), b_varies = !is_constant(s, p.b);
    sum += c * (a_varies || b_varies ? a_varies * magnitude(p.a) * b + b_varies * a * magnitude(p.b) : a * b);
  }
  return sum;
}

Driven all_driven(const System& s) { return driven_behind(s, std::vector<std::uint8_t>(s.coordinates.size(), 1)); }

Driven driven_behind(const System& s, std::vector<std::uint8_t> needed) {
  Driven out;
  for (auto a = s.assignments.rbegin(); a != s.assignments.rend(); ++a) {
    if (needed[static_cast<std::size_t>(a->coordinate)] == 0) continue;
    out.assignments.push_back(static_cast<Index>(s.assignments.rend() - a) - 1);
    for (const Term& t : s.form(a->form)) needed[static_cast<std::size_t>(t.coordinate)] = 1;
  }
  std::reverse(out.assignments.begin(), out.assignments.end());
  for (std::size_t i = 0; i < s.inputs.size(); ++i) {
    const auto first = needed.begin() + s.inputs[i].first;
    if (std::find(first, first + s.inputs[i].count, 1) != first + s.inputs[i].count) {
      out.inputs.push_back(static_cast<Index>(i));
    }
  }
  return out;
}

Status drive(const System& s, double t, double* q, double* rate, double* acceleration) {
  Status status;
  drive<double>(
      s, all_driven(s),
      [&](std::size_t input, int k) {
        const Law& law = s.inputs[input].laws[static_cast<std::size_t>(k)];
        if (status.ok() && !law.covers(t)) status = {Code::out_of_range, Place::driver(s.inputs[input].driver), t};
        return law(t);
      },
      q, rate, acceleration);
  for (const DriverInput& in : s.inputs) {
    if (status.ok() && in.must_not_vanish && !(q[in.first] > 0)) {
      status = {Code::actuator_zero, Place::driver(in.driver), q[in.first]};
    }
  }
  return status;
}

}  // namespace assur
