#include "joints/expansion.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "joints/joint_kinds.hpp"

namespace assur::joints {

std::vector<Diagnostic> Expansion::run() {
  if (!has_joints(p_)) return {};
  index_names();
  make_solids();
  place_features();
  read_coordinates();
  share_features();
  if (is_broken_) return give_up();
  place_slides();
  place_angles();
  share_sides();
  set_levels();
  for (std::size_t s = 0; s < solids_.size(); ++s) {
    if (solids_[s].is_rigid()) settle(s, own_base(s));
  }
  for (const std::size_t s : order()) choose_base(s);
  check_slides();
  if (is_broken_) return give_up();
  write();
  return {};
}

void Expansion::report(const Where& at, std::string what) {
  is_broken_ = true;
  if (known_.at_or_above(at.text()) || known_.at_or_below(at.text())) return;
  findings_.push_back({at.text(), std::move(what)});
  known_.add(findings_.back());
}

std::vector<Diagnostic> Expansion::give_up() {
  for (const Body& b : p_.bodies) {
    if (!has_base(b)) findings_.push_back({"/bodies/" + b.name, ""});
  }
  return std::move(findings_);
}

void Expansion::index_names() {
  for (std::size_t i = 0; i < p_.bodies.size(); ++i) body_of_.emplace(p_.bodies[i].name, i);
  std::set<std::string_view> names;
  const auto take = [&](const auto& items) {
    for (const auto& item : items) names.insert(item.name);
  };
  take(p_.points), take(p_.vectors), take(p_.bodies), take(p_.constraints), take(p_.drivers), take(p_.measures);
  for (const Body& b : p_.bodies) take(b.points), take(b.vectors);
  for (const Joint& j : p_.joints) {
    joint_of_.emplace(j.name, &j);
    if (std::string wrong = why_no_name(j.name); !wrong.empty()) {
      report(where(j), std::move(wrong));
    } else if (!names.insert(j.name).second) {
      report(where(j), in_quotes(j.name) + " is the name of something else already; all kinds share one set of names");
    }
  }
}

void Expansion::make_solids() {
  const std::size_t count = p_.bodies.size();
  std::vector<std::size_t> parent(count + 1);  // the last one: the ground, whether or not it is listed
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  const auto listed = body_of_.find(kGround);
  if (listed != body_of_.end()) parent[listed->second] = count;
  for (const Joint& j : p_.joints) {
    const auto [a, b] = bodies_of(j);
    const std::size_t i = body(j, a, 0), k = body(j, b, 1);
    if (i > count || k > count) continue;
    if (root(i) == root(k) && a == b) {
      report(where(j), "both bodies are " + in_quotes(a) + "; a joint connects two different bodies");
    }
    if (!std::holds_alternative<Fixed>(j.kind)) continue;
    if (root(i) == count) {  // the ground stays the root of its solid
      parent[root(k)] = count;
    } else {
      parent[root(i)] = root(k);
    }
  }
  solid_of_.assign(count + 1, kNobody);
  for (std::size_t i = 0; i <= count; ++i) {
    const std::size_t r = root(i);
    if (solid_of_[r] == kNobody) {
      solid_of_[r] = static_cast<int>(solids_.size());
      solids_.emplace_back();
    }
    solid_of_[i] = solid_of_[r];
    Solid& s = solids_[idx(solid_of_[i])];
    if (i == count) {
      s.is_ground = true;
      ground_ = solid_of_[i];
      continue;
    }
    s.bodies.push_back(i);
    const Body& b = p_.bodies[i];
    if (b.name == kGround || !has_base(b)) continue;
    if (s.based >= 0) {
      report(Where("/bodies") / b.name, "a fixed joint connects it to " + in_quotes(p_.bodies[idx(s.based)].name) +
                                            ", and both have a base; only one of them can have one");
    }
    s.based = static_cast<int>(i);
  }
  for (Solid& s : solids_) {
    if (s.is_ground && s.based >= 0) {
      report(Where("/bodies") / p_.bodies[idx(s.based)].name,
             "a fixed joint connects it to the ground, so it cannot have a base; fix the points of its base instead");
    }
  }
}

std::pair<const std::string&, const std::string&> Expansion::bodies_of(const Joint& j) {
  return std::visit([](const auto& kind) { return std::pair<const std::string&, const std::string&>(kind.a, kind.b); },
                    j.kind);
}

std::size_t Expansion::body(const Joint& j, const std::string& name, std::size_t side) {
  if (const auto found = body_of_.find(name); found != body_of_.end()) return found->second;
  if (name == kGround) return p_.bodies.size();
  std::vector<std::string_view> names;
  if (suggestions_left_ > 0) {
    for (const Body& b : p_.bodies) names.push_back(b.name);
    names.push_back(kGround);
  }
  const std::string_view kind = kind_of(j).name;
  report(where(j) / kind / side, "there is no body " + in_quotes(name) + instead(name, names));
  return std::numeric_limits<std::size_t>::max();
}

int Expansion::solid(const std::string& body) const {
  const auto found = body_of_.find(body);
  return solid_of_[found == body_of_.end() ? p_.bodies.size() : found->second];
}

std::size_t Expansion::add(Feature f) {
  if (const auto found = feature_of_.find(f.name); found != feature_of_.end()) return found->second;
  feature_of_.emplace(f.name, features_.size());
  features_.push_back(std::move(f));
  return features_.size() - 1;
}

void Expansion::place_features() {
  using Home = Feature::Home;
  for (const Point& p : p_.points) add({p.name, true, p.at, p.fixed, false, true, Home::scene});
  for (const Vector& v : p_.vectors) {
    if (v.unit) add({v.name, false, unit(v.at), v.fixed, false, true, Home::scene});
  }
  for (std::size_t i = 0; i < p_.bodies.size(); ++i) {
    const Body& b = p_.bodies[i];
    const int s = solid_of_[i];
    const auto take = [&](const Member& m, bool is_point) {
      Feature f{m.name, is_point, m.local, false, false, true, Home::member, kNobody, s};
      if (b.name == kGround) {
        f.fixed = true;
        f.home = Home::ground;
      } else if (has_base(b)) {
        f.solid = s;
        if (!m.in_ground && !to_ground(b, m, is_point, f.at)) return;
      } else if (!m.in_ground) {
        report(Where("/bodies") / b.name / (is_point ? "points" : "vectors") / m.name,
               "the body has no frame of its own; give ground coordinates of the posture as written, {\"at\": [...]}");
        return;
      } else {
        f.wanted = false;
        f.fixed = s == ground_;
      }
      if (!is_point) f.at = unit(f.at);
      put_on(s, add(std::move(f)));
    };
    for (const Member& m : b.points) take(m, true);
    for (const Member& m : b.vectors) take(m, false);
  }
  for (std::size_t i = 0; i < p_.bodies.size(); ++i) take_base(p_.bodies[i], solid_of_[i]);
}

void Expansion::take_base(const Body& b, int s) {
  if (!b.rigid.empty() && has_base(b)) {
    report(Where("/bodies") / b.name / "rigid", "a body with a base has no \"rigid\"; list members instead");
  }
  const auto take = [&](const std::string& name) {
    if (const auto found = feature_of_.find(name); found != feature_of_.end()) put_on(s, found->second);
  };
  for (const std::string& name : b.base) take(name);
  for (const std::string& name : b.frame) take(name);
  if (!b.origin.empty()) take(b.origin);
  for (std::size_t i = 0; i < b.rigid.size(); ++i) {
    const auto found = feature_of_.find(b.rigid[i]);
    if (found == feature_of_.end()) {
      report(Where("/bodies") / b.name / "rigid" / i, "there is no point or unit vector " + in_quotes(b.rigid[i]));
    } else {
      put_on(s, found->second);
    }
  }
}

bool Expansion::to_ground(const Body& b, const Member& m, bool is_point, Triple& out) const {
  const auto at = [&](const std::string& name) -> const Feature* {
    const auto found = feature_of_.find(name);
    return found == feature_of_.end() ? nullptr : &features_[found->second];
  };
  const Feature* origin = at(b.base.empty() ? b.origin : b.base[0]);
  if (origin == nullptr) return false;
  Triple x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  const auto way = [&](const std::string& name) {
    const Feature* f = at(name);
    return f == nullptr ? Triple{} : f->is_point ? minus(f->at, origin->at) : f->at;
  };
  if (b.base.size() > 1) x = unit(way(b.base[1]));
  if (!b.frame.empty()) x = unit(way(b.frame[0]));
  if (!in_space()) y = {-x[1], x[0], 0};
  if (b.base.size() > 2) z = unit(triple::cross(x, way(b.base[2]))), y = triple::cross(z, x);
  if (b.frame.size() == 3) y = unit(way(b.frame[1])), z = unit(way(b.frame[2]));
  const Triple turned = triple::add(triple::scale(m.local[0], x),
                                    triple::add(triple::scale(m.local[1], y), triple::scale(m.local[2], z)));
  out = is_point ? triple::add(origin->at, turned) : turned;
  return triple::is_finite(out);
}

}  // namespace assur::joints

namespace assur {

bool has_joints(const JointParts& parts) {
  if (parts.dimension != 2 && parts.dimension != 3) return false;
  const auto has_rigid = [](const Body& b) { return !b.rigid.empty(); };
  const auto is_gear = [](const Constraint& c) { return c.as<Gear>() != nullptr; };
  return !parts.joints.empty() || std::any_of(parts.bodies.begin(), parts.bodies.end(), has_rigid) ||
         std::any_of(parts.constraints.begin(), parts.constraints.end(), is_gear);
}

std::vector<Diagnostic> expand_joints(JointParts parts) { return joints::Expansion(parts).run(); }

}  // namespace assur
