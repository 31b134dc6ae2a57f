#include "scene/joints.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "decimal.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "scene/gear.hpp"
#include "scene/levels_of_unknowns.hpp"
#include "scene/names.hpp"
#include "scene/triple.hpp"

namespace assur {
namespace {

constexpr std::string_view kGround = "ground";
constexpr double kSame = 1e-9;           // relative: two places or directions are one
constexpr double kExactly = 16 * kEps;   // the same but for rounding
constexpr double kSquare = 1e-6;         // largest dot product of the axes of a universal joint, as of frames
constexpr double kWellApart = 0.1;       // sine of the angle between the directions of a good base
constexpr double kSomewhatApart = 1e-6;  // and of any base

constexpr int kNobody = -1;
constexpr Index kLast = std::numeric_limits<Index>::max();

Triple unit(const Triple& a) { return triple::scale(1 / triple::norm(a), a); }
Triple minus(const Triple& a, const Triple& b) { return triple::subtract(a, b); }
double sine(const Triple& a, const Triple& b) {
  return triple::norm(triple::cross(a, b)) / (triple::norm(a) * triple::norm(b));
}

template <class... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};
template <class... Visitors>
Overloaded(Visitors...) -> Overloaded<Visitors...>;

// A unit vector perpendicular to an axis and to the coordinate axis that is farthest from it.
Triple across(const Triple& axis, int dimension) {
  if (dimension == 2) return {1, 0, 0};
  std::size_t least = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    if (std::abs(axis[k]) < std::abs(axis[least])) least = k;
  }
  Triple e{};
  e[least] = 1;
  return unit(triple::cross(axis, e));
}

// A point or vector that may be shared by bodies. Until the bases are chosen, no body determines it.
struct Feature {
  enum class Home : std::uint8_t { nowhere, scene, ground, member };  // list in which it is declared now
  std::string name;
  bool is_point = true;
  Triple at{};
  bool fixed = false;
  bool driven = false;  // a driver determines it
  bool wanted = true;   // false: used in a base only if no other feature suffices
  Home home = Home::nowhere;
  int solid = kNobody;  // the solid whose member it is; kNobody: it has its own unknowns
  int from = kNobody;   // the solid whose member it was as written
  Index level = kLast;  // lowest level of the solids that have it
};

// Bodies that fixed joints connect: one rigid solid.
struct Solid {
  std::vector<std::size_t> bodies;  // indices; the ground may have none
  bool is_ground = false;
  int based = kNobody;                // the body that has a base of its own
  Index level = 0, turn_level = 0;    // of its position and of its rotation: others of higher levels follow from these
  std::vector<std::size_t> features;  // without repetition

  [[nodiscard]] bool is_rigid() const { return is_ground || based >= 0; }
  [[nodiscard]] Index level_of(const Feature& f) const { return f.is_point ? level : turn_level; }
};

// A joint that slides: a point of the second body on a line or plane of the first one.
struct Slide {
  const Joint* joint;
  int a, b;          // solids
  std::size_t axis;  // feature: along the line, or normal to the plane
  bool on_plane = false, turns = false;
  const Anchor* at = nullptr;
  std::size_t point = 0, origin = 0;  // features: on the second and on the first body
};

class Expansion {
 public:
  explicit Expansion(JointParts parts) : p_(parts) {}

  std::vector<Diagnostic> run() {
    const auto has_rigid = [](const Body& b) { return !b.rigid.empty(); };
    const auto is_gear = [](const Constraint& c) { return c.as<Gear>() != nullptr; };
    if (p_.joints.empty() && std::none_of(p_.bodies.begin(), p_.bodies.end(), has_rigid) &&
        std::none_of(p_.constraints.begin(), p_.constraints.end(), is_gear)) {
      return {};
    }
    if (p_.dimension != 2 && p_.dimension != 3) return {};
    index_names();
    make_solids();
    place_features();
    read_coordinates();
    share_features();
    if (!findings_.empty()) return give_up();
    place_slides();
    place_angles();
    share_sides();
    set_levels();
    for (std::size_t s = 0; s < solids_.size(); ++s) {
      if (solids_[s].is_rigid()) settle(s, own_base(s));
    }
    for (const std::size_t s : order()) choose_base(s);
    if (!findings_.empty()) return give_up();
    write();
    return {};
  }

 private:
  static bool has_base(const Body& b) {
    return b.name == kGround || !b.origin.empty() || !b.base.empty() || !b.frame.empty();
  }
  static Where where(const Joint& j) { return Where("/joints") / j.name; }
  void report(const Where& at, std::string what) { findings_.push_back({at.text(), std::move(what)}); }
  [[nodiscard]] bool in_space() const { return p_.dimension == 3; }

  // Bodies without a base must not be reported again.
  std::vector<Diagnostic> give_up() {
    for (const Body& b : p_.bodies) {
      if (!has_base(b)) findings_.push_back({"/bodies/" + b.name, ""});
    }
    return std::move(findings_);
  }

  // ---- names

  void index_names() {
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
        report(where(j),
               in_quotes(j.name) + " is the name of something else already; all kinds share one set of names");
      }
    }
  }

  // ---- solids

  void make_solids() {
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

  static std::pair<const std::string&, const std::string&> bodies_of(const Joint& j) {
    return std::visit(
        [](const auto& kind) { return std::pair<const std::string&, const std::string&>(kind.a, kind.b); }, j.kind);
  }

  // Index of a body, or of the ground. If the name is unknown, reports this and returns a larger number.
  std::size_t body(const Joint& j, const std::string& name, std::size_t side) {
    if (const auto found = body_of_.find(name); found != body_of_.end()) return found->second;
    if (name == kGround) return p_.bodies.size();
    std::vector<std::string_view> names;
    for (const Body& b : p_.bodies) names.push_back(b.name);
    names.push_back(kGround);
    const std::string_view kind = kind_of(j);
    report(where(j) / kind / side, "there is no body " + in_quotes(name) + known_instead(name, names));
    return std::numeric_limits<std::size_t>::max();
  }

  static std::string_view kind_of(const Joint& j) {
    static constexpr std::string_view kNames[] = {"revolute",  "prismatic", "cylindrical", "spherical",
                                                  "universal", "planar",    "fixed"};
    return kNames[j.kind.index()];
  }

  int solid(const std::string& body) const {
    const auto found = body_of_.find(body);
    return solid_of_[found == body_of_.end() ? p_.bodies.size() : found->second];
  }

  // ---- features

  std::size_t add(Feature f) {
    if (const auto found = feature_of_.find(f.name); found != feature_of_.end()) return found->second;
    feature_of_.emplace(f.name, features_.size());
    features_.push_back(std::move(f));
    return features_.size() - 1;
  }

  void put_on(int solid, std::size_t feature) {
    if (on_.emplace(solid, feature).second) solids_[idx(solid)].features.push_back(feature);
  }

  // What the scene has already: points, vectors, members.
  void place_features() {
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
                 "the body has no frame of its own; write the coordinates in the ground as written, {\"at\": [...]}");
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

  // Puts the base of a body, or its `rigid` items, on its solid.
  void take_base(const Body& b, int s) {
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

  // Ground coordinates of a member of a body whose base is declared in the scene; false if they are not known yet.
  bool to_ground(const Body& b, const Member& m, bool is_point, Triple& out) const {
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

  // ---- features that joints share

  // The feature of an anchor, on one or two solids. name: name of a new feature.
  std::size_t anchor(const Joint& j, std::string_view key, const Anchor& a, bool is_point, std::string name,
                     std::initializer_list<int> solids) {
    std::size_t feature = 0;
    const Where here = where(j) / key;
    if (const auto* given = std::get_if<std::string>(&a)) {
      const auto found = feature_of_.find(*given);
      if (found == feature_of_.end() || features_[found->second].is_point != is_point) {
        std::vector<std::string_view> names;
        for (const Feature& f : features_) {
          if (f.is_point == is_point) names.push_back(f.name);
        }
        report(here, std::string("there is no ") + (is_point ? "point " : "unit vector ") + in_quotes(*given) +
                         known_instead(*given, names));
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
        report(here, std::string(key == "normal" ? "the normal" : "the axis") +
                         " is zero or missing; give a direction, e.g. [0, 0, 1]");
        at = {1, 0, 0};
      } else if (!in_space() && at[2] != 0) {
        report(here, "a plane scene has no z; write 0 or leave it out");
      }
      feature = add({std::move(name), is_point, is_point ? at : unit(at)});
    }
    for (const int s : solids) share(j, here, s, feature);
    return feature;
  }

  void share(const Joint& j, const Where& here, int s, std::size_t feature) {
    Feature& f = features_[feature];
    if (s == ground_ && !f.fixed && f.home == Feature::Home::scene) {
      report(here, in_quotes(f.name) + " is not fixed, but joint " + in_quotes(j.name) + " connects it to the ground");
    }
    f.fixed = f.fixed || (s == ground_ && f.solid == kNobody);
    put_on(s, feature);
    put_there_by_.emplace(std::pair(s, feature), &j);
  }

  void share_features() {
    for (const Joint& j : p_.joints) {
      const auto [a, b] = bodies_of(j);
      if (body_of_.count(a) + body_of_.count(b) + (a == kGround) + (b == kGround) < 2) continue;
      const int sa = solid(a), sb = solid(b);
      if (sa == sb && a != b && !std::holds_alternative<Fixed>(j.kind)) {
        report(where(j), in_quotes(a) + " and " + in_quotes(b) + " are fixed to each other; remove this joint");
      }
      if (sa == sb) continue;
      const bool for_space = j.kind.index() != 0 && j.kind.index() != 1 && !std::holds_alternative<Fixed>(j.kind);
      if (!in_space() && for_space) {
        report(where(j) / kind_of(j),
               std::string(kind_of(j)) + " joints are for 3D; in the plane there are revolute, prismatic and fixed");
        continue;
      }
      std::visit([&](const auto& kind) { share(j, kind, sa, sb); }, j.kind);
    }
  }

  void share(const Joint& j, const Revolute& r, int a, int b) {
    anchor(j, "at", r.at, true, j.name, {a, b});
    const auto* axis = std::get_if<Triple>(&r.axis);
    if (in_space()) {
      axis_of_[&j] = anchor(j, "axis", r.axis, false, j.name + ".axis", {a, b});
    } else if (axis == nullptr || *axis != Triple{}) {
      report(where(j) / "axis", "in the plane every axis is the normal; leave \"axis\" out");
    }
  }
  void share(const Joint& j, const Prismatic& r, int a, int b) {
    axis_of_[&j] = anchor(j, "axis", r.axis, false, j.name + ".axis", {a, b});
    slides_.push_back({&j, a, b, axis_of_[&j]});
  }
  void share(const Joint& j, const Cylindrical& r, int a, int b) {
    axis_of_[&j] = anchor(j, "axis", r.axis, false, j.name + ".axis", {a, b});
    slides_.push_back({&j, a, b, axis_of_[&j], false, true, &r.at});
  }
  void share(const Joint& j, const Spherical& r, int a, int b) { anchor(j, "at", r.at, true, j.name, {a, b}); }
  void share(const Joint& j, const Universal& r, int a, int b) {
    anchor(j, "at", r.at, true, j.name, {a, b});
    const std::size_t d = anchor(j, "axes/0", r.axis_a, false, j.name + ".axis_a", {a});
    const std::size_t e = anchor(j, "axes/1", r.axis_b, false, j.name + ".axis_b", {b});
    const double cosine = triple::dot(features_[d].at, features_[e].at);
    if (d == e || !(std::abs(cosine) <= kSquare)) {
      report(where(j) / "axes", "the axes have the dot product " + general(cosine, 6) +
                                    "; those of a universal joint are at right angles");
    }
    crossings_.push_back({&j, d, e});
  }
  void share(const Joint& j, const Planar& r, int a, int b) {
    const std::size_t n = anchor(j, "normal", r.normal, false, j.name + ".normal", {a, b});
    slides_.push_back({&j, a, b, n, true, true});
  }
  void share(const Joint&, const Fixed&, int, int) {}

  // ---- sliding

  [[nodiscard]] bool is_same(const Triple& a, const Triple& b, double share = kSame) const {
    return triple::norm(minus(a, b)) <= share * std::max(triple::norm(a), triple::norm(b));
  }
  [[nodiscard]] bool is_on_line(const Feature& f, const Triple& at, const Triple& axis, double share = kSame) const {
    if (!f.is_point) return sine(f.at, axis) <= share;
    const Triple off = minus(f.at, at);
    return triple::norm(off) == 0 ||
           triple::norm(triple::cross(off, axis)) <= share * std::max(triple::norm(off), triple::norm(f.at));
  }

  // The sliding point belongs to the second body; takes an existing point if possible.
  void place_slides() {
    for (Slide& s : slides_) {
      const Joint& j = *s.joint;
      const Triple axis = features_[s.axis].at;
      Solid& second = solids_[idx(s.b)];
      std::size_t given = features_.size();
      Triple at{};
      if (s.at != nullptr) {
        given = anchor(j, "at", *s.at, true, j.name, {});
        at = features_[given].at;
      }
      const auto serves = [&](std::size_t i) {
        const Feature& f = features_[i];
        return f.is_point && f.wanted && (s.at == nullptr || is_on_line(f, at, axis));
      };
      const auto own = std::find_if(second.features.begin(), second.features.end(), serves);
      if (own != second.features.end()) {
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

  // A prismatic joint keeps a second direction, unless nothing depends on it: a body whose features are all on the line
  // of the joint may turn, if it does not lead the turn of one body to another.
  void share_sides() {
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
    const auto keeps_direction = [&](const Slide& s) { return !s.turns && in_space(); };
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
    for (const Slide& s : slides_) {
      if (!keeps_direction(s)) continue;
      const bool a = is_rod(s, s.a), b = is_rod(s, s.b);
      if ((!a && !b) || ends[root(a ? s.a : s.b)].size() > 1) sided.push_back(&s);
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
      share(*s.joint, where(*s.joint), s.a, shared);
      share(*s.joint, where(*s.joint), s.b, shared);
    }
  }

  // ---- coordinates

  struct Coordinate {
    const Joint* joint = nullptr;
    bool is_angle = false;
  };

  // "J.angle", "J.displacement", also with ".rate" and the like; null joint: the text names no coordinate of a joint.
  Coordinate coordinate(const std::string& text, const Where& at) {
    const std::size_t dot = text.find('.');
    if (dot == std::string::npos) return {};
    const std::string name = text.substr(0, dot);
    const auto found = joint_of_.find(name);
    if (found == joint_of_.end()) return {};
    const Joint* const j = found->second;
    const std::string part = text.substr(dot + 1, text.find('.', dot + 1) - dot - 1);
    if (part != "angle" && part != "displacement") return {};
    const bool angle = part == "angle", cylinder = std::holds_alternative<Cylindrical>(j->kind);
    const bool has = angle ? cylinder || std::holds_alternative<Revolute>(j->kind)
                           : cylinder || std::holds_alternative<Prismatic>(j->kind);
    if (!has) {
      report(at, "joint " + in_quotes(name) + " is " + std::string(kind_of(*j)) + " and has no " + part);
      return {};
    }
    return {j, angle};
  }

  struct Geared {
    std::size_t constraint;
    std::array<Coordinate, 2> sides;
    double ratio;
  };

  void read_coordinates() {
    for (Driver& d : p_.drivers) {
      if (const auto* c = std::get_if<DrivenCoordinate>(&d.kind)) {
        const Where here = Where("/drivers") / d.name;
        const Coordinate of = coordinate(c->coordinate, here / "coordinate");
        if (of.joint != nullptr) driven_.emplace_back(&d, of);
      }
    }
    for (Measure& m : p_.measures) {
      if (const auto* c = std::get_if<MeasuredCoordinate>(&m.kind)) {
        const Coordinate of = coordinate(c->coordinate, Where("/measures") / m.name / "coordinate");
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
  }

  void read_gear(std::size_t constraint, const Gear& gear) {
    const Where here = Where("/constraints") / p_.constraints[constraint].name;
    Geared g{constraint, {}, gear.ratio};
    for (std::size_t side = 0; side < 2; ++side) {
      const std::string& name = side == 0 ? gear.a : gear.b;
      const std::size_t before = findings_.size();
      g.sides[side] = coordinate(name, here / "gear" / side);
      const bool is_part = name.find('.') != name.rfind('.');
      if (g.sides[side].joint != nullptr && !is_part) continue;
      if (findings_.size() == before) {
        report(here / "gear" / side,
               in_quotes(name) + " is no coordinate of a joint; write JOINT.angle or JOINT.displacement");
      }
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

  // A joint of the ground turns an arm: then the driver determines the whole body. Any other angle is one between two
  // directions.
  void place_angles() {
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

  void drive_angle(const Driver& d, const Joint& j) {
    const auto* r = std::get_if<Revolute>(&j.kind);
    const auto [a, b] = bodies_of(j);
    Solid& turned = solids_[idx(solid(b))];
    if (r == nullptr || solid(a) != ground_ || turned.is_rigid()) return (void)between(j);
    const std::size_t centre = point_of(*r, j);
    const Triple at = features_[centre].at, axis = in_space() ? features_[axis_of_.at(&j)].at : Triple{0, 0, 1};
    const auto serves = [&](std::size_t i) {
      const Feature& f = features_[i];
      return f.is_point && !f.fixed && !f.driven && f.solid == kNobody && !is_same(f.at, at) &&
             !is_on_line(f, at, axis);
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

  [[nodiscard]] std::size_t point_of(const Revolute& r, const Joint& j) const {
    const auto* given = std::get_if<std::string>(&r.at);
    return feature_of_.at(given != nullptr ? *given : j.name);
  }

  // A typical length of the mechanism: the median of distances from here.
  [[nodiscard]] double arm_length(const Triple& at) const {
    std::vector<double> lengths;
    for (const Feature& f : features_) {
      if (f.is_point && !is_same(f.at, at)) lengths.push_back(triple::norm(minus(f.at, at)));
    }
    if (lengths.empty()) return 1;
    std::nth_element(lengths.begin(), lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2), lengths.end());
    return lengths[lengths.size() / 2];
  }

  // A direction across the axis, if possible along two points of the body.
  [[nodiscard]] Triple arm_direction(int solid, const Triple& axis) const {
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

  // A direction on each body; the two coincide in the posture as written.
  void between(const Joint& j) {
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

  // ---- bases

  // Solids that can be solved first come first, so that no base consists of members that are solved later. Among these,
  // solids with many features come first, because their neighbours use these members.
  [[nodiscard]] std::vector<std::size_t> order() const {
    std::vector<std::size_t> all;
    for (std::size_t s = 0; s < solids_.size(); ++s) {
      if (!solids_[s].is_rigid() && !solids_[s].bodies.empty()) all.push_back(s);
    }
    const auto moving = [&](std::size_t s) {
      return std::count_if(solids_[s].features.begin(), solids_[s].features.end(),
                           [&](std::size_t f) { return !features_[f].fixed && features_[f].wanted; });
    };
    std::vector<std::pair<Index, std::ptrdiff_t>> key(solids_.size());
    for (const std::size_t s : all) key[s] = {solids_[s].level, -moving(s)};
    std::stable_sort(all.begin(), all.end(), [&](std::size_t a, std::size_t b) { return key[a] < key[b]; });
    return all;
  }

  // Number of rotations in space that anything depends on: fewer than 3 if all features are on one line.
  [[nodiscard]] Index turns_of(const Solid& s) const {
    if (s.is_rigid()) return 3;
    const auto point =
        std::find_if(s.features.begin(), s.features.end(), [&](std::size_t i) { return features_[i].is_point; });
    if (point == s.features.end()) return 3;
    const Triple at = features_[*point].at;
    std::optional<Triple> along;
    for (const std::size_t i : s.features) {
      const Feature& f = features_[i];
      if (f.is_point && is_same(f.at, at)) continue;
      const Triple way = f.is_point ? unit(minus(f.at, at)) : f.at;
      if (!along) along = way;
      if (!is_on_line(f, at, *along)) return 3;
    }
    return along ? 2 : 0;
  }

  // Sets the levels of solids, from a graph of their freedoms, first translations, then rotations. Points and vectors
  // that belong to no solid have freedoms, too. A joint reads those of both its bodies.
  void set_levels() {
    const Index along = p_.dimension, turns = in_space() ? 3 : 1;
    std::vector<std::vector<Index>> equations;
    std::vector<Index> first(solids_.size()), end(solids_.size()), of_feature(features_.size(), kNobody);
    Index unknowns = 0;
    for (std::size_t s = 0; s < solids_.size(); ++s) {
      first[s] = unknowns;
      if (!solids_[s].is_ground) unknowns += along + (in_space() ? turns_of(solids_[s]) : turns);
      end[s] = unknowns;
      for (const std::size_t f : solids_[s].features) {
        if (of_feature[f] == kNobody || solids_[s].is_ground) of_feature[f] = static_cast<Index>(s);
      }
    }
    std::map<std::size_t, Index> loose;  // features: first unknown
    const auto read_solid = [&](std::vector<Index>& reads, int s, bool turns_only) {
      if (solids_[idx(s)].is_ground) return;
      for (Index u = first[idx(s)] + (turns_only ? along : 0); u < end[idx(s)]; ++u) reads.push_back(u);
    };
    const auto require = [&](Index count, const std::vector<Index>& reads) {
      if (!reads.empty()) equations.insert(equations.end(), idx(count), reads);
    };
    const auto connect = [&](const Joint& j, Index count, bool turns_only) {
      const auto [a, b] = bodies_of(j);
      std::vector<Index> reads;
      read_solid(reads, solid(a), turns_only), read_solid(reads, solid(b), turns_only);
      require(count, reads);
    };
    for (const Joint& j : p_.joints) {
      // Equations of translations and rotations in space, in the order of the kinds.
      static constexpr std::pair<Index, Index> kCounts[] = {{3, 2}, {2, 3}, {2, 2}, {3, 0}, {3, 1}, {1, 2}, {0, 0}};
      const bool slides = std::holds_alternative<Prismatic>(j.kind), fixes = std::holds_alternative<Fixed>(j.kind);
      auto [ways, angles] = in_space() ? kCounts[j.kind.index()]
                            : slides   ? std::pair<Index, Index>{1, 1}
                            : fixes    ? std::pair<Index, Index>{0, 0}
                                       : std::pair<Index, Index>{2, 0};
      const auto [a, b] = bodies_of(j);
      const auto is_rod = [&](const std::string& body) { return turns_of(solids_[idx(solid(body))]) < turns; };
      if (in_space() && slides && (is_rod(a) || is_rod(b))) angles = 2;  // see share_sides()
      connect(j, angles, true), connect(j, ways, false);
    }
    // `name`: of a point or vector, also with a coordinate, or the displacement of a joint.
    const auto read = [&](std::vector<Index>& reads, const std::string& name) {
      if (const auto j = joint_of_.find(name.substr(0, name.find('.')));
          j != joint_of_.end() && name.find(".slide.") != std::string::npos) {
        const auto [a, b] = bodies_of(*j->second);
        return read_solid(reads, solid(a), false), read_solid(reads, solid(b), false);
      }
      const auto found = feature_of_.find(name.substr(0, name.find('.')));
      if (found == feature_of_.end() || features_[found->second].fixed) return;
      const Feature& f = features_[found->second];
      if (const Index s = of_feature[found->second]; s != kNobody) return read_solid(reads, s, !f.is_point);
      const auto [at, is_new] = loose.emplace(found->second, unknowns);
      if (is_new) unknowns += along;
      for (Index k = 0; k < along; ++k) reads.push_back(at->second + k);
      if (is_new && !f.is_point) require(1, reads);
    };
    const auto require_of = [&](Index count, std::initializer_list<const std::string*> names) {
      std::vector<Index> reads;
      for (const std::string* name : names) read(reads, *name);
      require(count, reads);
    };
    for (const Constraint& c : p_.constraints) {
      c.visit(Overloaded{[&](const Distance& k) {
                           require_of(1, {&k.p, &k.q});
                         },
                         [&](const EqualDistance& k) {
                           require_of(1, {&k.p, &k.q, &k.r, &k.s});
                         },
                         [&](const Dot& k) {
                           require_of(1, {&k.d.first, &k.d.second, &k.e.first, &k.e.second});
                         },
                         [&](const Parallel& k) {
                           require_of(along - 1, {&k.d.first, &k.d.second, &k.e.first, &k.e.second});
                         },
                         [&](const Linear& k) {
                           std::vector<Index> reads;
                           for (const auto& term : k.terms) read(reads, term.first);
                           require(along, reads);
                         },
                         [&](const FixedCoordinate& k) { require_of(1, {&k.coordinate}); },
                         [&](const OnLine& k) {
                           require_of(along - 1, {&k.p, &k.a, &k.d.first, &k.d.second});
                         },
                         [&](const OnPlane& k) {
                           require_of(along - 2, {&k.p, &k.a, &k.d.first, &k.d.second, &k.e.first, &k.e.second});
                         },
                         [&](const Gear&) {},  // below
                         [&](const Callback& k) {
                           std::vector<Index> reads;
                           for (const std::string& name : k.coordinates) read(reads, name);
                           require(k.equations, reads);
                         }});
    }
    for (const Geared& g : geared_) {
      std::vector<Index> reads;
      for (const Coordinate& side : g.sides) {
        const auto [a, b] = bodies_of(*side.joint);
        read_solid(reads, solid(a), side.is_angle), read_solid(reads, solid(b), side.is_angle);
      }
      require(1, reads);
    }
    std::set<const Driver*> of_joints;
    for (const auto& [driver, of] : driven_) {
      of_joints.insert(driver);
      connect(*of.joint, 1, of.is_angle);
    }
    for (const Driver& d : p_.drivers) {
      std::visit(Overloaded{[&](const PointAngle& k) {
                              require_of(1, {&k.a, &k.b});
                            },
                            [&](const RelativeAngle& k) {
                              require_of(1, {&k.d.first, &k.d.second, &k.e.first, &k.e.second});
                            },
                            [&](const DrivenDistance& k) {
                              require_of(1, {&k.a, &k.b});
                            },
                            [&](const DrivenCoordinate& k) {
                              if (of_joints.count(&d) == 0) require_of(1, {&k.coordinate});
                            },
                            [&](const Pose& k) {
                              std::vector<Index> reads;
                              if (body_of_.count(k.body) != 0) read_solid(reads, solid(k.body), false);
                              require(along + turns, reads);
                            }},
                 d.kind);
    }
    const std::vector<Index> level = levels_of_unknowns(unknowns, equations);
    for (std::size_t s = 0; s < solids_.size(); ++s) {
      if (solids_[s].is_ground) continue;
      const auto own = level.begin() + first[s], last = level.begin() + end[s];
      solids_[s].level = *std::max_element(own, last);
      solids_[s].turn_level = last == own + along ? 0 : *std::max_element(own + along, last);
    }
    for (const Solid& s : solids_) {
      for (const std::size_t f : s.features)
        features_[f].level = std::min(features_[f].level, s.level_of(features_[f]));
    }
  }

  // Features that are known before the solid come first.
  [[nodiscard]] static int rank(const Feature& f, const Solid& s) {
    return f.fixed ? 0 : f.driven ? 1 : f.level < s.level_of(f) ? 2 : f.solid != kNobody ? 3 : f.wanted ? 4 : 5;
  }

  void choose_base(std::size_t s) {
    Solid& solid = solids_[s];
    std::vector<std::size_t> all = solid.features;
    std::stable_sort(all.begin(), all.end(), [&](std::size_t a, std::size_t b) {
      return rank(features_[a], solid) < rank(features_[b], solid);
    });
    const auto first = std::find_if(all.begin(), all.end(), [&](std::size_t i) { return features_[i].is_point; });
    Body& body = p_.bodies[solid.bodies.front()];
    if (first == all.end()) {
      report(Where("/bodies") / body.name,
             "no joint places this body; a body needs a base, joints, or \"rigid\" points");
      return;
    }
    base_.emplace(s, std::vector<std::size_t>{*first});
    std::vector<std::size_t>& base = base_.at(s);
    const Triple origin = features_[*first].at;
    const auto way = [&](std::size_t i) {
      const Feature& f = features_[i];
      return f.is_point ? minus(f.at, origin) : f.at;
    };
    const auto is_distinct = [&](std::size_t i) {
      return i != base[0] && (!features_[i].is_point || !is_same(features_[i].at, origin));
    };
    const auto second = std::find_if(all.begin(), all.end(), is_distinct);
    if (second != all.end()) base.push_back(*second);
    if (in_space() && base.size() == 2) {
      const Triple along = way(base[1]);
      const auto apart = [&](std::size_t i) { return is_distinct(i) ? sine(along, way(i)) : 0; };
      auto third = std::find_if(all.begin(), all.end(), [&](std::size_t i) { return apart(i) > kWellApart; });
      if (third == all.end()) {
        third =
            std::max_element(all.begin(), all.end(), [&](std::size_t i, std::size_t k) { return apart(i) < apart(k); });
        if (!(apart(*third) > kSomewhatApart)) third = all.end();
      }
      if (third != all.end()) base.push_back(*third);
    }
    settle(s, base);
  }

  // The base of a body whose base the scene declares.
  [[nodiscard]] std::vector<std::size_t> own_base(std::size_t s) const {
    std::vector<std::size_t> base;
    if (solids_[s].based < 0) return base;
    const Body& b = p_.bodies[idx(solids_[s].based)];
    const auto take = [&](const std::string& name) {
      if (const auto found = feature_of_.find(name); found != feature_of_.end()) base.push_back(found->second);
    };
    if (!b.origin.empty()) take(b.origin);
    std::for_each(b.frame.begin(), b.frame.end(), take);
    std::for_each(b.base.begin(), b.base.end(), take);
    return base;
  }

  // The other features of a solid become its members. A feature that is known, or a
  // member of another solid, gets a copy that a constraint ties to it.
  void settle(std::size_t s, const std::vector<std::size_t>& base) {
    const int self = static_cast<int>(s);
    based_on_[self] = base;
    for (const std::size_t i : solids_[s].features) {
      Feature& f = features_[i];
      if (std::find(base.begin(), base.end(), i) != base.end() || f.solid == self) continue;
      if (self == ground_ && f.fixed) continue;
      if (f.fixed && rests(base, f, kSame)) continue;
      if (f.solid == kNobody && !f.driven && rests(base, f, kExactly)) {
        f.fixed = true;
        continue;
      }
      const bool is_free = !f.fixed && !f.driven && f.solid == kNobody && f.level >= solids_[s].level_of(f);
      if (self != ground_ && is_free && may_determine(self, i)) {
        f.solid = self;
      } else {
        ties_.push_back({i, self});
      }
    }
  }

  // True if the body cannot move this feature: it lies on an axis of the ground.
  [[nodiscard]] bool rests(const std::vector<std::size_t>& base, const Feature& f, double share) const {
    if (base.empty() || !features_[base[0]].fixed) return false;
    const Feature& origin = features_[base[0]];
    if (f.is_point && is_same(f.at, origin.at, share)) return true;
    if (base.size() < 2 || !features_[base[1]].fixed) return false;
    const Feature& second = features_[base[1]];
    return is_on_line(f, origin.at, second.is_point ? unit(minus(second.at, origin.at)) : second.at, share);
  }

  // False if a solid that stands on this feature determines, perhaps through others, the base of this solid.
  [[nodiscard]] bool may_determine(int solid, std::size_t feature) const {
    std::vector<int> path = {solid};
    std::set<int> seen = {solid};
    while (!path.empty()) {
      const auto at = based_on_.find(path.back());
      path.pop_back();
      if (at == based_on_.end()) continue;
      for (const std::size_t i : at->second) {
        if (i == feature) return false;
        const int owner = features_[i].solid;
        if (owner != kNobody && seen.insert(owner).second) path.push_back(owner);
      }
    }
    return true;
  }

  // ---- the new lists

  void write() {
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
    for (std::size_t t = 0; t < ties_.size(); ++t) tie(t, points, vectors);
    for (std::size_t s = 0; s < solids_.size(); ++s) set_base(s, still);
    for (Body& b : p_.bodies) {
      for (Member& m : points[b.name]) b.points.push_back(std::move(m));
      for (Member& m : vectors[b.name]) b.vectors.push_back(std::move(m));
    }
    std::erase_if(p_.bodies, [&](const Body& b) { return gone_.count(b.name) != 0; });
    for (const Slide& s : slides_) write(s);
    for (const auto& [j, d, e] : crossings_) {
      p_.constraints.push_back({j->name + ".cross", Dot{features_[d].name, features_[e].name, 0.0}});
    }
    write_coordinates();
  }

  void declare(const Feature& f) {
    if (f.is_point) {
      p_.points.push_back({f.name, f.at, f.fixed});
    } else {
      p_.vectors.push_back({f.name, f.at, f.fixed, true});
    }
  }

  struct Tie {
    std::size_t feature;
    int solid;
  };

  void tie(std::size_t t, std::map<std::string, std::vector<Member>>& points,
           std::map<std::string, std::vector<Member>>& vectors) {
    const Feature& f = features_[ties_[t].feature];
    const Solid& solid = solids_[idx(ties_[t].solid)];
    const auto by = put_there_by_.find({ties_[t].solid, ties_[t].feature});
    const std::size_t b = solid.based >= 0 ? idx(solid.based) : solid.bodies.empty() ? 0 : solid.bodies.front();
    const std::string stem = by != put_there_by_.end() ? by->second->name : p_.bodies[b].name;
    const std::string copy = stem + ".copy" + std::to_string(t);
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

  void set_base(std::size_t s, const std::set<std::string>& still) {
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
      if (based == nullptr) p_.without_frame.push_back(body.name);
      body.rigid.clear();
      const auto is_elsewhere = [&](const Member& m) { return still.count(m.name) == 0; };
      std::erase_if(body.points, is_elsewhere);
      std::erase_if(body.vectors, is_elsewhere);
      if (based != nullptr) {
        body.origin = based->origin, body.frame = based->frame, body.base = based->base;
      } else if (base.size() > 1) {
        body.base = base;
        if (in_space() && base.size() == 2) {
          p_.warnings.push_back({"/bodies/" + body.name,
                                 "the body may turn about the line through " + in_quotes(base[0]) +
                                     (features_[base_.at(s)[1]].is_point ? " and " : " along ") + in_quotes(base[1]) +
                                     "; nothing depends on this turn, and it is not computed"});
        }
      } else {
        gone_.insert(body.name);
        p_.warnings.push_back({"/bodies/" + body.name, "the body may turn about " + in_quotes(base[0]) +
                                                           "; nothing depends on this turn, and it is not computed"});
      }
    }
  }

  void write(const Slide& s) {
    const std::string &point = features_[s.point].name, &origin = features_[s.origin].name,
                      &axis = features_[s.axis].name;
    if (s.on_plane) {
      p_.constraints.push_back({s.joint->name + ".slide", Dot{Direction(origin, point), axis, 0.0}});
    } else {
      p_.constraints.push_back({s.joint->name + ".slide", OnLine{point, origin, axis}});
    }
  }

  void write_coordinates() {
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

  JointParts p_;
  std::vector<Diagnostic> findings_;
  std::map<std::string, std::size_t, std::less<>> body_of_;
  std::unordered_map<std::string, const Joint*> joint_of_;
  std::vector<Solid> solids_;
  std::vector<int> solid_of_;  // bodies, then the ground
  int ground_ = kNobody;
  std::vector<Feature> features_;
  std::unordered_map<std::string, std::size_t> feature_of_;
  std::set<std::pair<int, std::size_t>> on_;                          // solid, feature
  std::map<std::pair<int, std::size_t>, const Joint*> put_there_by_;  // the same
  std::map<const Joint*, std::size_t> axis_of_;
  std::vector<Slide> slides_;
  struct Crossing {
    const Joint* joint;
    std::size_t d, e;
  };
  std::vector<Crossing> crossings_;
  std::vector<std::pair<Driver*, Coordinate>> driven_;
  std::vector<std::pair<Measure*, Coordinate>> measured_;
  std::vector<Geared> geared_;
  std::set<std::string> asked_;
  std::map<const Driver*, std::pair<std::size_t, std::size_t>> arms_;  // features: centre, end
  std::map<std::size_t, std::vector<std::size_t>> base_;               // of solids: features
  std::map<int, std::vector<std::size_t>> based_on_;                   // of all settled solids: features
  std::vector<Tie> ties_;
  std::set<std::string> gone_;  // bodies that have no motion of their own, or none that is computed
};

}  // namespace

std::vector<Diagnostic> expand_joints(JointParts parts) { return Expansion(parts).run(); }

}  // namespace assur
