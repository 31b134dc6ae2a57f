// The expansion of joints, in the files of this folder.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "index.hpp"
#include "joints/joints.hpp"
#include "numbers.hpp"
#include "scene/names.hpp"
#include "scene/symbols.hpp"
#include "scene/triple.hpp"

namespace assur::joints {

inline constexpr std::string_view kGround = "ground";
inline constexpr double kSame = 1e-9;           // relative: two places or directions are one
inline constexpr double kExactly = 16 * kEps;   // relative: equal except for rounding
inline constexpr double kSquare = 1e-6;         // largest dot product of the axes of a universal joint, as of frames
inline constexpr double kWellApart = 0.1;       // sine of the angle between the directions of a good base
inline constexpr double kSomewhatApart = 1e-6;  // and of any base

inline constexpr std::size_t kSearched = 1000;  // features of a body among which one is looked for, or a length sampled

inline constexpr int kNobody = -1;  // no solid
inline constexpr Index kLast = std::numeric_limits<Index>::max();

using triple::unit;
inline Triple minus(const Triple& a, const Triple& b) { return triple::subtract(a, b); }
inline Number sine(const Triple& a, const Triple& b) {
  return triple::norm(triple::cross(a, b)) / (triple::norm(a) * triple::norm(b));
}

template <class... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};
template <class... Visitors>
Overloaded(Visitors...) -> Overloaded<Visitors...>;

// A unit vector perpendicular to an axis and to the coordinate axis that is farthest from it.
inline Triple across(const Triple& axis, int dimension) {
  if (dimension == 2) return {1, 0, 0};
  std::size_t least = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    if (abs(axis[k]) < abs(axis[least])) least = k;
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
  bool wanted = true;   // false: used in a base only if other features do not suffice
  Home home = Home::nowhere;
  int solid = kNobody;  // the solid whose member it is; kNobody: it has its own unknowns
  int from = kNobody;   // the solid whose member it was as written
  Index level = kLast;  // lowest level of the solids that have it
  bool slides = false;  // the direction of a line along which a body slides
};

// Bodies that fixed joints connect: one rigid solid.
struct Solid {
  std::vector<std::size_t> bodies;  // indices; the ground may have none
  bool is_ground = false;
  int based = kNobody;                // the body that has a base of its own
  Index level = 0, turn_level = 0;    // of its position and of its rotation; its features can have lower levels
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

// The steps of expand_joints(), in the order of run(). Each section is a file of this folder.
class Expansion {
 public:
  explicit Expansion(JointParts parts) : p_(parts), known_(parts.found) {}
  std::vector<Diagnostic> run();

 private:
  static bool has_base(const Body& b) {
    return b.name == kGround || !b.origin.empty() || !b.base.empty() || !b.frame.empty();
  }
  static Where where(const Joint& j) { return Where("/joints") / j.name; }
  // The end of a message about an unknown name. Only the first messages have one: it compares all names.
  std::string instead(std::string_view word, const std::vector<std::string_view>& names) {
    return suggestions_left_-- > 0 ? known_instead(word, names) : "";
  }
  void report(const Where& at, std::string what);
  [[nodiscard]] bool in_space() const { return p_.dimension == 3; }
  // Bodies without a base must not be reported again.
  std::vector<Diagnostic> give_up();

  // ---- names (expansion.cpp)
  void index_names();

  // ---- solids (expansion.cpp)
  void make_solids();
  static std::pair<const std::string&, const std::string&> bodies_of(const Joint& j);
  // Index of a body, or of the ground. If the name is unknown, reports this and returns a larger number.
  std::size_t body(const Joint& j, const std::string& name, std::size_t side);
  int solid(const std::string& body) const;

  // ---- features (expansion.cpp)
  std::size_t add(Feature f);
  void put_on(int solid, std::size_t feature) {
    if (on_.emplace(solid, feature).second) solids_[idx(solid)].features.push_back(feature);
  }
  // Adds the points, vectors and members of the scene.
  void place_features();
  // Puts the base or the `rigid` items of a body on its solid.
  void take_base(const Body& b, int s);
  // Ground coordinates of a member of a body whose base is declared in the scene; false if they are not known yet.
  bool to_ground(const Body& b, const Member& m, bool is_point, Triple& out) const;

  // ---- features that joints share (joint_features.cpp)
  // The feature of an anchor at a place of the scene, on one or two solids. name: name of a new feature.
  std::size_t anchor(const Joint& j, const Where& here, const Anchor& a, bool is_point, std::string name,
                     std::initializer_list<int> solids);
  void share(const Joint& j, const Where& here, int s, std::size_t feature);
  void share_features();
  void share(const Joint& j, const Revolute& r, int a, int b);
  void share(const Joint& j, const Prismatic& r, int a, int b);
  void share(const Joint& j, const Cylindrical& r, int a, int b);
  void share(const Joint& j, const Spherical& r, int a, int b) {
    anchor(j, where(j) / "at", r.at, true, j.name, {a, b});
  }
  void share(const Joint& j, const Universal& r, int a, int b);
  void share(const Joint& j, const Planar& r, int a, int b);
  void share(const Joint&, const Fixed&, int, int) {}

  // ---- sliding (joint_features.cpp)
  [[nodiscard]] bool is_same(const Triple& a, const Triple& b, double share = kSame) const {
    return triple::norm(minus(a, b)) <= share * std::max(triple::norm(a), triple::norm(b));
  }
  [[nodiscard]] bool is_on_line(const Feature& f, const Triple& at, const Triple& axis, double share = kSame) const;
  // The sliding point belongs to the second body; takes an existing point if possible.
  void place_slides();
  // True if fixed joints connect both bodies of a joint.
  [[nodiscard]] bool is_held(const Joint& j) const {
    const auto [a, b] = bodies_of(j);
    return solid(a) == solid(b);
  }
  // Reports a driver or gear of a joint that other joints lock.
  void check_slides();
  [[nodiscard]] bool is_locked(const Slide& s) const {
    return s.a == s.b || (features_[s.point].fixed && features_[s.origin].fixed && features_[s.axis].fixed);
  }
  // Gives the bodies of prismatic joints a common second direction, which keeps them from turning. A rod, whose
  // features all lie on the line of the joint, needs none unless other bodies turn with it.
  void share_sides();

  // ---- coordinates (coordinates.cpp)
  struct Coordinate {
    const Joint* joint = nullptr;
    bool is_angle = false;
  };
  // "J.angle", "J.displacement", also with ".rate" and the like; null joint: the text names no coordinate of a joint.
  Coordinate coordinate(const std::string& text, const Where& at);
  // The same for drivers and measures, which may also name a coordinate of the point J.
  Coordinate scalar(const std::string& text, const Where& at);
  struct Geared {
    std::size_t constraint;
    std::array<Coordinate, 2> sides;
    double ratio;
  };
  void read_coordinates();
  void read_gear(std::size_t constraint, const Gear& gear);
  void read_limits();
  // A joint of the ground turns an arm: then the driver determines the whole body. Any other angle is one between two
  // directions.
  void place_angles();
  void drive_angle(const Driver& d, const Joint& j);
  [[nodiscard]] std::size_t point_of(const Revolute& r, const Joint& j) const;
  // A typical length of the mechanism: the median of distances from here.
  [[nodiscard]] Number arm_length(const Triple& at) const;
  // A direction across the axis, if possible along two points of the body.
  [[nodiscard]] Triple arm_direction(int solid, const Triple& axis) const;
  // A direction on each body; the two coincide in the posture as written.
  void between(const Joint& j);

  // ---- bases (bases.cpp; levels in levels.cpp)
  // Solids in solving order, so that no base consists of members that are solved later. On one level, solids with many
  // features come first, because their neighbours use these members.
  [[nodiscard]] std::vector<std::size_t> order() const;
  // Number of rotations in space that move a feature: fewer than 3 if all features lie on one line.
  [[nodiscard]] Index turns_of(const Solid& s) const;
  // Sets the levels of solids, from a graph of their freedoms, first translations, then rotations. Points and vectors
  // that belong to no solid have freedoms, too. A joint reads those of both its bodies.
  void set_levels();
  // Features that are known before the solid come first.
  [[nodiscard]] static int rank(const Feature& f, const Solid& s) {
    return f.fixed ? 0 : f.driven ? 1 : f.level < s.level_of(f) ? 2 : f.solid != kNobody ? 3 : f.wanted ? 4 : 5;
  }
  void choose_base(std::size_t s);
  // How far the features of a base are apart: of three points, the smallest height of their triangle. A base whose
  // points are close to each other makes groups badly conditioned, so that their steps need more tests of the branch.
  [[nodiscard]] Number width(const std::vector<std::size_t>& base) const;
  // Replaces points of a base by points of the body that serve as well, while the base gets wider.
  void widen(std::vector<std::size_t>& base, const std::vector<std::size_t>& all,
             const std::function<bool(std::size_t, std::size_t)>& are_equal) const;
  // The base of a body whose base the scene declares.
  [[nodiscard]] std::vector<std::size_t> own_base(std::size_t s) const;
  // The other features of a solid become its members. A known feature, or a member of another solid, gets a copy that a
  // constraint ties to it.
  void settle(std::size_t s, const std::vector<std::size_t>& base);
  // True if the body cannot move this feature: it lies on an axis of the ground.
  [[nodiscard]] bool rests(const std::vector<std::size_t>& base, const Feature& f, double share) const;
  // False if this would close a circle: the base of this solid depends, directly or through others, on the feature.
  [[nodiscard]] bool may_determine(int solid, std::size_t feature) const;

  // ---- the new lists (writing.cpp)
  void write();
  void declare(const Feature& f);
  struct Tie {
    std::size_t feature;
    int solid;
  };
  void tie(std::size_t t, std::map<std::string, std::vector<Member>>& points,
           std::map<std::string, std::vector<Member>>& vectors);
  [[nodiscard]] std::size_t companion(const Tie& tie) const;
  void set_base(std::size_t s, const std::set<std::string>& still);
  void write(const Slide& s);
  // Writes 0 = 0 for each equation that other joints of fixed parts imply, so that it counts as redundant.
  void write_implied();
  // Counts the distances and angles of bases that other bodies keep.
  void count_kept_sides();
  void write_coordinates();

  JointParts p_;
  FindingsByPlace known_;
  std::vector<Diagnostic> findings_;
  bool is_broken_ = false;  // something was or would have been reported
  int suggestions_left_ = 100;
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
  std::set<std::size_t> stood_on_;                                     // features of these bases
  std::vector<std::pair<const Joint*, int>> implied_;  // equations that are not written, see write_implied()
  std::vector<Tie> ties_;
  std::set<std::pair<int, std::size_t>> tied_;    // the same
  std::map<std::size_t, std::set<int>> keepers_;  // features: solids that keep them in place
  std::set<std::string> gone_;  // bodies without a motion of their own, and bodies whose motion is not computed
};

}  // namespace assur::joints
