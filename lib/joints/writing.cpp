#include "joints/expansion.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "joints/gear.hpp"

namespace assur::joints {

void Expansion::write() {
  using Home = Feature::Home;
  std::map<std::string, std::vector<Member>> points, vectors;  // of bodies
  std::set<std::string> left;                                  // points and vectors that became members
  const auto give = [&](int s, const Feature& f) {
    const Solid& solid = solids_[idx(s)];
    const std::size_t b = solid.based >= 0 ? idx(solid.based) : solid.bodies.front();
    (f.is_point ? points : vectors)[p_.bodies[b].name].push_back({f.name, f.at, true});
  };
  std::set<std::string> still;  // members of bodies without a base that stay members
  std::set<std::size_t> used;
  for (const Solid& s : solids_) used.insert(s.features.begin(), s.features.end());
  for (std::size_t i = 0; i < features_.size(); ++i) {
    const Feature& f = features_[i];
    const bool is_member = f.solid != kNobody;
    if (f.home == Home::ground || used.count(i) == 0) continue;
    if (is_member && f.home == Home::member && f.from == f.solid) {
      still.insert(f.name);
      continue;
    }
    if (is_member && f.home == Home::scene) left.insert(f.name);
    if (is_member) {
      give(f.solid, f);
    } else if (f.home != Home::scene) {
      declare(f);
    }
  }
  const auto fix = [&](auto& items) {
    for (auto& item : items) {
      const auto found = feature_of_.find(item.name);
      if (found != feature_of_.end()) item.fixed = features_[found->second].fixed;
    }
  };
  fix(p_.points), fix(p_.vectors);
  std::erase_if(p_.points, [&](const Point& p) { return left.count(p.name) != 0; });
  std::erase_if(p_.vectors, [&](const Vector& v) { return left.count(v.name) != 0; });
  for (const auto& [s, base] : based_on_) {
    for (const std::size_t i : base) keepers_[i].insert(s);
  }
  for (std::size_t i = 0; i < features_.size(); ++i) {
    if (features_[i].solid != kNobody) keepers_[i].insert(features_[i].solid);
  }
  for (const Tie& t : ties_) tied_.emplace(t.solid, t.feature);
  for (std::size_t t = 0; t < ties_.size(); ++t) tie(t, points, vectors);
  for (std::size_t s = 0; s < solids_.size(); ++s) set_base(s, still);
  for (Body& b : p_.bodies) {
    for (Member& m : points[b.name]) b.points.push_back(std::move(m));
    for (Member& m : vectors[b.name]) b.vectors.push_back(std::move(m));
  }
  std::erase_if(p_.bodies, [&](const Body& b) { return gone_.count(b.name) != 0; });
  for (const Slide& s : slides_) {
    if (!is_locked(s)) {
      write(s);
    } else if (s.a != s.b) {
      implied_.emplace_back(s.joint, s.on_plane ? 1 : p_.dimension - 1);
    }
  }
  for (const auto& [j, d, e] : crossings_) {
    if (is_held(*j)) continue;
    if (features_[d].fixed && features_[e].fixed) {
      implied_.emplace_back(j, 1);
      continue;
    }
    p_.constraints.push_back({j->name + ".cross", Dot{features_[d].name, features_[e].name, 0.0}});
  }
  write_coordinates();
  write_implied();
}

void Expansion::count_kept_sides() {
  for (const auto& based : based_on_) {
    const int s = based.first;
    const auto& base = based.second;  // no structured bindings: Clang before 16 cannot capture them
    const Solid& solid = solids_[idx(s)];
    if (solid.is_rigid() || solid.bodies.empty()) continue;
    // All are fixed, or another body keeps them: one whose members are among them, or of two with the same base the
    // first one.
    const auto are_kept = [&](std::initializer_list<std::size_t> entries) {
      const auto all = [&](auto&& holds) { return std::all_of(entries.begin(), entries.end(), holds); };
      if (all([&](std::size_t i) { return features_[base[i]].fixed; })) return true;
      const std::set<int>& candidates = keepers_[base[*entries.begin()]];
      return std::any_of(candidates.begin(), candidates.end(), [&](int t) {
        const auto is_member = [&](std::size_t i) { return features_[base[i]].solid == t; };
        const bool is_first = t < s || std::any_of(entries.begin(), entries.end(), is_member);
        return t != s && is_first && all([&](std::size_t i) { return keepers_[base[i]].count(t) != 0; });
      });
    };
    const auto count = [&](std::size_t last, std::initializer_list<std::size_t> entries) {
      const auto by = put_there_by_.find({s, base[last]});
      if (by != put_there_by_.end() && are_kept(entries)) implied_.emplace_back(by->second, 1);
    };
    const auto is_point = [&](std::size_t i) { return features_[base[i]].is_point; };
    if (base.size() > 1 && is_point(1)) count(1, {0, 1});
    if (base.size() < 3) continue;
    if (is_point(2)) count(2, {0, 2});
    if (is_point(1) == is_point(2)) {
      count(2, {1, 2});
    } else {
      count(2, {0, 1, 2});
    }
  }
}

void Expansion::write_implied() {
  count_kept_sides();
  std::vector<int> parent(solids_.size());  // solids that joints connect
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[idx(i)] != i) i = parent[idx(i)] = parent[idx(parent[idx(i)])];
    return i;
  };
  const auto moving = [&](const Joint& j) {
    const auto [a, b] = bodies_of(j);
    return solid(a) == ground_ ? solid(b) : solid(a);
  };
  for (const Joint& j : p_.joints) {
    const auto [a, b] = bodies_of(j);
    if (solid(a) != ground_ && solid(b) != ground_) parent[idx(root(solid(a)))] = root(solid(b));
  }
  std::map<int, int> left;  // of each connected part
  for (const auto& [j, rows] : implied_) left[root(moving(*j))] += rows;
  std::map<const Joint*, int> count;
  for (const auto& [j, rows] : implied_) {
    const std::string zero = j->name + ".zero";
    for (int k = 0; k < rows && left[root(moving(*j))] > 0; ++k, --left[root(moving(*j))]) {
      if (feature_of_.count(zero) == 0) declare(features_[add({zero, true, {}, true})]);
      p_.constraints.push_back({j->name + ".rest" + std::to_string(count[j]++), FixedCoordinate{zero + ".x", 0}});
    }
  }
}

void Expansion::declare(const Feature& f) {
  if (f.is_point) {
    p_.points.push_back({f.name, f.at, f.fixed});
  } else {
    p_.vectors.push_back({f.name, f.at, f.fixed, true});
  }
}

void Expansion::tie(std::size_t t, std::map<std::string, std::vector<Member>>& points,
                    std::map<std::string, std::vector<Member>>& vectors) {
  const Feature& f = features_[ties_[t].feature];
  const Solid& solid = solids_[idx(ties_[t].solid)];
  const auto by = put_there_by_.find({ties_[t].solid, ties_[t].feature});
  const std::size_t b = solid.based >= 0 ? idx(solid.based) : solid.bodies.empty() ? 0 : solid.bodies.front();
  const std::string stem = by != put_there_by_.end() ? by->second->name : p_.bodies[b].name;
  const std::string copy = stem + ".copy" + std::to_string(t);
  if (const std::size_t g = companion(ties_[t]); g != ties_[t].feature) {
    const std::string side = stem + ".across" + std::to_string(t);
    const Triple at = unit(triple::cross(features_[g].at, f.at));
    if (solid.is_ground) {
      declare({side, false, at, true});
    } else {
      vectors[p_.bodies[b].name].push_back({side, at, true});
    }
    p_.constraints.push_back({stem + ".meet" + std::to_string(t), Dot{f.name, side, 0.0}});
    if (by != put_there_by_.end()) implied_.emplace_back(by->second, 1);
    return;
  }
  if (solid.is_ground) {
    declare({copy, f.is_point, f.at, true});
  } else {
    (f.is_point ? points : vectors)[p_.bodies[b].name].push_back({copy, f.at, true});
  }
  if (f.is_point) {
    p_.constraints.push_back({stem + ".meet" + std::to_string(t), Linear{{{f.name, 1}, {copy, -1}}, {}}});
  } else {
    p_.constraints.push_back({stem + ".meet" + std::to_string(t), Parallel{f.name, copy}});
  }
}

// Another direction of the solid whose angle to the tied direction a second solid keeps constant; if there is none, the
// tied direction itself.
std::size_t Expansion::companion(const Tie& tie) const {
  const std::size_t f = tie.feature;
  if (!in_space() || features_[f].is_point) return f;
  const auto keepers = keepers_.find(f);
  if (keepers == keepers_.end()) return f;
  const auto keeps = [&](int s, std::size_t g) {
    const auto found = keepers_.find(g);
    return s != tie.solid && found != keepers_.end() && found->second.count(s) != 0;
  };
  const auto serves = [&](std::size_t g) {
    return !features_[g].is_point && g != f && tied_.count({tie.solid, g}) == 0 &&
           sine(features_[g].at, features_[f].at) > kWellApart &&
           std::any_of(keepers->second.begin(), keepers->second.end(), [&](int s) { return keeps(s, g); });
  };
  const auto& all = solids_[idx(tie.solid)].features;
  const auto found = std::find_if(all.begin(), all.end(), serves);
  return found != all.end() ? *found : f;
}

void Expansion::set_base(std::size_t s, const std::set<std::string>& still) {
  const Solid& solid = solids_[s];
  if (solid.is_ground) {
    for (const std::size_t b : solid.bodies) {
      if (p_.bodies[b].name != kGround) gone_.insert(p_.bodies[b].name);
    }
    return;
  }
  const Body* based = solid.based >= 0 ? &p_.bodies[idx(solid.based)] : nullptr;
  std::vector<std::string> base;
  if (based == nullptr) {
    for (const std::size_t i : base_.at(s)) base.push_back(features_[i].name);
  }
  for (const std::size_t b : solid.bodies) {
    Body& body = p_.bodies[b];
    if (has_base(body)) continue;
    body.rigid.clear();
    const auto is_elsewhere = [&](const Member& m) { return still.count(m.name) == 0; };
    std::erase_if(body.points, is_elsewhere);
    std::erase_if(body.vectors, is_elsewhere);
    if (based != nullptr) {
      body.origin = based->origin, body.frame = based->frame, body.base = based->base;
    } else if (base.size() > 1) {
      body.base = base;
      if (in_space() && base.size() == 2) {
        p_.warnings.push_back(
            {"/bodies/" + body.name, "the turn of the body about the line through " + in_quotes(base[0]) +
                                         (features_[base_.at(s)[1]].is_point ? " and " : " along ") +
                                         in_quotes(base[1]) + " is not computed, because nothing depends on it"});
      }
    } else {
      gone_.insert(body.name);
      p_.warnings.push_back({"/bodies/" + body.name, "the turn of the body about " + in_quotes(base[0]) +
                                                         " is not computed, because nothing depends on it"});
    }
  }
}

void Expansion::write(const Slide& s) {
  const std::string &point = features_[s.point].name, &origin = features_[s.origin].name,
                    &axis = features_[s.axis].name;
  if (s.on_plane) {
    p_.constraints.push_back({s.joint->name + ".slide", Dot{Direction(origin, point), axis, 0.0}});
  } else {
    p_.constraints.push_back({s.joint->name + ".slide", OnLine{point, origin, axis}});
  }
}

void Expansion::write_coordinates() {
  for (const auto& [driver, of] : driven_) {
    Law law = std::move(std::get<DrivenCoordinate>(driver->kind).law);
    const std::string& name = of.joint->name;
    const std::string axis = in_space() ? features_[axis_of_.at(of.joint)].name : "";
    if (!of.is_angle) {
      driver->kind = DrivenCoordinate{name + ".slide.lambda", std::move(law)};
    } else if (const auto arm = arms_.find(driver); arm != arms_.end()) {
      driver->kind =
          PointAngle{features_[arm->second.first].name, features_[arm->second.second].name, axis, std::move(law)};
      driver->relative = driver->sets_difference = true;
    } else {
      driver->kind = RelativeAngle{name + ".from", name + ".to", axis, std::move(law)};
      driver->sets_difference = true;  // from 0
    }
  }
  const auto side = [&](const Coordinate& of) {
    const std::string& name = of.joint->name;
    if (!of.is_angle) return GearSide{false, {}, {}, {}, name + ".slide.lambda"};
    return GearSide{true, name + ".from", name + ".to", in_space() ? features_[axis_of_.at(of.joint)].name : "", {}};
  };
  for (const Geared& g : geared_) {
    p_.constraints[g.constraint].kind = gear_equation(side(g.sides[0]), side(g.sides[1]), g.ratio);
  }
  const auto measure = [&](const Joint& j, bool is_angle, Measure& out) {
    const std::string axis = in_space() ? features_[axis_of_.at(&j)].name : "";
    if (is_angle) {
      out.kind = AngleBetween{j.name + ".from", j.name + ".to", axis};
    } else if (std::any_of(slides_.begin(), slides_.end(),
                           [&](const Slide& s) { return s.joint == &j && is_locked(s); })) {
      const std::string zero = j.name + ".zero";  // a fixed point at the origin
      if (feature_of_.count(zero) == 0) declare(features_[add({zero, true, {}, true})]);
      out.kind = MeasuredCoordinate{zero + ".x"};
    } else {
      out.kind = MeasuredCoordinate{j.name + ".slide.lambda"};
    }
  };
  for (const auto& [m, of] : measured_) measure(*of.joint, of.is_angle, *m);
  for (const Joint& j : p_.joints) {
    for (const bool is_angle : {true, false}) {
      const std::string name = j.name + (is_angle ? ".angle" : ".displacement");
      if (asked_.count(name) != 0) measure(j, is_angle, p_.measures.emplace_back(Measure{name, {}}));
    }
  }
}

}  // namespace assur::joints
