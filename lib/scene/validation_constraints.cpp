#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "scene/triple.hpp"
#include "scene/validation.hpp"

namespace assur {
namespace {

bool same(const Direction& d, const Direction& e) {
  if (d.is_pair() != e.is_pair()) return false;
  return (d.first == e.first && d.second == e.second) || (d.is_pair() && d.first == e.second && d.second == e.first);
}

std::string text(const Direction& d) {
  return d.is_pair() ? "[" + d.first + ", " + d.second + "]" : in_quotes(d.first);
}

}  // namespace

void Validation::check_constraints() {
  for (const Constraint& constraint : scene_.constraints()) {
    const Where where = Where("/constraints") / constraint.name;
    if (known_.at_or_above(where.text())) continue;
    constraint.visit([&](const auto& kind) { check(kind, where); });
  }
}

void Validation::check_moves(std::initializer_list<Involved> involved, const Where& where) {
  const bool all_fixed =
      std::all_of(involved.begin(), involved.end(), [](const Involved& i) { return i.usable && i.fixed; });
  if (all_fixed)
    report(where, "everything here is fixed, so it cannot constrain anything; remove it or let something move");
}

void Validation::check(const Distance& c, const Where& where) {
  const Where pair = where / "distance";
  const Involved p = point(c.p, pair / std::size_t{0}), q = point(c.q, pair / std::size_t{1});
  if (c.p == c.q && p.usable) {
    report(pair, "a distance from " + in_quotes(c.p) + " to itself; two different points are wanted");
    return;
  }
  check_moves({p, q}, pair);
  if (c.value) {
    if (!finite(*c.value, where / "value")) return;
    if (*c.value == 0) report(where / "value", "a distance must be > 0; for 0 share the point");
    if (*c.value < 0) report(where / "value", "a distance must be > 0, not " + shortest(*c.value) + " m");
  } else if (p.usable && q.usable && !known_.at_or_below((where / "value").text()) &&
             triple::norm(triple::subtract(p.at, q.at)) == 0) {
    report(pair, in_quotes(c.p) + " and " + in_quotes(c.q) +
                     " are at the same place, so the value left out is 0; give a value, or share the point");
  }
}

void Validation::check(const EqualDistance& c, const Where& where) {
  const Where pairs = where / "equal_distance";
  const Where first = pairs / std::size_t{0}, second = pairs / std::size_t{1};
  const Involved p = point(c.p, first / std::size_t{0}), q = point(c.q, first / std::size_t{1});
  const Involved r = point(c.r, second / std::size_t{0}), s = point(c.s, second / std::size_t{1});
  if (c.p == c.q && p.usable)
    report(first, "a distance from " + in_quotes(c.p) + " to itself; two different points are wanted");
  if (c.r == c.s && r.usable)
    report(second, "a distance from " + in_quotes(c.r) + " to itself; two different points are wanted");
  if (c.p != c.q && same({c.p, c.q}, {c.r, c.s}) && p.usable && q.usable) {
    report(pairs, "both pairs are the same; the equation is always true");
    return;
  }
  check_moves({p, q, r, s}, pairs);
}

void Validation::check(const Dot& c, const Where& where) {
  const Where pair = where / "dot";
  const Involved d = direction(c.d, pair / std::size_t{0}), e = direction(c.e, pair / std::size_t{1});
  if (d.usable && same(c.d, c.e)) {
    report(pair, c.d.is_pair()
                     ? "a dot product of " + text(c.d) + " with itself is a distance; write \"distance\""
                     : "a dot product of " + text(c.d) + " with itself is its length, 1 for a unit vector; remove it");
    return;
  }
  check_moves({d, e}, pair);
  if (!c.value || !finite(*c.value, where / "value") || c.d.is_pair() || c.e.is_pair()) return;
  if (std::abs(*c.value) > 1) {
    report(where / "value",
           "the dot product of two unit vectors is a cosine, within -1 and 1, not " + shortest(*c.value));
  }
}

void Validation::check(const Parallel& c, const Where& where) {
  const Where pair = where / "parallel";
  const Involved d = direction(c.d, pair / std::size_t{0}), e = direction(c.e, pair / std::size_t{1});
  if (d.usable && same(c.d, c.e)) {
    report(pair, text(c.d) + " is always parallel to itself; two different directions are wanted");
    return;
  }
  check_moves({d, e}, pair);
}

void Validation::check(const Linear& c, const Where& where) {
  const Where list = where / "linear";
  if (c.terms.empty()) report(list, "a linear constraint needs at least one [name, factor]");
  std::unordered_set<std::string> seen;
  bool all_fixed = !c.terms.empty();
  for (std::size_t i = 0; i < c.terms.size(); ++i) {
    const auto& [name, factor] = c.terms[i];
    const Involved term = point_or_vector(name, list / i / std::size_t{0});
    all_fixed = all_fixed && term.usable && term.fixed;
    if (!seen.insert(name).second && term.usable) {
      report(list / i / std::size_t{0}, in_quotes(name) + " is in this sum already; add the factors");
    }
    if (finite(factor, list / i / std::size_t{1}) && factor == 0) {
      report(list / i / std::size_t{1}, "the factor 0 leaves " + in_quotes(name) + " out; remove the term");
    }
  }
  if (all_fixed) check_moves({{true, true, {}}}, list);
  for (std::size_t k = 0; k < 3; ++k) {
    if (!finite(c.value[k], where / "value" / k)) return;
  }
  if (dimension() == 2 && c.value[2] != 0) {
    report(where / "value" / std::size_t{2}, "a plane scene has no z; write 0 or leave it out");
  }
}

void Validation::check(const FixedCoordinate& c, const Where& where) {
  const Scalar coordinate = scalar(c.coordinate, where / "coordinate");
  (void)finite(c.value, where / "value");
  check_moves({{coordinate.usable, coordinate.fixed, {}}}, where / "coordinate");
}

void Validation::check(const OnLine& c, const Where& where) {
  const Where list = where / "on_line";
  const Involved p = point(c.p, list / std::size_t{0}), a = point(c.a, list / std::size_t{1});
  const Involved d = direction(c.d, list / std::size_t{2});
  if (c.p == c.a && p.usable) {
    report(list, in_quotes(c.p) + " is always on a line through itself; two different points are wanted");
    return;
  }
  check_moves({p, a, d}, list);
}

void Validation::check(const OnPlane& c, const Where& where) {
  const Where list = where / "on_plane";
  if (dimension() == 2) {
    report(list, "on_plane is for 3D; in the plane every point is on it");
    return;
  }
  const Involved p = point(c.p, list / std::size_t{0}), a = point(c.a, list / std::size_t{1});
  const Involved d = direction(c.d, list / std::size_t{2}), e = direction(c.e, list / std::size_t{3});
  if (c.p == c.a && p.usable) {
    report(list, in_quotes(c.p) + " is always on a plane through itself; two different points are wanted");
    return;
  }
  if (d.usable && same(c.d, c.e)) {
    report(list, text(c.d) + " and " + text(c.e) + " are one direction; a plane needs two");
    return;
  }
  check_moves({p, a, d, e}, list);
}

void Validation::check(const Callback& c, const Where& where) {
  const Where place = where / "callback";
  if (c.equations < 1) report(place, "a callback gives at least one equation, not " + std::to_string(c.equations));
  if (!c.residual || !c.jacobian || !c.curvature) {
    report(place, "a callback needs all three functions: residual, jacobian and curvature");
  }
  if (!(c.tolerance >= 0)) {
    report(place, "the tolerance of a callback is a relative error such as 1e-5, not " + std::to_string(c.tolerance));
  }
  bool any_moves = c.coordinates.empty();
  for (std::size_t i = 0; i < c.coordinates.size(); ++i) {
    const Where here = place / "coordinates" / i;
    const Symbol* symbol = symbols_.find(c.coordinates[i]);
    if (symbol == nullptr || symbol->kind != NameKind::driver) {
      const Scalar coordinate = scalar(c.coordinates[i], here);
      any_moves = any_moves || !coordinate.usable || !coordinate.fixed;
    } else if (const Driver& driver = scene_.drivers()[symbol->index];
               !std::holds_alternative<DrivenDistance>(driver.kind) &&
               !std::holds_alternative<DrivenCoordinate>(driver.kind)) {
      report(here, in_quotes(driver.name) + " gives no single number; only distance and coordinate drivers do");
    }
  }
  if (c.coordinates.empty()) report(place, "a callback needs the names of the coordinates that it constrains");
  if (!any_moves) check_moves({{true, true, {}}}, place);
}

}  // namespace assur
