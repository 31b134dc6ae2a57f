#include "joints/expansion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "decimal.hpp"
#include "joints/gear.hpp"
#include "joints/joint_kinds.hpp"

namespace assur::joints {
namespace {

std::vector<std::string_view> coordinates_of(const Joint& j) {
  if (std::holds_alternative<Cylindrical>(j.kind)) return {"angle", "displacement"};
  if (std::holds_alternative<Revolute>(j.kind)) return {"angle"};
  if (std::holds_alternative<Prismatic>(j.kind)) return {"displacement"};
  return {};
}

// "joint 'J' is revolute and has no displacement; it has: angle"
std::string no_such_part(const Joint& j, std::string_view part) {
  const std::string front = "joint " + in_quotes(j.name) + " is " + std::string(kind_of(j).name);
  const auto parts = coordinates_of(j);
  if (parts.empty()) return front + "; only revolute, prismatic and cylindrical joints have coordinates";
  const std::string near = near_miss(part, parts);
  return front + " and has no " + excerpt(part) +
         (near.empty() ? "; it has: " + list_of(parts) : "; did you mean " + in_quotes(j.name + "." + near) + "?");
}

}  // namespace

Expansion::Coordinate Expansion::coordinate(const std::string& text, const Where& at) {
  const std::size_t dot = text.find('.');
  if (dot == std::string::npos) return {};
  const std::string name = text.substr(0, dot);
  const auto found = joint_of_.find(name);
  if (found == joint_of_.end()) return {};
  const Joint* const j = found->second;
  const std::string part = text.substr(dot + 1, text.find('.', dot + 1) - dot - 1);
  const auto parts = coordinates_of(*j);
  if (part != "angle" && part != "displacement") {
    if (!near_miss(part, parts).empty()) report(at, no_such_part(*j, part));
    return {};
  }
  if (std::find(parts.begin(), parts.end(), part) == parts.end()) {
    report(at, no_such_part(*j, part));
    return {};
  }
  return {j, part == "angle"};
}

Expansion::Coordinate Expansion::scalar(const std::string& text, const Where& at) {
  const std::size_t dot = text.find('.');
  const auto found = joint_of_.find(text.substr(0, dot));
  if (found == joint_of_.end()) return {};
  const Joint& j = *found->second;
  const auto parts = coordinates_of(j);
  const std::string part = dot == text.npos ? "" : text.substr(dot + 1);
  const bool is_near = !near_miss(part.substr(0, part.find('.')), {"angle", "displacement"}).empty();
  if (part.empty() && !parts.empty()) {
    report(at, in_quotes(text) + " is a joint; write one of its coordinates, such as " +
                   in_quotes(j.name + "." + std::string(parts[0])));
  } else if (part.empty() || (is_near && std::find(parts.begin(), parts.end(), part) == parts.end())) {
    report(at, no_such_part(j, part));
  } else {
    return coordinate(text, at);
  }
  return {};
}

void Expansion::read_coordinates() {
  std::map<std::pair<const Joint*, bool>, std::string_view> driver_of;
  for (Driver& d : p_.drivers) {
    if (const auto* c = std::get_if<DrivenCoordinate>(&d.kind)) {
      const Where here = Where("/drivers") / d.name / "coordinate";
      const Coordinate of = scalar(c->coordinate, here);
      if (of.joint == nullptr) continue;
      if (const auto [first, is_new] = driver_of.emplace(std::pair(of.joint, of.is_angle), d.name); !is_new) {
        report(here, in_quotes(first->second) + " drives " + in_quotes(c->coordinate) +
                         " already; use one driver for each motion");
      }
      driven_.emplace_back(&d, of);
    }
  }
  for (Measure& m : p_.measures) {
    if (const auto* c = std::get_if<MeasuredCoordinate>(&m.kind)) {
      const Coordinate of = scalar(c->coordinate, Where("/measures") / m.name / "coordinate");
      if (of.joint != nullptr) measured_.emplace_back(&m, of);
    }
  }
  for (std::size_t c = 0; c < p_.constraints.size(); ++c) {
    if (const auto* gear = p_.constraints[c].as<Gear>()) read_gear(c, *gear);
  }
  for (std::size_t i = 0; i < p_.outputs.size(); ++i) {
    const Coordinate of = coordinate(p_.outputs[i], Where("/outputs") / i);
    if (of.joint != nullptr) asked_.insert(of.joint->name + (of.is_angle ? ".angle" : ".displacement"));
  }
  read_limits();
}

// A limited coordinate is measured; the law of its driver tells its whole turns at the start.
void Expansion::read_limits() {
  for (Limit& l : p_.limits) {
    const Coordinate of = coordinate(l.quantity, Where("/limits") / l.quantity);
    if (of.joint == nullptr || l.quantity.find('.') != l.quantity.rfind('.')) continue;
    asked_.insert(l.quantity);
    for (const auto& [driver, driven] : driven_) {
      if (driven.joint == of.joint && driven.is_angle == of.is_angle) l.driver = driver->name;
    }
  }
}

void Expansion::read_gear(std::size_t constraint, const Gear& gear) {
  const Where here = Where("/constraints") / p_.constraints[constraint].name;
  Geared g{constraint, {}, gear.ratio};
  for (std::size_t side = 0; side < 2; ++side) {
    const std::string& name = side == 0 ? gear.a : gear.b;
    g.sides[side] = coordinate(name, here / "gear" / side);
    const bool is_part = name.find('.') != name.rfind('.');
    if (g.sides[side].joint != nullptr && !is_part) continue;
    report(here / "gear" / side,
           in_quotes(name) + " is no coordinate of a joint; write JOINT.angle or JOINT.displacement");
    return;
  }
  if (gear.a == gear.b) return report(here / "gear", "both coordinates are " + in_quotes(gear.a));
  if (!std::isfinite(gear.ratio) || gear.ratio == 0) {
    return report(here / "ratio", "the ratio is " + general(gear.ratio, 6) + "; it must be finite and not 0");
  }
  if (g.sides[0].is_angle && g.sides[1].is_angle && !whole_ratio(gear.ratio)) {
    return report(here / "ratio",
                  "the ratio of two angles is that of whole numbers up to 1000, as of teeth, within "
                  "1e-9; " +
                      general(gear.ratio, 10) + " is not");
  }
  geared_.push_back(g);
}

void Expansion::place_angles() {
  for (const auto& [driver, of] : driven_) {
    if (of.is_angle) drive_angle(*driver, *of.joint);
  }
  for (const auto& [measure, of] : measured_) {
    if (of.is_angle) between(*of.joint);
  }
  for (const Geared& g : geared_) {
    for (const Coordinate& side : g.sides) {
      if (side.is_angle) between(*side.joint);
    }
  }
  for (const Joint& j : p_.joints) {
    if (asked_.count(j.name + ".angle") != 0) between(j);
  }
}

void Expansion::drive_angle(const Driver& d, const Joint& j) {
  const auto* r = std::get_if<Revolute>(&j.kind);
  const auto [a, b] = bodies_of(j);
  Solid& turned = solids_[idx(solid(b))];
  if (r == nullptr || solid(a) != ground_ || turned.is_rigid()) return (void)between(j);
  const std::size_t centre = point_of(*r, j);
  const Triple at = features_[centre].at, axis = in_space() ? features_[axis_of_.at(&j)].at : Triple{0, 0, 1};
  // A point near the axis does not serve: the base of the body needs another one, which the arm would determine twice.
  const auto serves = [&](std::size_t i) {
    const Feature& f = features_[i];
    return f.is_point && !f.fixed && !f.driven && f.solid == kNobody && !is_same(f.at, at) &&
           (!in_space() || sine(minus(f.at, at), axis) > kWellApart);
  };
  auto arm = std::find_if(turned.features.begin(), turned.features.end(), serves);
  if (arm == turned.features.end()) {
    put_on(solid(b),
           add({j.name + ".arm", true, triple::add(at, triple::scale(arm_length(at), across(axis, p_.dimension)))}));
    arm = turned.features.end() - 1;
  }
  features_[*arm].driven = features_[*arm].wanted = true;
  arms_.emplace(&d, std::pair(centre, *arm));
}

std::size_t Expansion::point_of(const Revolute& r, const Joint& j) const {
  const auto* given = std::get_if<std::string>(&r.at);
  return feature_of_.at(given != nullptr ? *given : j.name);
}

Number Expansion::arm_length(const Triple& at) const {
  std::vector<Number> lengths;
  const std::size_t stride = features_.size() / kSearched + 1;
  for (std::size_t i = 0; i < features_.size(); i += stride) {
    const Feature& f = features_[i];
    if (f.is_point && !is_same(f.at, at)) lengths.push_back(triple::norm(minus(f.at, at)));
  }
  if (lengths.empty()) return 1;
  std::nth_element(lengths.begin(), lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2), lengths.end());
  return lengths[lengths.size() / 2];
}

Triple Expansion::arm_direction(int solid, const Triple& axis) const {
  const Feature* first = nullptr;
  for (const std::size_t i : solids_[idx(solid)].features) {
    const Feature& f = features_[i];
    if (!f.is_point || !f.wanted) continue;
    if (first == nullptr) {
      first = &f;
      continue;
    }
    const Triple way = minus(f.at, first->at), off = minus(way, triple::scale(triple::dot(way, axis), axis));
    if (triple::norm(off) > kWellApart * triple::norm(way)) return unit(off);
  }
  return across(axis, p_.dimension);
}

void Expansion::between(const Joint& j) {
  const auto [a, b] = bodies_of(j);
  if (feature_of_.count(j.name + ".from") != 0) return;
  const Triple axis = in_space() ? features_[axis_of_.at(&j)].at : Triple{0, 0, 1};
  const Triple at = arm_direction(solid(b), axis);
  for (const auto& [body, name] : {std::pair(&a, ".from"), std::pair(&b, ".to")}) {
    Feature f{j.name + name, false, at};
    f.wanted = false;
    share(j, where(j), solid(*body), add(std::move(f)));
  }
}

}  // namespace assur::joints

namespace assur {

std::string why_no_output(const Joint& j) {
  std::string point;
  std::visit(
      [&](const auto& kind) {
        if constexpr (requires { kind.at; }) {
          if (const auto* given = std::get_if<std::string>(&kind.at)) point = *given;
        }
      },
      j.kind);
  std::string all;
  const auto list = [&](const std::string& name) { all += (all.empty() ? "" : ", ") + in_quotes(name); };
  for (const std::string_view part : joints::coordinates_of(j)) list(j.name + "." + std::string(part));
  if (!point.empty()) list(point);
  return in_quotes(j.name) + " is a joint without a point of its own; " +
         (all.empty() ? "it has no coordinates either" : "its outputs are: " + all);
}

bool asks_for_coordinate(const std::vector<Joint>& joints, const std::vector<std::string>& outputs) {
  std::set<std::string_view> asked;
  for (const std::string_view text : outputs) {
    const std::size_t dot = text.find('.');
    if (dot == text.npos) continue;
    const std::string_view part = text.substr(dot + 1, text.find('.', dot + 1) - dot - 1);
    if (part == "angle" || part == "displacement") asked.insert(text.substr(0, dot));
  }
  return std::any_of(joints.begin(), joints.end(), [&](const Joint& j) { return asked.count(j.name) != 0; });
}

}  // namespace assur
