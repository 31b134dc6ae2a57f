#include <cmath>
#include <unordered_set>

#include "builder/validation_vocabulary.hpp"
#include "scene/triple.hpp"

namespace assur {
namespace {

constexpr const char* kAllFixed =
    "everything here is fixed, so it cannot constrain anything; remove it or let something move";

}  // namespace

void Validation::check_constraints() {
  for (const Constraint& constraint : scene_.constraints()) {
    const Where where = Where("/constraints") / constraint.name;
    if (known_.at_or_above(where.text())) continue;
    is_made_ = symbols_.is_made(constraint.name);
    constraint.visit([&](const auto& kind) { check(kind, where); });
  }
  is_made_ = false;
}

template <class Kind>
void Validation::check(const Kind& kind, const Where& where) {
  constexpr const auto& row = vocabulary::row_of<Kind>();
  const Where own = where / row.name();
  if (dimension() == 2 && !row.not_in_the_plane.empty()) {
    report(own, std::string(row.not_in_the_plane));
  } else if (check_row(kind, where)) {
    if (all_fixed() && !is_made_) report(own, kAllFixed);
    rule(kind, where);
  }
}

void Validation::rule(const Distance& c, const Where& where) {
  const Involved &p = involved_[0], &q = involved_[1];
  if (c.value) {
    if (!isfinite(*c.value)) return;
    if (*c.value == 0)
      report(where / "value", "a distance must be > 0; for two points at one place use a single point");
    if (*c.value < 0) report(where / "value", "a distance must be > 0, not " + shortest(c.value->value()) + " m");
  } else if (p.usable && q.usable && !known_.at_or_below((where / "value").text()) &&
             triple::norm(triple::subtract(p.at, q.at)) == 0) {
    report(where / "distance", p.text() + " and " + q.text() +
                                   " are at the same place, so the omitted value is 0; give a value, or use a "
                                   "single point");
  }
}

void Validation::rule(const EqualDistance& c, const Where& where) {
  const bool same = (c.p == c.r && c.q == c.s) || (c.p == c.s && c.q == c.r);
  if (!same || !involved_[0].usable || !involved_[1].usable) return;
  report(where / "equal_distance", "both pairs are the same; the equation is always true");
}

void Validation::rule(const Dot& c, const Where& where) {
  const Involved &d = involved_[0], &e = involved_[1];
  if (d.usable && d.is(e)) {
    report(where / "dot", "a dot product of " + d.text() +
                              (c.d.is_pair() ? " with itself is a distance; write \"distance\""
                                             : " with itself is its length, 1 for a unit vector; remove it"));
    return;
  }
  if (!c.value || c.d.is_pair() || c.e.is_pair() || !isfinite(*c.value) || abs(*c.value) <= 1) return;
  report(where / "value",
         "the dot product of two unit vectors is a cosine, within -1 and 1, not " + shortest(c.value->value()));
}

void Validation::rule(const Linear& c, const Where& where) {
  const Where list = where / "linear";
  if (c.terms.empty()) report(list, "a linear constraint needs at least one [name, factor]");
  std::unordered_set<std::string_view> seen;
  for (std::size_t i = 0; i < c.terms.size(); ++i) {
    const auto& [name, factor] = c.terms[i];
    if (!seen.insert(name).second && involved_[i].usable) {
      report(list / i / std::size_t{0}, in_quotes(name) + " is in this sum already; add the factors");
    }
    if (factor == 0) {
      report(list / i / std::size_t{1}, "the factor 0 leaves " + in_quotes(name) + " out; remove the term");
    }
  }
  if (dimension() == 2 && isfinite(c.value[2]) && c.value[2] != 0) {
    report(where / "value" / std::size_t{2}, "a plane scene has no z; write 0 or leave it out");
  }
}

void Validation::check(const Callback& c, const Where& where) {
  const Where place = where / "callback";
  if (c.equations < 1) report(place, "a callback gives at least one equation, not " + std::to_string(c.equations));
  if (!c.residual || !c.jacobian || !c.curvature) {
    report(place, "a callback needs all three functions: residual, jacobian and curvature");
  }
  if (c.teeth < 1) report(place, "a callback has at least one tooth, not " + std::to_string(c.teeth));
  if (!(c.tolerance >= 0)) {
    report(place, "the tolerance of a callback is a relative error such as 1e-5, not " + std::to_string(c.tolerance));
  }
  bool any_moves = c.coordinates.empty();
  for (std::size_t i = 0; i < c.coordinates.size(); ++i) {
    const Where here = place / "coordinates" / i;
    const Symbol* symbol = symbols_.find(c.coordinates[i]);
    if (symbol == nullptr || symbol->kind != NameKind::driver) {
      const Involved coordinate = scalar(c.coordinates[i], here);
      any_moves = any_moves || !coordinate.usable || !coordinate.fixed;
    } else if (const Driver& driver = scene_.drivers()[symbol->index];
               !std::holds_alternative<DrivenDistance>(driver.kind) &&
               !std::holds_alternative<DrivenCoordinate>(driver.kind)) {
      report(here, in_quotes(driver.name) + " gives no single number; only distance and coordinate drivers do");
    }
  }
  if (c.coordinates.empty()) report(place, "a callback needs the names of the coordinates that it constrains");
  if (!any_moves) report(place, kAllFixed);
}

}  // namespace assur
