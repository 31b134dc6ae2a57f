#include <algorithm>
#include <cmath>

#include "assur/number.hpp"
#include "builder/validation_vocabulary.hpp"
#include "joints/joints.hpp"
#include "scene/asked_part.hpp"
#include "scene/axes.hpp"

namespace assur {
namespace {

constexpr std::string_view kEverything = "all";

}  // namespace

// ---- measures

void Validation::check_measures() {
  for (const Measure& measure : scene_.measures()) {
    const Where where = Where("/measures") / measure.name;
    if (known_.at_or_above(where.text())) continue;
    std::visit(
        [&](const auto& kind) {
          if (check_row(kind, where)) rule(kind, where);
        },
        measure.kind);
  }
}

void Validation::rule(const AbsoluteAngle& m, const Where& where) {
  (void)pair(involved_[0], involved_[1], {m.a, m.b}, where / "angle");
  if (dimension() == 2) return;
  report(where / "angle",
         "an absolute angle is for the plane; in 3D write two directions, [[\"A\", \"B\"], [\"C\", \"D\"]]");
}

// Reversed pairs differ: from AB to BA the angle is half a turn.
void Validation::rule(const AngleBetween& m, const Where& where) {
  if (m.d.first == m.e.first && m.d.second == m.e.second) {
    report(where / "angle", "an angle from a direction to itself; two different directions are wanted");
  }
  if (axis_of(m).empty()) return;
  if (dimension() == 2) {
    report(where / "axis", "in the plane every axis is the normal; leave \"axis\" out");
  } else {
    const Involved from = involved_[0], to = involved_[1];
    check_axis(axis_of(m), {{m.d, from}, {m.e, to}}, where / "axis");
  }
}

// Units are compared when the scene is lowered, because they are known then.
void Validation::rule(const Combination& m, const Where& where) {
  const Where sum = where / "sum";
  if (m.terms.empty()) report(sum, "a sum needs at least one measure");
  for (std::size_t i = 0; i < m.terms.size(); ++i) {
    const auto& [name, factor] = m.terms[i];
    if (factor == 0) report(sum / i / std::size_t{1}, "the factor is 0; a finite number other than 0 is wanted");
    if (!involved_[i].usable) continue;
    const auto& term = scene_.measures()[symbols_.find(name)->index].kind;
    if (std::holds_alternative<Orientation>(term)) {
      report(sum / i / std::size_t{0},
             in_quotes(name) + " is a part of the pose of a body; a sum takes other measures");
    }
    if (std::holds_alternative<Combination>(term)) {
      report(sum / i / std::size_t{0}, in_quotes(name) + " is a sum itself; name the measures that it is made of");
    }
  }
}

// ---- limits

void Validation::check_limits() {
  std::unordered_map<std::string_view, std::size_t> seen;
  for (const Limit& limit : scene_.limits()) {
    const Where where = Where("/limits") / limit.quantity;
    if (known_.at_or_above(where.text())) continue;
    if (!seen.emplace(limit.quantity, 0).second)
      report(where, "there is a limit of it already; give both bounds in one");
    check_limit(limit, where);
  }
}

void Validation::check_limit(const Limit& limit, const Where& where) {
  if (std::isnan(limit.min.value()) || std::isnan(limit.max.value())) {
    report(where / (std::isnan(limit.min.value()) ? "min" : "max"), "the value is nan; a number is wanted");
  } else if (std::isinf(limit.min.value()) && std::isinf(limit.max.value())) {
    report(where, "a limit needs \"min\", \"max\" or both");
  } else if (!(limit.min < limit.max)) {
    report(where, "the smallest value, " + shortest(limit.min.value()) + ", is not below the largest one, " +
                      shortest(limit.max.value()));
  }
  const Symbol* const symbol = symbols_.find(limit.quantity);
  if (symbol == nullptr) {
    const auto is_coordinate = [&](const Joint& j) {  // an error of the joints, reported there, has hidden it
      return limit.quantity == j.name + ".angle" || limit.quantity == j.name + ".displacement";
    };
    if (known_.hides_names() || std::any_of(scene_.joints().begin(), scene_.joints().end(), is_coordinate)) return;
    report(where, in_quotes(limit.quantity) +
                      " is no measure and no coordinate of a joint (JOINT.angle or "
                      "JOINT.displacement)" +
                      suggestion(limit.quantity, symbols_.names({NameKind::measure})));
  } else if (symbol->kind != NameKind::measure && !symbol->broken) {
    report(where, in_quotes(limit.quantity) + " is " + std::string(with_article(symbol->kind)) +
                      "; a limit is that of a measure or of a coordinate of a joint");
  } else if (!symbol->broken && std::holds_alternative<Orientation>(scene_.measures()[symbol->index].kind)) {
    report(where, in_quotes(limit.quantity) + " is a part of the pose of a body; measure an angle for the limit");
  }
}

// ---- declared groups

void Validation::check_groups() {
  std::unordered_map<std::string, std::string> group_of;
  for (const DeclaredGroup& group : scene_.groups()) {
    const Where where = Where("/groups") / group.name;
    if (known_.at_or_above(where.text())) continue;
    if (group.unknowns.empty())
      report(where / "unknowns", "a group needs at least one unknown; list some, or remove it");
    for (std::size_t i = 0; i < group.unknowns.size(); ++i) {
      const Where here = where / "unknowns" / i;
      check_unknown(group.unknowns[i], here);
      const auto [found, is_new] = group_of.emplace(group.unknowns[i], group.name);
      if (!is_new) {
        report(here, in_quotes(group.unknowns[i]) + " is in group " + in_quotes(found->second) +
                         " already; groups do not overlap");
      }
    }
  }
}

void Validation::check_unknown(const std::string& name, const Where& where) {
  if (name.find('.') != std::string::npos) {
    const std::string owner = name.substr(0, name.rfind('.'));
    const Symbol* symbol = symbols_.find(owner);
    if (symbol != nullptr && (symbol->kind == NameKind::point || symbol->kind == NameKind::vector)) {
      report(where, "a group takes points and vectors as a whole; write " + in_quotes(owner));
    } else {
      (void)scalar(name, where);
    }
    return;
  }
  if (!point_or_vector(name, where).usable) return;
  const Symbol* symbol = symbols_.find(name);
  if (symbol->is_derived()) {
    report(where, in_quotes(name) + " is a member of body " +
                      in_quotes(scene_.bodies()[static_cast<std::size_t>(symbol->body)].name) +
                      " and not an unknown; list the points and vectors of the body's base");
  } else if (symbol->fixed) {
    report(where, in_quotes(name) + " is fixed; a group lists unknowns");
  }
}

// ---- outputs

void Validation::check_outputs() {
  const auto& outputs = scene_.outputs();
  for (std::size_t i = 0; i < outputs.size(); ++i) check_output(outputs[i], Where("/outputs") / i);
}

void Validation::check_output(const std::string& text, const Where& where) {
  std::size_t first = text.find('.');  // or a later one: "J.axis" may be a name
  for (std::size_t end = text.size(); end != std::string::npos && end > first; end = text.rfind('.', end - 1)) {
    if (symbols_.find(text.substr(0, end)) == nullptr) continue;
    first = end < text.size() ? end : std::string::npos;
    break;
  }
  const std::string name = text.substr(0, first);
  std::string part = first == std::string::npos ? "" : text.substr(first + 1);
  const Symbol* symbol = symbols_.find(name);
  if (symbol == nullptr && text == kEverything) {
    if (scene_.outputs().size() > 1) report(where, "'all' means everything; write it alone");
    return;
  }
  if (symbol == nullptr) {
    const auto joint =
        std::find_if(scene_.joints().begin(), scene_.joints().end(), [&](const Joint& j) { return j.name == name; });
    if (joint == scene_.joints().end()) {
      unknown_name(name, {NameKind::point, NameKind::vector, NameKind::measure}, where, true);
    } else if (!known_.hides_names()) {
      report(where, why_no_output(*joint));
    }
    return;
  }
  if (symbol->broken) return;
  int components = 1;
  std::string owner = name;
  const std::size_t second = part.find('.');
  const std::string own = part.substr(0, second);
  if (symbol->kind == NameKind::point || symbol->kind == NameKind::vector) {
    components = dimension();
  } else if (const int of_auxiliary = auxiliary(*symbol, own); of_auxiliary > 0) {
    components = of_auxiliary;
    owner = name + "." + own;
    part = second == std::string::npos ? "" : part.substr(second + 1);
  } else if (symbol->kind == NameKind::constraint && !part.empty()) {
    (void)scalar(name + "." + own, where);
    return;
  } else if (symbol->kind != NameKind::measure) {
    report(where, in_quotes(name) + " is " + std::string(with_article(symbol->kind)) +
                      (symbol->kind == NameKind::body && name != "ground"
                           ? "; its outputs are " + in_quotes(name) + " alone, the whole pose, or its parts: " +
                                 (dimension() == 2 ? "origin, angle"
                                                   : "origin, quaternion, angular_velocity, angular_acceleration")
                           : "; an output is a point, a vector, a body, a measure or a constraint's lambda or mu"));
    return;
  }
  const auto asked = asked_part(part, components);
  const auto is_turn = [&] {
    const auto* orientation = std::get_if<Orientation>(&scene_.measures()[symbol->index].kind);
    return orientation != nullptr && orientation->part >= Orientation::Part::turn_x;
  };
  if (asked && asked->derivative == 0 && symbol->kind == NameKind::measure && is_turn()) {
    report(where, in_quotes(owner) + " has no value; expected rate or acceleration");
    return;
  }
  if (text == owner || asked) return;
  report(where, in_quotes(owner) + " has no part " + in_quotes(part) + "; expected " +
                    (components == 1   ? "value, rate or acceleration"
                     : components == 2 ? "position, velocity, acceleration, x, y, vx, vy, ax or ay"
                                       : "position, velocity, acceleration, x, y, z, vx, vy, vz, ax, ay or az"));
}

// Number of components of an auxiliary unknown of a constraint, driver or body; 0: it has none of that name.
int Validation::auxiliary(const Symbol& symbol, const std::string& name) const {
  if (symbol.kind == NameKind::constraint) return has_auxiliary(scene_.constraints()[symbol.index], name) ? 1 : 0;
  if (symbol.kind == NameKind::driver) {
    const Driver& driver = scene_.drivers()[symbol.index];
    if (const auto* arm = std::get_if<PointAngle>(&driver.kind)) {
      return name == "rho" && dimension() == 3 && driven_distance(arm->a, arm->b) != nullptr ? 1 : 0;
    }
    const auto* angle = std::get_if<RelativeAngle>(&driver.kind);
    if (angle == nullptr) return 0;
    const Symbol* axis = symbols_.find(axis_of(*angle));
    if (name == "across") return dimension() == 3 && axis != nullptr && !axis->fixed ? 3 : 0;
    return name == "rho" ? 1 : 0;
  }
  if (symbol.kind == NameKind::body && name == "normal" && dimension() == 3) {
    const Body& body = scene_.bodies()[symbol.index];
    const auto off_plane = [](const Member& m) { return m.local[2] != 0; };
    const bool has_normal = std::any_of(body.points.begin(), body.points.end(), off_plane) ||
                            std::any_of(body.vectors.begin(), body.vectors.end(), off_plane);
    return body.base.size() == 3 && has_normal ? 3 : 0;
  }
  return 0;
}

}  // namespace assur
