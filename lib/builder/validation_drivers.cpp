#include <algorithm>
#include <cmath>
#include <utility>

#include "builder/validation_vocabulary.hpp"
#include "scene/axes.hpp"
#include "scene/law_sum.hpp"
#include "scene/triple.hpp"

namespace assur {
namespace {

std::string pair_key(const std::string& a, const std::string& b) { return a < b ? a + " " + b : b + " " + a; }
std::string key(const Direction& d) { return d.is_pair() ? pair_key(d.first, d.second) : d.first; }

// Checks the numbers of a law. Functions are not called, because they may belong to a running program.
struct IsFinite {
  bool operator()(const Law::Polynomial& p) const {
    return std::all_of(p.coefficients.begin(), p.coefficients.end(), [](const Number& c) { return isfinite(c); });
  }
  bool operator()(const Law::Harmonics& h) const {
    return isfinite(h.offset) && std::all_of(h.terms.begin(), h.terms.end(), [](const Harmonic& term) {
             return isfinite(term.amplitude) && isfinite(term.frequency) && isfinite(term.phase);
           });
  }
  bool operator()(const Law::Spline&) const { return true; }  // Law::table has checked it
  bool operator()(const Law::Function&) const { return true; }
};

bool calls_program(const Law& law) {
  return std::any_of(law.parts().begin(), law.parts().end(),
                     [](const Law::Part& part) { return std::holds_alternative<Law::Function>(part); });
}

}  // namespace

void Validation::check_drivers() {
  for (const Driver& driver : scene_.drivers()) {
    const Where where = Where("/drivers") / driver.name;
    if (known_.at_or_above(where.text())) continue;
    std::visit(
        [&]<class Kind>(const Kind& kind) {
          if (!check_row(kind, where)) return;
          if (all_fixed()) {
            report(where / vocabulary::row_of<Kind>().name(),
                   "everything here is fixed, so nothing can be driven; drive something that moves");
          }
          rule(kind, driver, where);
        },
        driver.kind);
  }
}

void Validation::check_law(const Law& law, const Where& where) {
  if (!std::all_of(law.parts().begin(), law.parts().end(),
                   [](const auto& part) { return std::visit(IsFinite{}, part); })) {
    report(where, "the law has a number that is not finite");
    return;
  }
  const TimeGrid& time = scene_.time();
  const bool grid_is_fine = std::isfinite(time.start) && std::isfinite(time.end) && time.end >= time.start;
  if (!grid_is_fine || known_.at_or_below("/time")) return;
  if (law.covers(time.start) && law.covers(time.end)) return;
  for (const Law::Part& part : law.parts()) {
    const auto* table = std::get_if<Law::Spline>(&part);
    if (table == nullptr || table->periodic) continue;
    report(where, "its table goes from t = " + shortest(table->time.front()) + " s to " + shortest(table->time.back()) +
                      " s, the time grid from " + shortest(time.start) + " s to " + shortest(time.end) + " s" +
                      "; the table must cover the grid or be periodic");
    return;
  }
}

std::pair<Validation::Kept::const_iterator, Validation::Kept::const_iterator> Validation::kept_distances(
    const std::string& a, const std::string& b) {
  if (!kept_) {
    kept_.emplace();
    for (const Constraint& c : scene_.constraints()) {
      if (const auto* d = c.as<Distance>()) kept_->emplace(pair_key(d->p, d->q), &c);
    }
  }
  return std::as_const(*kept_).equal_range(pair_key(a, b));
}

const DrivenDistance* Validation::driven_distance(const std::string& a, const std::string& b) const {
  for (const Driver& driver : scene_.drivers()) {
    const auto* d = std::get_if<DrivenDistance>(&driver.kind);
    if (d != nullptr && pair_key(d->a, d->b) == pair_key(a, b)) return d;
  }
  return nullptr;
}

void Validation::claim(const std::string& what, const Driver& driver, const Where& where) {
  const auto [found, is_new] = claimed_.emplace(what, driver.name);
  const bool told = !found_.empty() && found_.back().where == where.text();
  if (is_new || found->second == driver.name || told) return;
  report(where, in_quotes(found->second) + " drives the same quantity already; use one driver for each motion");
}

void Validation::claim_point(const std::string& name, const Driver& driver, const Where& where) {
  for (int k = 0; k < dimension(); ++k) claim(name + "." + "xyz"[k], driver, where);
}

void Validation::rule(const PointAngle& d, const Driver& driver, const Where& where) {
  const Where pair = where / "angle";
  const Involved a = involved_[0], b = involved_[1];
  check_arm(d, a, b, where);
  if (!a.usable || !b.usable || (a.fixed && b.fixed)) return;
  if (a.fixed) {
    claim_point(d.b, driver, pair);
  } else if (b.fixed) {
    claim_point(d.a, driver, pair);
  } else {
    claim("angle " + pair_key(d.a, d.b), driver, pair);
  }
}

// Checks the axis, and that the arm is not parallel to it.
void Validation::check_arm(const PointAngle& d, const Involved& a, const Involved& b, const Where& where) {
  const Triple arm = triple::subtract(b.at, a.at);
  const bool placed = a.usable && b.usable && triple::is_finite(arm);
  if (dimension() == 2) {
    if (!axis_of(d).empty()) report(where / "axis", "in the plane every axis is the normal; leave \"axis\" out");
    const auto gives_radius = [](const auto& kept) { return kept.second->template as<Distance>()->value.has_value(); };
    const auto [kept, end] = kept_distances(d.a, d.b);
    if (placed && triple::norm(arm) == 0 && std::none_of(kept, end, gives_radius) &&
        driven_distance(d.a, d.b) == nullptr) {
      report(where / "angle", in_quotes(d.a) + " and " + in_quotes(d.b) +
                                  " are at the same place, so the radius is 0; give a distance or different positions");
    }
    return;
  }
  if (axis_of(d).empty()) {
    report(where, "an angle in 3D needs an \"axis\", [x, y, z] or the name of a vector");
    return;
  }
  const Involved axis = vector(axis_of(d), where / "axis");
  if (!axis.usable) return;
  if (!axis.fixed) {
    report(where / "axis", in_quotes(axis_of(d)) +
                               " moves; about a moving axis use the relative form, the angle from one direction to " +
                               "another: \"angle\": [[\"A\", \"B\"], [\"C\", \"D\"]]");
  } else if (placed &&
             !(triple::norm(triple::cross(axis.at, arm)) > 1e-9 * triple::norm(arm) * triple::norm(axis.at))) {
    report(where / "angle", "the direction from " + in_quotes(d.a) + " to " + in_quotes(d.b) +
                                " is parallel to the axis, so it has no angle about it; choose another axis or other "
                                "positions");
  } else if (placed) {
    // The distance is the arm's length; its component along the axis is that of the posture as written.
    const Number along = abs(triple::dot(axis.at, arm)) / triple::norm(axis.at);
    for (auto [kept, end] = kept_distances(d.a, d.b); kept != end; ++kept) {
      const Constraint& c = *kept->second;
      const auto* distance = c.as<Distance>();
      if (!distance->value || *distance->value > along) continue;
      report(where / "angle", "the distance " + in_quotes(c.name) + " of " + shortest(distance->value->value()) + " m" +
                                  " is too short: along the axis " + in_quotes(d.b) + " is " + shortest(along.value()) +
                                  " m from " + in_quotes(d.a) + "; move it or choose a longer distance");
    }
  }
}

void Validation::rule(const RelativeAngle& d, const Driver& driver, const Where& where) {
  const Involved from = involved_[0], to = involved_[1];
  if (dimension() == 2) {
    if (!axis_of(d).empty()) report(where / "axis", "in the plane every axis is the normal; leave \"axis\" out");
  } else if (axis_of(d).empty()) {
    report(where, "an angle in 3D needs an \"axis\", [x, y, z] or the name of a vector");
  } else {
    check_axis(axis_of(d), {{d.d, from}, {d.e, to}}, where / "axis");
  }
  claim("angle from " + std::min(key(d.d), key(d.e)) + " to " + std::max(key(d.d), key(d.e)), driver, where / "angle");
}

void Validation::rule(const DrivenDistance& d, const Driver& driver, const Where& where) {
  claim("distance " + pair_key(d.a, d.b), driver, where / "distance");
  if (const auto [kept, end] = kept_distances(d.a, d.b); kept != end) {
    report(where / "distance",
           "constraint " + in_quotes(kept->second->name) + " keeps this distance constant; remove one of them");
  }
  if (calls_program(d.law) || driver.relative) return;
  const Number start = value_of(d.law, scene_.time().start);
  if (start <= 0) {  // NaN, outside a table, is reported above
    report(where / "law",
           "the distance at the start is " + shortest(start.value()) + " m; a driven distance must stay > 0");
  }
}

void Validation::rule(const DrivenCoordinate& d, const Driver& driver, const Where& where) {
  if (involved_[0].usable) claim(d.coordinate, driver, where / "coordinate");
}

void Validation::rule(const Pose& d, const Driver& driver, const Where& where) {
  if (static_cast<int>(d.translation.size()) != dimension()) {
    report(where / "translation", "a pose in " + std::to_string(dimension()) + "D has " + std::to_string(dimension()) +
                                      " translations, not " + std::to_string(d.translation.size()));
  }
  if (!involved_[0].usable) return;
  const Body& body = scene_.bodies()[symbols_.find(d.body)->index];
  if (body.name == "ground") {
    report(where / "pose", "the ground does not move; name another body");
    return;
  }
  const bool turns = !body.frame.empty() || !body.base.empty();
  const std::size_t wanted = !turns ? 0 : dimension() == 3 ? 3 : 1;
  if (d.rotation.size() != wanted) {
    report(where / "rotation",
           wanted == 0   ? in_quotes(body.name) + " has an origin alone and only translates; leave \"rotation\" out"
           : wanted == 1 ? "a pose in 2D has one rotation, {\"angle\": law}"
                         : "a pose in 3D has three rotations, {\"euler_zyx\": [psi, theta, phi]}");
  }
  if (!body.origin.empty()) claim_point(body.origin, driver, where / "pose");
  for (const std::string& name : body.frame) claim_point(name, driver, where / "pose");
  for (const std::string& name : body.base) claim_point(name, driver, where / "pose");
}

}  // namespace assur
