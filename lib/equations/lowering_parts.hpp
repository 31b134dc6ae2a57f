// The parts of lower(): each one writes some declarations and equations of a scene. Constants, forms and equations are
// numbered as they are written, so that the order of calls affects the result.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <span>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "equations/forms.hpp"
#include "scene/triple.hpp"

namespace assur {

using Pair = std::pair<std::string, std::string>;
inline Pair pair_key(const std::string& a, const std::string& b) { return std::minmax(a, b); }

inline constexpr double kDisagree = 1e-3;  // relative difference; guesses are written with three digits or more

inline Triple direction_of(const Triple& a) { return triple::scale(1 / triple::length(a), a); }

// Data that the parts share.
struct Shared {
  std::unordered_set<std::string> without_norm;    // vectors whose |v| = 1 is not an equation of its own
  std::unordered_set<Index> in_groups;             // coordinates that belong to declared groups
  std::unordered_set<std::string> absorbed;        // distance constraints that become radii of angle drivers
  std::unordered_map<std::string, Number> radius;  // angle drivers: value of the absorbed distance
  std::unordered_map<std::string, Index> reach;    // angle drivers: driver of the distance of the same points
  std::map<Pair, Number> lengths;                  // pairs of points of bases: distance constraints with a value
  std::set<Pair> distances;                        // pairs of points of bases whose distance is constrained already
  std::vector<bool> fixes;                         // drivers that fix coordinates, so that no equation is left
};

// The direction of entry i >= 1 of a base: a vector, or from the first point to this one.
[[nodiscard]] Direction base_direction(const Forms& forms, const Body& body, std::size_t i);

// Local coordinates of the directions of a base: (length, 0) and in space (x, y). Lengths are those of distance
// constraints with a value, else of the posture as written. Throws Error (input) if three lengths make no triangle.
struct BaseShape {
  Number length, x = 0, y = 0;
};
[[nodiscard]] BaseShape base_shape(const Forms& forms, const Shared& shared, const Body& body);

// Writes members as forms of their base, and the equations that keep a base rigid.
class BodyWriter {
 public:
  BodyWriter(Forms& forms, Shared& shared) : forms_(forms), shared_(shared) {}

  void declare_members();
  void write_equations();

  // True if no driver changes the dot product of two known directions. To be called when the inputs are declared.
  [[nodiscard]] bool is_constant(const Direction& d, const Direction& e);

 private:
  void declare_translating(const Body& body);
  void declare_in_frame(const Body& body);
  void declare_in_plane(const Body& body);
  void declare_in_space(const Body& body);

  // True if a driver of the pose writes the equations of the body's base.
  [[nodiscard]] bool posed_by_equations(const Body& body) const { return posed_.count(body.name) != 0; }
  void write_frame(const Body& body, Index index);
  void write_frame_about(Index source, const Item& fixed, const Item& next, const Item& after);
  [[nodiscard]] bool is_kept(std::initializer_list<std::string_view> names) const;
  void note_written(const Body& body, Index index);
  void write_base(const Body& body);
  void keep_dot(const Body& body);
  void write_normal(const Body& body, const Number& area);

  Forms& forms_;
  Shared& shared_;
  std::unordered_map<std::string, Number> area_;                    // bodies with a normal
  std::unordered_set<std::string> posed_;                           // bodies posed by equations
  std::map<std::string, std::vector<Index>, std::less<>> written_;  // bodies whose base or members have this name
  std::vector<std::vector<double>> elsewhere_;                      // known coordinates at other values of the drivers
};

class ConstraintWriter {
 public:
  ConstraintWriter(Forms& forms, Shared& shared) : forms_(forms), shared_(shared) {}

  // Collects distances between points of bases.
  void note_lengths();
  void declare_auxiliaries();
  // Takes distances between the points of an angle driver as its radius, without equations.
  void absorb_distances();
  void write_equations();

 private:
  // Unknowns that a constraint adds; most add none.
  template <class Kind>
  void declare(const std::string&, const Kind&) {}
  void declare(const std::string& name, const Parallel& c);
  void declare(const std::string& name, const OnLine& c);
  void declare(const std::string& name, const OnPlane& c);

  void write(const std::string& name, const Distance& c);
  void note_new_shape(const std::string& name, const Distance& c, double written);
  void write(const std::string& name, const EqualDistance& c);
  void write(const std::string& name, const Dot& c);
  void write(const std::string& name, const Parallel& c);
  void write(const std::string& name, const OnLine& c);
  void write(const std::string& name, const OnPlane& c);
  void write(const std::string& name, const Linear& c);
  void write(const std::string& name, const FixedCoordinate& c);
  void write(const std::string& name, const Callback& c);
  void write(const std::string&, const Gear&) {}  // build() makes a Callback of it

  Forms& forms_;
  Shared& shared_;
};

class DriverWriter {
 public:
  DriverWriter(Forms& forms, Shared& shared, std::span<const std::string> controlled)
      : forms_(forms), shared_(shared), controlled_(controlled.begin(), controlled.end()) {}

  void declare_auxiliaries();
  // Declares the known scalars of each driver as hidden coordinates.
  void declare_inputs();
  // Makes coordinates that drivers fix known coordinates, until nothing changes.
  void fix_coordinates();
  // Writes equations of drivers that fix no coordinates.
  void write_equations();
  // Notes the driven quantity of each driver, independent of its equations.
  void note_own_forms();

 private:
  // A point or vector of the base of a body, as forms of the frame of its driver.
  struct PoseTarget {
    std::string item;
    Index form[3];
  };

  // The known scalars of one driver: kind, laws, power of length and number.
  struct Input {
    DriverInput::Kind kind;
    std::vector<Law> laws;
    int power;
    Index count;
    bool must_not_vanish = false;
  };
  void declare_input(const Driver& driver, Index index, const Input& input);
  [[nodiscard]] Input input(const PointAngle& a) const;
  [[nodiscard]] Input input(const RelativeAngle& r) const;
  [[nodiscard]] Input input(const DrivenDistance& d) const;
  [[nodiscard]] Input input(const DrivenCoordinate& c) const;
  [[nodiscard]] Input input(const Pose& p) const;
  [[nodiscard]] Index input_form(Index driver, Index k) const {
    return first_form_[static_cast<std::size_t>(driver)] + k;
  }

  // True if the driver fixes coordinates; most kinds cannot.
  template <class Kind>
  bool fix(const Driver&, const Kind&, Index) {
    return false;
  }
  bool fix(const Driver& driver, const DrivenCoordinate& c, Index index);
  bool fix(const Driver& driver, const PointAngle& a, Index index);
  bool fix(const Driver& driver, const Pose& p, Index index);
  [[nodiscard]] bool can_be_fixed(const Item& item) const;
  void assign(Index coordinate, Index form);
  [[nodiscard]] Triple zero_of(const PointAngle& angle) const;
  [[nodiscard]] Number along_axis(const PointAngle& angle) const;
  Index arm_end(const Driver& driver, const PointAngle& angle, Index index, int k);
  // The drivers of the direction and of the distance of the same points are partners.
  void find_partners();
  void declare_rho(Index driver, int power, const Number& guess);
  [[nodiscard]] Index partner(Index driver) const { return partner_[static_cast<std::size_t>(driver)]; }
  void write_polar_arm(Index source, const Driver& driver, const PointAngle& angle, Index index);
  std::vector<PoseTarget> pose_targets(const Body& body, Index index);
  [[nodiscard]] const Body& body(const std::string& name) const;

  // (lower_driver_equations.cpp)
  void write(Index source, const Driver& driver, const DrivenCoordinate& c, Index index);
  void write(Index source, const Driver& driver, const PointAngle& a, Index index);
  void write(Index source, const Driver& driver, const DrivenDistance& d, Index index);
  void write(Index source, const Driver& driver, const RelativeAngle& r, Index index);
  void write(Index source, const Driver& driver, const Pose& p, Index index);
  void append_own(std::vector<Index>& own, const Direction& d);
  void note_own(std::vector<Index>& own, const PointAngle& a);
  void note_own(std::vector<Index>& own, const RelativeAngle& r);
  void note_own(std::vector<Index>& own, const DrivenDistance& d);
  void note_own(std::vector<Index>& own, const DrivenCoordinate& c);
  void note_own(std::vector<Index>& own, const Pose& p);
  void write_posed_frame(Index source, const Body& body, Index index);
  void write_equal(Index source, Index f, Index g);

  Forms& forms_;
  Shared& shared_;
  std::unordered_set<std::string> controlled_;
  std::vector<Index> first_form_;  // drivers: form of the first input
  std::vector<Index> partner_;     // drivers: the partner; -1: none
};

}  // namespace assur
