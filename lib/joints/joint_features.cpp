#include "joints/expansion.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "decimal.hpp"
#include "joints/joint_kinds.hpp"

namespace assur::joints {

std::size_t Expansion::anchor(const Joint& j, const Where& here, const Anchor& a, bool is_point, std::string name,
                              std::initializer_list<int> solids) {
  std::size_t feature = 0;
  if (const auto* given = std::get_if<std::string>(&a)) {
    const auto found = feature_of_.find(*given);
    if (found == feature_of_.end() || features_[found->second].is_point != is_point) {
      const std::string wanted = is_point ? "point" : "unit vector";
      std::vector<std::string_view> names;
      for (const Feature& f : features_) {
        if (suggestions_left_ > 0 && f.is_point == is_point) names.push_back(f.name);
      }
      report(here,
             found != feature_of_.end()
                 ? in_quotes(*given) + (is_point ? " is a vector; a " : " is a point; a ") + wanted + " is wanted here"
                 : "there is no " + wanted + " " + in_quotes(*given) + instead(*given, names));
      return add({std::move(name), is_point, {1, 0, 0}});
    }
    feature = found->second;
    features_[feature].wanted = true;
  } else {
    Triple at = std::get<Triple>(a);
    if (!triple::is_finite(at)) {
      report(here, "the coordinates must be finite");
      at = {1, 0, 0};
    } else if (!is_point && triple::norm(at) == 0) {
      report(here, std::string(here.text().ends_with("/normal") ? "the normal" : "the axis") +
                       " is zero or missing; give a direction, e.g. [0, 0, 1]");
      at = {1, 0, 0};
    } else if (!in_space() && at[2] != 0) {
      report(here, "a plane scene has no z; write 0 or leave it out");
    }
    feature = add({std::move(name), is_point, is_point ? at : unit(at)});
  }
  const bool is_shared = solids.size() == 2 && !is_held(j) && std::all_of(solids.begin(), solids.end(), [&](int s) {
                           return on_.count({s, feature}) != 0;
                         });
  if (is_shared) implied_.emplace_back(&j, p_.dimension - (is_point ? 0 : 1));
  for (const int s : solids) share(j, here, s, feature);
  return feature;
}

void Expansion::share(const Joint& j, const Where& here, int s, std::size_t feature) {
  Feature& f = features_[feature];
  if (s == ground_ && !f.fixed && f.home == Feature::Home::scene) {
    report(here, in_quotes(f.name) + " is not fixed, but joint " + in_quotes(j.name) + " connects it to the ground");
  }
  f.fixed = f.fixed || (s == ground_ && f.solid == kNobody);
  put_on(s, feature);
  put_there_by_.emplace(std::pair(s, feature), &j);
}

void Expansion::share_features() {
  for (const Joint& j : p_.joints) {
    const auto [a, b] = bodies_of(j);
    if (body_of_.count(a) + body_of_.count(b) + (a == kGround) + (b == kGround) < 2) continue;
    const int sa = solid(a), sb = solid(b);
    if (std::holds_alternative<Fixed>(j.kind) || a == b) continue;
    if (sa == sb) {
      implied_.emplace_back(&j, in_space() ? kind_of(j).translations + kind_of(j).turns : 2);
      p_.warnings.push_back({where(j).text(), "the joint cannot move, because fixed joints connect its bodies"});
    }
    if (!in_space() && !kind_of(j).in_the_plane) {
      report(where(j) / kind_of(j).name,
             std::string(kind_of(j).name) + " joints are for 3D; in the plane there are revolute, prismatic and fixed");
      continue;
    }
    std::visit([&](const auto& kind) { share(j, kind, sa, sb); }, j.kind);
  }
}

void Expansion::share(const Joint& j, const Revolute& r, int a, int b) {
  anchor(j, where(j) / "at", r.at, true, j.name, {a, b});
  const auto* axis = std::get_if<Triple>(&r.axis);
  if (in_space()) {
    axis_of_[&j] = anchor(j, where(j) / "axis", r.axis, false, j.name + ".axis", {a, b});
  } else if (axis == nullptr || *axis != Triple{}) {
    report(where(j) / "axis", "in the plane every axis is the normal; leave \"axis\" out");
  }
}

void Expansion::share(const Joint& j, const Prismatic& r, int a, int b) {
  axis_of_[&j] = anchor(j, where(j) / "axis", r.axis, false, j.name + ".axis", {a, b});
  slides_.push_back({&j, a, b, axis_of_[&j]});
}

void Expansion::share(const Joint& j, const Cylindrical& r, int a, int b) {
  axis_of_[&j] = anchor(j, where(j) / "axis", r.axis, false, j.name + ".axis", {a, b});
  slides_.push_back({&j, a, b, axis_of_[&j], false, true, &r.at});
}

void Expansion::share(const Joint& j, const Universal& r, int a, int b) {
  anchor(j, where(j) / "at", r.at, true, j.name, {a, b});
  const std::size_t d = anchor(j, where(j) / "axes" / std::size_t{0}, r.axis_a, false, j.name + ".axis_a", {a});
  const std::size_t e = anchor(j, where(j) / "axes" / std::size_t{1}, r.axis_b, false, j.name + ".axis_b", {b});
  const Number cosine = triple::dot(features_[d].at, features_[e].at);
  if (d == e || !(abs(cosine) <= kSquare)) {
    const bool are_parallel = sine(features_[d].at, features_[e].at) <= kSquare;
    report(where(j) / "axes",
           (are_parallel ? "the axes are parallel" : "the axes have the dot product " + general(cosine.value(), 6)) +
               "; those of a universal joint are at right angles");
  }
  crossings_.push_back({&j, d, e});
}

void Expansion::share(const Joint& j, const Planar& r, int a, int b) {
  const std::size_t n = anchor(j, where(j) / "normal", r.normal, false, j.name + ".normal", {a, b});
  slides_.push_back({&j, a, b, n, true, true});
}

bool Expansion::is_on_line(const Feature& f, const Triple& at, const Triple& axis, double share) const {
  if (!f.is_point) return sine(f.at, axis) <= share;
  const Triple off = minus(f.at, at);
  return triple::norm(off) == 0 ||
         triple::norm(triple::cross(off, axis)) <= share * std::max(triple::norm(off), triple::norm(f.at));
}

void Expansion::place_slides() {
  for (Slide& s : slides_) {
    const Joint& j = *s.joint;
    const Triple axis = features_[s.axis].at;
    features_[s.axis].slides = !s.on_plane;
    Solid& second = solids_[idx(s.b)];
    std::size_t given = features_.size();
    Triple at{};
    if (s.at != nullptr) {
      given = anchor(j, where(j) / "at", *s.at, true, j.name, {});
      at = features_[given].at;
    }
    const auto serves = [&](std::size_t i) {
      const Feature& f = features_[i];
      return f.is_point && f.wanted && (s.at == nullptr || is_on_line(f, at, axis));
    };
    const auto last =
        second.features.begin() + static_cast<std::ptrdiff_t>(std::min(second.features.size(), kSearched));
    const auto own = std::find_if(second.features.begin(), last, serves);
    if (own != last) {
      s.point = *own;
    } else {
      if (s.at == nullptr) {
        const auto& others = solids_[idx(s.a)].features;
        const auto point =
            std::find_if(others.begin(), others.end(), [&](std::size_t i) { return features_[i].is_point; });
        if (point != others.end()) at = features_[*point].at;
        given = add({j.name, true, at});
      }
      s.point = given;
      share(j, where(j), s.b, given);
    }
    s.origin = add({j.name + ".origin", true, features_[s.point].at});
    share(j, where(j), s.a, s.origin);
  }
}

// A joint that cannot move has the constant coordinates 0, which can be measured, but neither driven nor geared.
void Expansion::check_slides() {
  const auto refuse = [&](const Coordinate& of, const Where& at) {
    if (is_held(*of.joint)) {
      report(at, "joint " + in_quotes(of.joint->name) + " cannot move, because fixed joints connect its bodies");
    }
    for (const Slide& s : slides_) {
      if (of.is_angle || s.joint != of.joint || !is_locked(s)) continue;
      report(at, "joint " + in_quotes(of.joint->name) + " cannot slide, because other joints hold both of its bodies");
    }
  };
  for (const auto& [d, of] : driven_) refuse(of, Where("/drivers") / d->name / "coordinate");
  for (const Geared& g : geared_) {
    for (std::size_t side = 0; side < 2; ++side) {
      refuse(g.sides[side], Where("/constraints") / p_.constraints[g.constraint].name / "gear" / side);
    }
  }
}

void Expansion::share_sides() {
  std::vector<int> parent(solids_.size());  // joined: rods that turn together
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[idx(i)] != i) i = parent[idx(i)] = parent[idx(parent[idx(i)])];
    return i;
  };
  const auto is_rod = [&](const Slide& s, int solid) {
    const Solid& of = solids_[idx(solid)];
    const Triple axis = features_[s.axis].at, at = features_[s.point].at;
    return !of.is_rigid() && std::all_of(of.features.begin(), of.features.end(),
                                         [&](std::size_t i) { return is_on_line(features_[i], at, axis); });
  };
  const auto keeps_direction = [&](const Slide& s) { return !s.turns && in_space() && s.a != s.b; };
  for (const Slide& s : slides_) {
    if (keeps_direction(s) && is_rod(s, s.a) && is_rod(s, s.b)) parent[idx(root(s.a))] = root(s.b);
  }
  std::map<int, std::set<int>> ends;  // of joined rods: the other solids on prismatic joints
  for (const Slide& s : slides_) {
    if (!keeps_direction(s)) continue;
    const bool a = is_rod(s, s.a), b = is_rod(s, s.b);
    if (a && !b) ends[root(s.a)].insert(s.b);
    if (b && !a) ends[root(s.b)].insert(s.a);
  }
  std::vector<const Slide*> sided;
  std::map<int, int> turned_by;  // solids that unsided joints turn together
  const auto turns_with = [&](int i) {
    for (auto up = turned_by.find(i); up != turned_by.end(); up = turned_by.find(i)) i = up->second;
    return i;
  };
  const auto join = [&](int a, int b) {
    a = turns_with(a), b = turns_with(b);
    if (a != b) turned_by[a] = b;
    return a != b;
  };
  for (const Slide& s : slides_) {
    if (!keeps_direction(s)) continue;
    const bool a = is_rod(s, s.a), b = is_rod(s, s.b);
    if ((!a && !b) || ends[root(a ? s.a : s.b)].size() > 1) {
      sided.push_back(&s);
    } else if (!join(s.a, s.b)) {
      implied_.emplace_back(s.joint, 1);  // other joints of the rods keep this turn already
    }
  }
  for (const Slide* const slide : sided) {
    const Slide& s = *slide;
    const Triple axis = features_[s.axis].at;
    const auto side = [&](int solid) {
      const auto& of = solids_[idx(solid)].features;
      return std::find_if(of.begin(), of.end(), [&](std::size_t i) {
        const Feature& f = features_[i];
        const bool may_be_fixed = f.fixed || f.home != Feature::Home::scene;
        return !f.is_point && f.wanted && may_be_fixed && sine(f.at, axis) > 0.5;
      });
    };
    std::size_t shared = 0;
    if (const auto one = side(s.a); one != solids_[idx(s.a)].features.end()) {
      shared = *one;
    } else if (const auto other = side(s.b); other != solids_[idx(s.b)].features.end()) {
      shared = *other;
    } else {
      shared = add({s.joint->name + ".side", false, across(axis, 3)});
    }
    // The joint keeps one angle, and a shared direction two of them.
    const bool is_shared = on_.count({s.a, shared}) != 0 && on_.count({s.b, shared}) != 0;
    implied_.emplace_back(s.joint, is_shared ? 1 : -1);
    share(*s.joint, where(*s.joint), s.a, shared);
    share(*s.joint, where(*s.joint), s.b, shared);
  }
}

}  // namespace assur::joints
