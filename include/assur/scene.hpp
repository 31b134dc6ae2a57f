// Scenes, the input of the library: mechanism, drivers, wanted outputs and time grid. Units are SI, angles are in rad.
// The posture as written consists of the points, vectors and joints exactly as they are given; it need not satisfy the
// constraints. The start posture is assembled from it.
// A Scene is read from a file, made by name (a sample), or built in C++ with SceneBuilder. docs/scenes.md shows the
// format by examples. The functions in this header need the library assur::assur.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "assur/law.hpp"
#include "assur/number.hpp"
#include "assur/status.hpp"

namespace assur {

// A point, whose coordinates are unknowns unless it is fixed or driven. Names consist of letters, digits and
// underscores, and do not begin with a digit.
struct Point {
  std::string name;    // unique among points, vectors, bodies, joints, constraints, drivers, measures and groups
  Triple at{};         // m: position of a fixed point; else a first guess, which also gives lengths that are left out
  bool fixed = false;  // true: the point never moves
};

// A unit vector, whose coordinates are unknowns unless it is fixed or driven.
struct Vector {
  std::string name;    // unique, see Point
  Triple at{};         // direction of a fixed vector, else a first guess; build() normalises it
  bool fixed = false;  // true: the vector never turns
  bool unit = true;    // true: |u| = 1 is an equation; false: the length follows from other equations
};

// A point or vector that belongs to a body. Its coordinates are affine functions of the base of the body, so that it
// adds no unknowns and no equations.
struct Member {
  std::string name;  // unique, see Point
  Triple local{};    // coordinates in the frame of the body: m for points; a vector is normalised by build()
  // True: `local` holds ground coordinates of the posture as written; build() converts them. Without effect for bodies
  // without a base, whose members always have ground coordinates.
  bool in_ground = false;
};

// A frame that moves, with points and vectors that belong to it. It has exactly one of these bases:
//   3D: `origin` and `frame` of three unit vectors u, v, w = u x v;
//       `base` of a point and two entries, each a point or a vector, that are not on one line (local origin: the point;
//       axes: x along the second entry, y in the plane of both towards the third, z = x cross y);
//       or `base` of a point and one entry: all members are on one line, the local x-axis, and the
//       body may turn about it
//   2D: `base` of a point and another point or a vector (local origin: the first; axes: x along the second, y to its
//       left), or `origin` and `frame` of one vector
//   `origin` alone: a body that only translates; its local axes are those of the ground
//   none: joints or `rigid` define the body, and build() chooses a base. Its members are given in ground coordinates
// The entries of a base keep their distances and angles as written; a Distance between two points of the base gives
// another distance. The body "ground" has no base; its members are fixed.
struct Body {
  std::string name;                     // unique, see Point
  std::string origin = {};              // name of a point; "": none
  std::vector<std::string> frame = {};  // names of vectors
  std::vector<std::string> base = {};   // names of points, and of vectors after the first
  std::vector<Member> points = {};      // points that belong to the body
  std::vector<Member> vectors = {};     // vectors that belong to the body
  std::vector<std::string> rigid = {};  // names of points and vectors that move as one rigid body
};

// A direction: a vector, or the difference of two points.
struct Direction {
  std::string first;   // name of the vector, or of the first point
  std::string second;  // name of the second point, which the direction leads to; "": the direction is a vector

  Direction() = default;
  // The direction of a vector.
  Direction(std::string vector) : first(std::move(vector)) {}  // NOLINT: a vector's name is a direction
  // The direction of a vector.
  Direction(const char* vector) : first(vector) {}  // NOLINT
  // The direction from one point to another; its length is their distance.
  Direction(std::string from, std::string to) : first(std::move(from)), second(std::move(to)) {}
  // True if the direction is the difference of two points.
  [[nodiscard]] bool is_pair() const { return !second.empty(); }
};

// ---- joints: each connects body `a` and body `b`, of which one may be "ground"; NAME is the name of the joint.
// build() replaces joints by points and vectors that both bodies share, and by constraints (docs/joints.md). Joints
// have coordinates: "NAME.angle" of b about the axis relative to a (rad, right-handed; 2D: counter-clockwise) and
// "NAME.displacement" of b along the axis relative to a (m). Both are 0 in the posture as written. Drivers and measures
// of a coordinate, gears, limits and outputs may name them; other constraints and callbacks may not.

// A place or a direction that a joint has on both bodies: ground coordinates of the posture as written, or the name of
// a point or vector. Directions may have any length but 0.
using Anchor = std::variant<Triple, std::string>;

// One rotation. The bodies share the point NAME, and in 3D the vector NAME.axis. Coordinate: angle.
struct Revolute {
  std::string a, b;
  Anchor at;         // on the axis
  Anchor axis = {};  // 3D only
};
// One translation without rotation. Coordinate: displacement.
struct Prismatic {
  std::string a, b;
  Anchor axis;
};
// Rotation about an axis and translation along it; 3D. Coordinates: angle, displacement.
struct Cylindrical {
  std::string a, b;
  Anchor at;  // on the axis
  Anchor axis;
};
// All rotations about a point; 3D. The bodies share the point NAME.
struct Spherical {
  std::string a, b;
  Anchor at;
};
// Two rotations about crossing axes, the first fixed to `a`, the second to `b`; 3D. The bodies share the point NAME.
struct Universal {
  std::string a, b;
  Anchor at;
  Anchor axis_a, axis_b;  // at right angles as written: the cosine of their angle is at most 1e-6
};
// Sliding and turning in a plane; 3D. The bodies share the vector NAME.normal.
struct Planar {
  std::string a, b;
  Anchor normal;
};
// No motion: the bodies are one.
struct Fixed {
  std::string a, b;
};

// A joint between two bodies.
struct Joint {
  std::string name;  // unique, see Point
  // One of the structs above.
  std::variant<Revolute, Prismatic, Cylindrical, Spherical, Universal, Planar, Fixed> kind;
};

// ---- constraints: one struct for each kind; NAME is the name of the constraint

// The distance of two points is constant: |P - Q|^2 = value^2.
struct Distance {
  std::string p, q;                  // names of points
  std::optional<Number> value = {};  // m, > 0; empty: the distance in the posture as written
};
// Two distances are equal: |P - Q|^2 = |R - S|^2.
struct EqualDistance {
  std::string p, q, r, s;  // names of points
};
// A dot product is constant: d . e = value.
struct Dot {
  Direction d, e;                    // the two directions
  std::optional<Number> value = {};  // unit: 1 (two vectors), m (vector and pair) or m^2 (two pairs); empty: as written
};
// Two directions are parallel: e = lambda d, with the unknown NAME.lambda.
struct Parallel {
  Direction d, e;  // the two directions
};
// A sum is constant: sum factor * (point or vector) = value, one equation for each coordinate.
struct Linear {
  std::vector<std::pair<std::string, Number>> terms;  // name of the point or vector, factor other than 0
  Triple value{};                                     // m if there is a point among the terms, else 1
};
// One coordinate is constant.
struct FixedCoordinate {
  std::string coordinate;  // "P.x", "name.lambda"
  Number value = 0;        // in the unit of the coordinate
};
// A point is on a line: P = A + lambda d, with the unknown NAME.lambda.
struct OnLine {
  std::string p, a;  // names of points: on the line, and the origin of the line
  Direction d;       // direction of the line
};
// A point is on a plane, in space: P = A + lambda d + mu e, with the unknowns NAME.lambda and NAME.mu.
struct OnPlane {
  std::string p, a;  // names of points: on the plane, and the origin of the plane
  Direction d, e;    // two directions that span the plane
};

// Two coordinates of joints move in proportion, as those of gears or of a rack and its pinion: b = ratio * a, both
// counted from the posture as written. build() makes a Callback of it; docs/joints.md gives its equation. The ratio of
// two angles is that of whole numbers up to 1000, within 1e-9; others are refused.
struct Gear {
  std::string a, b;  // "JOINT.angle" or "JOINT.displacement"
  Number ratio = 1;  // not 0; 1, m/rad or rad/m, also in a file with angles in degrees
};

// Equations of a C++ function, for scenes built in C++. All arguments and results are in SI units. The equations are
// not quadratic, so that their groups have no certificates. assur trusts the residual, and compares Jacobian and
// curvature with differences (docs/accuracy.md). For this it calls the functions near the posture as well; an exception
// there means that the function is not defined there. Several threads may call the functions at once, see Simulator.
// All three functions are needed, whatever the outputs are; build() refuses an empty one.
struct Callback {
  // Arguments x (m of them): names of scalars, "P.x" or "name.lambda" ("NAME.slide.lambda": the displacement of joint
  // NAME), or of drivers of a distance or coordinate, whose values they then are.
  std::vector<std::string> coordinates;
  int equations = 0;  // number of equations r, at least 1
  // residual(x[m], phi[r]) sets phi, which is 0 in a posture of the mechanism.
  std::function<void(std::span<const double>, std::span<double>)> residual;
  // jacobian(x[m], J[r * m]) sets all entries dphi_i/dx_j, row-major.
  std::function<void(std::span<const double>, std::span<double>)> jacobian;
  // curvature(x[m], x'[m], c[r]) sets c = d/dt(J) x', a term of the acceleration equation.
  std::function<void(std::span<const double>, std::span<const double>, std::span<double>)> curvature;
  // Tolerance of the derivatives, >= 0; raise it if they are approximations. Infinite: they are not checked.
  double tolerance = kDerivativeTolerance;
  // At least 1. If the equations hold again 1/teeth of a turn away, as those of gears: a step turns the drivers by
  // about 1/teeth rad at most, so that it cannot skip a tooth. Longer steps are divided.
  int teeth = 1;
};

// A kind of constraint that is stored on the heap. Most constraints are distances, and a scene may have millions: this
// keeps the variant in Constraint small. Copies share the kind. It converts from and to the kind itself.
template <class Kind>
class Apart {
 public:
  // Stores a kind.
  Apart(Kind kind) : kind_(std::make_shared<const Kind>(std::move(kind))) {}  // NOLINT: stands for the kind itself
  // The stored kind; valid as long as any copy of this object exists.
  operator const Kind&() const { return *kind_; }  // NOLINT

 private:
  std::shared_ptr<const Kind> kind_;  // of all copies
};

// A constraint: equations between points, vectors and scalars.
struct Constraint {
  std::string name;  // unique, see Point
  // One of the structs above. Use visit() or as() to read it.
  std::variant<Distance, Apart<EqualDistance>, Apart<Dot>, Apart<Parallel>, Linear, FixedCoordinate, Apart<OnLine>,
               Apart<OnPlane>, Apart<Gear>, Apart<Callback>>
      kind;

  // Calls visitor(kind) with the struct of the constraint, and returns the result.
  template <class Visitor>
  decltype(auto) visit(Visitor&& visitor) const {
    return std::visit([&](const auto& own) -> decltype(auto) { return visitor(itself(own)); }, kind);
  }

  // The struct of the constraint if it is of this kind, else null; valid as long as the constraint.
  template <class Kind>
  [[nodiscard]] const Kind* as() const {
    return visit([](const auto& own) -> const Kind* {
      if constexpr (std::is_same_v<decltype(own), const Kind&>) {
        return &own;
      } else {
        return nullptr;
      }
    });
  }

 private:
  template <class Kind>
  static const Kind& itself(const Kind& kind) {
    return kind;
  }
  template <class Kind>
  static const Kind& itself(const Apart<Kind>& kind) {
    return kind;
  }
};

// ---- drivers

// Drives the direction of AB. 2D: the angle from +x, counter-clockwise. 3D: the angle about a fixed axis, right-handed,
// zero in the posture as written. The distance of A and B, and in 3D its part along the axis, stay as in the posture as
// written; a Distance between them gives another distance, and costs no equation. A DrivenDistance between them moves B
// along the arm. In 3D both drivers together add the unknown NAME.rho, the distance of B from the axis through A.
struct PointAngle {
  std::string a, b;  // names of points
  // 3D: ground coordinates of any length but 0, or the name of a fixed vector; 2D: ""
  Anchor axis = std::string();
  Law law;  // rad
};
// Drives the angle from one direction to another, right-handed about an axis (2D: the normal):
// atan2(axis . (d x e), d . e). This is the angle of turn if the axis is at right angles to d and e. Adds the unknown
// NAME.rho, which is then the product of the lengths of both directions; 3D with a moving axis: also the vector
// NAME.across.
struct RelativeAngle {
  Direction d, e;  // from d to e
  // 3D: ground coordinates of any length but 0, or the name of a vector, which may move; 2D: ""
  Anchor axis = std::string();
  Law law;  // rad
};
// Drives the distance of two points, a linear actuator.
struct DrivenDistance {
  std::string a, b;  // names of points
  Law law;           // m; must stay > 0
};
// Drives one coordinate, e.g. of a point, the displacement of a slider, or a coordinate of a joint ("NAME.angle").
struct DrivenCoordinate {
  std::string coordinate;  // "P.x", "name.lambda"
  Law law;                 // in the unit of the coordinate
};
// Drives a whole body.
struct Pose {
  // Name of the body. If it has no origin or base, build() chooses the local origin and axes that the laws move; its
  // outputs are those of another frame, which lay on the ground's in the posture as written (docs/joints.md).
  std::string body;
  // Ground coordinates of the local origin (the origin, or the first point of the base): 3 laws in space, 2 in the
  // plane; m
  std::vector<Law> translation;
  // rad; 3D: psi, theta, phi of Rz(psi) Ry(theta) Rx(phi); 2D: one angle; none for a body that only translates.
  std::vector<Law> rotation;
};

// A driver: it prescribes a motion by laws.
struct Driver {
  std::string name;  // unique, see Point
  // One of the structs above.
  std::variant<PointAngle, RelativeAngle, DrivenDistance, DrivenCoordinate, Pose> kind;
  // True: the laws give the difference from the value of the driver in the posture as written. Drivers of the angle or
  // displacement of a joint always count from there.
  bool relative = false;
  // True: the values that a program sets give this difference, too. build() sets it for coordinates of joints.
  bool sets_difference = false;
};

// ---- measures

// Direction of AB from +x, in the plane; rad. Begins in (-pi, pi] and follows the motion through whole turns.
struct AbsoluteAngle {
  std::string a, b;  // names of points
};
// Angle from d to e; rad. Signed in the plane, and in space with an axis: atan2(axis . (d x e), d . e), which follows
// the motion through whole turns. In space without an axis it is in [0, pi]; at these ends it has no derivatives (NaN),
// and the step is `inaccurate` unless the angle is at rest.
struct AngleBetween {
  Direction d, e;               // from d to e
  Anchor axis = std::string();  // 3D: as RelativeAngle, or ""; 2D: ""
};
// Distance of two points; m. At 0 it has no derivatives (NaN), and the step is `inaccurate` unless it is at rest.
struct MeasuredDistance {
  std::string a, b;  // names of points
};
// One coordinate, in its unit.
struct MeasuredCoordinate {
  std::string coordinate;  // "P.x", "name.lambda"
};
// A constant plus multiples of other measures, all in one unit.
struct Combination {
  std::vector<std::pair<std::string, Number>> terms;  // name of a measure other than a Combination, factor, not 0
  Number constant = 0;                                // in the unit of the measures
};

// One number of the orientation of a body. build() makes these for outputs that name the body.
struct Orientation {
  // angle: of the plane, rad, as AbsoluteAngle. w to z: the unit quaternion with w >= 0. turn_x to turn_z: has no
  // value; its rate is a component of the angular velocity in ground coordinates, its acceleration one of the angular
  // acceleration; rad.
  enum class Part : std::uint8_t { angle, w, x, y, z, turn_x, turn_y, turn_z };
  std::string body;  // the name of a body with members BODY.ex, BODY.ey and BODY.ez, which build() adds
  Part part = Part::angle;
};

// A measure: a quantity that can be an output.
struct Measure {
  std::string name;  // unique, see Point
  // One of the structs above.
  std::variant<AbsoluteAngle, AngleBetween, MeasuredDistance, MeasuredCoordinate, Combination, Orientation> kind;
};

// A limit of a measure, or of a coordinate of a joint: the smallest and the largest value that it may have. A motion
// that leaves the limit ends (Code::limit_reached), or goes on with an event (docs/joints.md#limits).
struct Limit {
  // What happens when a motion leaves the limit.
  enum class Reaction : std::uint8_t {
    end,   // it ends, at the last posture within the limit
    flag,  // it goes on; events report when it leaves the limit, and when it returns
  };
  std::string quantity;  // name of a measure, or "JOINT.angle", "JOINT.displacement"; one limit for each
  // In the unit of the quantity (rad, m); infinite: no limit on this side. A signed angle is followed through whole
  // turns; it starts at the law of its driver, else within the limit if a number of whole turns brings it there. The
  // output of this name begins in (-pi, pi], and may differ by whole turns.
  Number min = -HUGE_VAL, max = HUGE_VAL;
  Reaction reaction = Reaction::end;
  std::string driver = {};  // build() sets it: the driver of the coordinate, if one of the joint's drivers has it
};

// A structural group that the scene declares: a union of irreducible groups.
struct DeclaredGroup {
  std::string name;                   // for messages and reports
  std::vector<std::string> unknowns;  // names of points, vectors and auxiliary scalars ("name.lambda")
  bool keep = false;                  // true: solve all of it; false: only the part that the outputs need
};

// The times t_k = start + k * step, k = 0..N. (end - start) / step must be a whole number, within 1e-9 and the rounding
// of times, and at most 1e12.
struct TimeGrid {
  double start = 0;  // first time, s
  double end = 0;    // last time, s
  double step = 0;   // s, > 0; a scene without a time grid has three zeros, and one row at t = 0

  // N, the number of steps.
  [[nodiscard]] std::int64_t steps() const { return step > 0 ? std::llround((end - start) / step) : 0; }
  // t_k, s.
  [[nodiscard]] double time(std::int64_t k) const { return start + static_cast<double>(k) * step; }
};

// Values of parameters, by name.
using Parameters = std::map<std::string, Number>;
struct SceneSource;  // for use inside the library

// A mechanism with drivers, measures, outputs and a time grid, checked as a whole. A Scene does not change, and copies
// share their parts: references that its functions return are valid as long as the scene.
class Scene {
 public:
  // Name of the scene.
  [[nodiscard]] const std::string& name() const { return parts_->name; }
  // 2: in the plane, 3: in space.
  [[nodiscard]] int dimension() const { return parts_->dimension; }
  // All points except members of bodies, in the order in which they were added.
  [[nodiscard]] const std::vector<Point>& points() const { return parts_->points; }
  // All vectors except members of bodies; normalised.
  [[nodiscard]] const std::vector<Vector>& vectors() const { return parts_->vectors; }
  // All bodies. If the base of a body contains members of another body, the other body comes first.
  [[nodiscard]] const std::vector<Body>& bodies() const { return parts_->bodies; }
  // All joints as written, in the order in which they were added. The other lists hold the parts that replace them.
  [[nodiscard]] const std::vector<Joint>& joints() const { return parts_->joints; }
  // All constraints, in the order in which they were added; those of joints follow.
  [[nodiscard]] const std::vector<Constraint>& constraints() const { return parts_->constraints; }
  // All drivers, in the order in which they were added; Place::driver() takes an index into this list.
  [[nodiscard]] const std::vector<Driver>& drivers() const { return parts_->drivers; }
  // All measures, in the order in which they were added.
  [[nodiscard]] const std::vector<Measure>& measures() const { return parts_->measures; }
  // All limits, in the order in which they were added.
  [[nodiscard]] const std::vector<Limit>& limits() const { return parts_->limits; }
  // The declared groups.
  [[nodiscard]] const std::vector<DeclaredGroup>& groups() const { return parts_->groups; }
  // The wanted outputs; members and measures replace those that name a body. If there are none, everything that moves
  // is computed.
  [[nodiscard]] const std::vector<std::string>& outputs() const { return outputs_; }
  // The time grid.
  [[nodiscard]] const TimeGrid& time() const { return time_; }
  // Paths of the CSV files that the laws were read from.
  [[nodiscard]] const std::vector<std::filesystem::path>& tables() const { return parts_->tables; }
  // Findings that are not errors, e.g. a vector that had to be normalised.
  [[nodiscard]] const std::vector<Diagnostic>& warnings() const { return parts_->warnings; }

  // The same mechanism with other outputs, as SceneBuilder::output() takes them. Throws Error
  // (input), with the known names, if a name is unknown.
  [[nodiscard]] Scene with_outputs(std::vector<std::string> outputs) const;
  // The same mechanism with another time grid. Throws Error (input) if the grid has no whole number of steps, or if a
  // table does not cover it.
  [[nodiscard]] Scene with_time(TimeGrid time) const;
  // The same mechanism with other laws. law() gets the name of each driver, or of each value of a pose as
  // Simulator::set() takes them ("pose.x"), and its law; it returns the new law. Throws Error (input) if a table does
  // not cover the time grid.
  [[nodiscard]] Scene with_laws(const std::function<Law(const std::string& driver, const Law& before)>& law) const;
  // The same mechanism with other values of parameters(), or of these numbers as they were written (SI units):
  //   "P.x", "P.y", "P.z"  a coordinate of a point, of a vector, of a member in the frame of its body, or of the place
  //                        of a joint P (`at`)
  //   "C"                  the value of the constraint C: a Distance, Dot, FixedCoordinate, or the ratio of a Gear
  // Parameters that are not named keep their values; time grid and outputs stay as they are. A scene whose laws were
  // replaced has no parameters. Throws Error (input) for an unknown name, and like the function that made the scene.
  [[nodiscard]] Scene with_values(const Parameters& values) const;
  // Names of the parameters of a scene that was read from a file, or of the options of a sample. Empty for other
  // scenes.
  [[nodiscard]] const std::vector<std::string>& parameters() const;

 private:
  friend class SceneBuilder;
  friend struct SceneSource;
  struct Parts {
    std::string name;
    int dimension = 2;
    std::vector<Point> points;
    std::vector<Vector> vectors;
    std::vector<Body> bodies;
    std::vector<Joint> joints;
    std::vector<Constraint> constraints;
    std::vector<Driver> drivers;
    std::vector<Measure> measures;
    std::vector<Limit> limits;
    std::vector<DeclaredGroup> groups;
    std::vector<std::filesystem::path> tables;
    std::vector<Diagnostic> warnings;
    // The parts as written, before build() replaces joints and outputs that name bodies; null if it replaced nothing.
    std::shared_ptr<const Parts> written;
  };
  // The parts and outputs as written.
  [[nodiscard]] const Parts& written() const { return parts_->written ? *parts_->written : *parts_; }
  friend std::string write_scene(const Scene& scene);
  // Sets those of the values that are numbers of the parts.
  static void set_numbers(Parts& parts, const Parameters& values);

  std::shared_ptr<const SceneSource> source_;                             // null: the scene has no parameters
  bool has_other_outputs_ = false, has_other_time_ = false;               // than the source gives
  std::shared_ptr<const Parts> parts_ = std::make_shared<const Parts>();  // of all copies
  std::vector<std::string> outputs_;
  std::vector<std::string> written_outputs_;
  TimeGrid time_;
};

// Builds a scene in C++. The parts may be added in any order; each function returns the builder itself. Nothing is
// checked before build(), which reports all errors together.
class SceneBuilder {
 public:
  // Begins a scene without parts. dimension: 2 (plane) or 3 (space).
  SceneBuilder(std::string name, int dimension);

  // Adds a point with a first guess, m.
  SceneBuilder& point(std::string name, Triple at) { return add(Point{std::move(name), at, false}); }
  // Adds a point that never moves; m.
  SceneBuilder& fixed_point(std::string name, Triple at) { return add(Point{std::move(name), at, true}); }
  // Adds a vector with a first guess. If `unit` is false, its length follows from other equations.
  SceneBuilder& vector(std::string name, Triple at, bool unit = true) {
    return add(Vector{std::move(name), at, false, unit});
  }
  // Adds a unit vector that never turns.
  SceneBuilder& fixed_vector(std::string name, Triple at) { return add(Vector{std::move(name), at, true, true}); }

  SceneBuilder& add(Point point);            // adds a point
  SceneBuilder& add(Vector vector);          // adds a vector
  SceneBuilder& add(Body body);              // adds a body
  SceneBuilder& add(Joint joint);            // adds a joint
  SceneBuilder& add(Constraint constraint);  // adds a constraint
  SceneBuilder& add(Driver driver);          // adds a driver
  SceneBuilder& add(Measure measure);        // adds a measure
  SceneBuilder& add(Limit limit);            // adds a limit
  SceneBuilder& add(DeclaredGroup group);    // adds a declared group

  // Adds a joint, e.g. joint("A", Revolute{"ground", "crank", Triple{0, 0}}).
  template <class Kind>
  SceneBuilder& joint(std::string name, Kind kind) {
    return add(Joint{std::move(name), std::move(kind)});
  }
  // Adds a constraint, e.g. constrain("coupler", Distance{"B", "C", 1.8}).
  template <class Kind>
  SceneBuilder& constrain(std::string name, Kind kind) {
    return add(Constraint{std::move(name), std::move(kind)});
  }
  // Adds a driver, e.g. drive("motor", PointAngle{"A", "B", "", law}). If `relative` is true, the laws give the
  // difference from the value in the posture as written.
  template <class Kind>
  SceneBuilder& drive(std::string name, Kind kind, bool relative = false) {
    return add(Driver{std::move(name), std::move(kind), relative});
  }
  // Adds a measure, e.g. measure("rocker_angle", AbsoluteAngle{"D", "C"}).
  template <class Kind>
  SceneBuilder& measure(std::string name, Kind kind) {
    return add(Measure{std::move(name), std::move(kind)});
  }
  // Adds a limit, e.g. limit("knee.angle", -0.1, 2.2). An infinite number is no limit.
  SceneBuilder& limit(std::string quantity, Number min, Number max, Limit::Reaction reaction = Limit::Reaction::end) {
    return add(Limit{std::move(quantity), min, max, reaction});
  }
  // Reserves memory for this many points and constraints, for large scenes.
  SceneBuilder& reserve(std::size_t points, std::size_t constraints);

  // Adds an output: "C", "C.velocity", a column such as "C.vx", or "all" alone; of a body B: "B", its pose, or
  // "B.origin", "B.quaternion", "B.angular_velocity", "B.angular_acceleration", in the plane "B.angle"
  // (docs/joints.md). Without outputs, everything that moves is computed.
  SceneBuilder& output(std::string name);
  // Sets the time grid, s.
  SceneBuilder& time(double start, double end, double step);
  SceneBuilder& table(std::filesystem::path file);  // adds a path to Scene::tables(); the file is not read

  // Adds an error that the caller found, e.g. while reading a file. build() reports it with its own findings, and
  // reports nothing else at, above or below that place. An empty `what` marks a place whose error is reported
  // elsewhere.
  SceneBuilder& diagnose(Diagnostic diagnostic);

  // Checks and returns the scene; the builder keeps its parts. Throws Error (input) with every finding.
  [[nodiscard]] Scene build() const& { return SceneBuilder(*this).finish(); }
  // Checks and returns the scene without copying; the builder loses its parts. Throws Error (input) with every finding.
  [[nodiscard]] Scene build() && { return finish(); }

 private:
  friend class Scene;
  [[nodiscard]] Scene finish();

  Scene::Parts parts_;
  std::vector<std::string> outputs_;
  TimeGrid time_;
  std::vector<Diagnostic> found_;
};

// In all functions that follow, the parameters `set` replace those of the scene (`--set name=value`). A name that the
// scene does not have is an error.

// Reads a scene file: JSON, a regular file of at most 1 GB. Its tables, CSV files of at most 256 MB, must lie in or
// below the folder of the scene or one of `more_folders`, after links are followed. Throws Error: environment if the
// file cannot be read, input with every finding ("FILE: /json/pointer: what") if the scene or a table is wrong.
[[nodiscard]] Scene read_scene(const std::filesystem::path& file, const Parameters& set = {},
                               const std::vector<std::filesystem::path>& more_folders = {});

// Reads a scene from text. Paths of tables are relative to `folder`; `name` precedes each finding; a scene without a
// name gets it as its name. Throws Error (input) like read_scene().
[[nodiscard]] Scene parse_scene(std::string_view text, const std::string& name = "scene",
                                const std::filesystem::path& folder = ".", const Parameters& set = {},
                                const std::vector<std::filesystem::path>& more_folders = {});

// The scene as text in the format of scene files, with joints as they were written: one object a line, sections in the
// order of docs/scenes.md. Every number is the shortest text that reads back as the same double, so that parse_scene()
// makes the same scene. Parameters and expressions are replaced by their values, tables in files by rows; all
// angles are in rad. Coordinates of joints that only earlier outputs named (Scene::with_outputs) are left out. Throws
// Error (input) with every finding if the scene has functions of the program, which a file cannot hold: callbacks and
// laws.
[[nodiscard]] std::string write_scene(const Scene& scene);
// Writes this text to a file, which it replaces. Throws Error: input as above, environment if the file cannot be
// written.
void write_scene(const Scene& scene, const std::filesystem::path& file);

// Makes a sample mechanism from its text: "stewart", "stewart:legs=22", "four_bar:64", ... `set` sets options, too.
// Throws Error: input, with a list of the samples or options with their defaults, if a name or value is wrong;
// environment if the sample needs more memory than is free.
[[nodiscard]] Scene sample(std::string_view text, const Parameters& set = {});

// A scene that a function of the program builds from the values of parameters. They can be set (Scene::with_values) and
// vary in tables (Ensemble), for whose members `make` is not called if it computes in Number what follows from them.
// Several threads may call it at once. Throws what it throws.
[[nodiscard]] Scene parametric_scene(const Parameters& defaults, std::function<Scene(const Parameters&)> make);

// True if the text up to the first ':' is the name of a sample.
[[nodiscard]] bool is_sample(std::string_view text);

// Reads the SCENE of the command: a file if a file of this name exists, or if the text has a '/' or ends with .json or
// .xml and is no sample; else a sample. A file whose name ends with .xml is a model (import_model()), which has no
// parameters. Throws like read_scene(), import_model() and sample(), and Error (input) if `set` names a parameter of a
// model.
[[nodiscard]] Scene open_scene(const std::string& file_or_sample, const Parameters& set = {},
                               const std::vector<std::filesystem::path>& more_folders = {});

// Reads sets of parameters for an ensemble from a CSV, a regular file of at most 256 MB: the first line has the names,
// each further line the values of one set. Whether a scene has these parameters is not checked here. Throws Error:
// environment if the file cannot be read, or if its sets need more memory than is free; input with every finding
// ("FILE: line 3, column 2 (crank): what") if the content is wrong.
[[nodiscard]] std::vector<Parameters> read_variants(const std::filesystem::path& file);

}  // namespace assur
