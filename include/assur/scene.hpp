// The input: mechanism, drivers, wanted outputs, time grid. SI units, angles in rad.
// A Scene is immutable, and cheap to copy. It is read from a file, named as a sample, or built in C++ with
// SceneBuilder.
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
#include "assur/status.hpp"

namespace assur {

using Triple = std::array<double, 3>;  // x, y, z; z = 0 in the plane

struct Point {
  std::string name;
  Triple at{};  // position of a fixed point, else the first guess and the source of lengths left out; m
  bool fixed = false;
};

struct Vector {
  std::string name;
  Triple at{};  // normalised when the scene is built
  bool fixed = false;
  bool unit = true;  // |u| = 1 is an equation; false if the norm follows from other equations
};

// A point or vector with local coordinates in a body: affine in the body's base, no unknowns, no equations.
struct Member {
  std::string name;
  Triple local{};  // m for points
  // `local` are ground coordinates of the posture as written; the built scene has them in the body's base.
  bool in_ground = false;
};

// A moving frame. Exactly one of these bases:
//   3D: origin + frame of three unit vectors (u, v, w), or base of three points, not collinear (local axes: x from the
//       first to the second, y in their plane towards the third, z = x cross y)
//   2D: base of two points (local axes: x from the first to the second, y to its left), or origin + frame of one vector
//   an origin alone: a body that translates
// The name "ground" is the fixed frame: its members are fixed.
struct Body {
  std::string name;
  std::string origin;
  std::vector<std::string> frame;
  std::vector<std::string> base;
  std::vector<Member> points;
  std::vector<Member> vectors;
};

// The name of a vector ({"u", ""}), or a pair of points ({"A", "B"}: from A to B).
struct Direction {
  std::string first;
  std::string second;

  Direction() = default;
  Direction(std::string vector) : first(std::move(vector)) {}  // NOLINT: a vector's name is a direction
  Direction(const char* vector) : first(vector) {}             // NOLINT
  Direction(std::string from, std::string to) : first(std::move(from)), second(std::move(to)) {}
  [[nodiscard]] bool is_pair() const { return !second.empty(); }
};

// ---- constraints: the equations are those of the scene format, one struct for each type

struct Distance {  // |P - Q|^2 = value^2
  std::string p, q;
  std::optional<double> value = {};  // m, > 0; left out: from `at`
};
struct EqualDistance {  // |P - Q|^2 = |R - S|^2
  std::string p, q, r, s;
};
struct Dot {  // d . e = value
  Direction d, e;
  std::optional<double> value = {};  // left out: from `at`
};
struct Parallel {  // e - lambda d = 0, lambda = NAME.lambda
  Direction d, e;
};
struct Linear {  // sum factor * (point or vector) = value
  std::vector<std::pair<std::string, double>> terms;
  Triple value{};
};
struct FixedCoordinate {   // one coordinate is a constant
  std::string coordinate;  // "P.x"
  double value = 0;
};
struct OnLine {  // P - A - lambda d = 0
  std::string p, a;
  Direction d;
};
struct OnPlane {  // P - A - lambda d - mu e = 0, 3D
  std::string p, a;
  Direction d, e;
};

// Equations given by the user's code, C++ only. `coordinates` names scalars ("P.x", "name.lambda", or a driver of
// kind `distance` or `coordinate` for its known value); all arguments and results are in SI units and not scaled.
// Not quadratic: no certificate. The residual is trusted: it says what the mechanism is. Jacobian and curvature are
// held against differences (docs/accuracy.md): the functions are then called next to the posture, too; what
// they throw there means that they are not defined there.
struct Callback {
  std::vector<std::string> coordinates;  // m of them
  int equations = 0;                     // r
  // residual(x[m], phi[r])
  std::function<void(std::span<const double>, std::span<double>)> residual;
  // jacobian(x[m], J[r * m], row-major)
  std::function<void(std::span<const double>, std::span<double>)> jacobian;
  // curvature(x[m], x'[m], c[r]): the term d/dt(Phi_q) q' of the acceleration equation
  std::function<void(std::span<const double>, std::span<const double>, std::span<double>)> curvature;
  // How far derivatives may be off, where they are meant to be approximations; infinite: nothing is checked.
  double tolerance = kDerivativeTolerance;
};

// A kind that is large, kept apart: most constraints are distances, and a scene may have millions.
template <class Kind>
class Apart {
 public:
  Apart(Kind kind) : kind_(std::make_shared<const Kind>(std::move(kind))) {}  // NOLINT: stands for the kind itself
  operator const Kind&() const { return *kind_; }                             // NOLINT

 private:
  std::shared_ptr<const Kind> kind_;  // of all copies
};

struct Constraint {
  std::string name;
  std::variant<Distance, Apart<EqualDistance>, Apart<Dot>, Apart<Parallel>, Linear, FixedCoordinate, Apart<OnLine>,
               Apart<OnPlane>, Apart<Callback>>
      kind;

  // visitor(kind), whichever it is.
  template <class Visitor>
  decltype(auto) visit(Visitor&& visitor) const {
    return std::visit([&](const auto& own) -> decltype(auto) { return visitor(itself(own)); }, kind);
  }

  // As that kind; null: it is of another one.
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

struct PointAngle {  // 2D: direction of AB from +x; 3D: right-handed about `axis` (fixed), zero where `at` is
  std::string a, b;
  std::string axis;  // 3D only
  Law law;
};
struct RelativeAngle {  // from d to e, right-handed about `axis` (2D: none)
  Direction d, e;
  std::string axis;
  Law law;
};
struct DrivenDistance {
  std::string a, b;
  Law law;
};
struct DrivenCoordinate {
  std::string coordinate;  // "P.x", "name.lambda"
  Law law;
};
struct Pose {
  std::string body;
  std::vector<Law> translation;  // dimension of them
  std::vector<Law> rotation;     // 3D: psi, theta, phi of Rz Ry Rx; 2D: one angle; empty for a body that translates
};

struct Driver {
  std::string name;
  std::variant<PointAngle, RelativeAngle, DrivenDistance, DrivenCoordinate, Pose> kind;
  // The laws say by how much the driver is off its value in the posture as written.
  bool relative = false;
};

// ---- measures

struct AbsoluteAngle {  // 2D: direction of AB from +x
  std::string a, b;
};
// 2D: signed from d to e; 3D with axis: atan2(axis . (d x e), d . e); 3D without: in [0, pi], and at these ends it has
// no derivatives (NaN; empty in a CSV), with the status inaccurate, unless it is at rest there.
struct AngleBetween {
  Direction d, e;
  std::string axis;
};
struct MeasuredDistance {  // at 0 as an angle at its ends
  std::string a, b;
};
struct MeasuredCoordinate {
  std::string coordinate;
};
// A constant and multiples of other measures, all of one unit; none of them is a combination.
struct Combination {
  std::vector<std::pair<std::string, double>> terms;  // measure, factor
  double constant = 0;                                // in that unit
};

struct Measure {
  std::string name;
  std::variant<AbsoluteAngle, AngleBetween, MeasuredDistance, MeasuredCoordinate, Combination> kind;
};

struct DeclaredGroup {
  std::string name;
  std::vector<std::string> unknowns;  // points, vectors, auxiliary scalars ("name.lambda")
  bool keep = false;                  // do not shrink to what the outputs need
};

// Seconds; (end - start) / step is a whole number within 1e-9 and the rounding of times, at most 1e12.
struct TimeGrid {
  double start = 0;
  double end = 0;
  double step = 0;

  // N of t_k = start + k * step, k = 0..N
  [[nodiscard]] std::int64_t steps() const { return step > 0 ? std::llround((end - start) / step) : 0; }
  [[nodiscard]] double time(std::int64_t k) const { return start + static_cast<double>(k) * step; }
};

class Scene {
 public:
  [[nodiscard]] const std::string& name() const { return parts_->name; }
  [[nodiscard]] int dimension() const { return parts_->dimension; }
  [[nodiscard]] const std::vector<Point>& points() const { return parts_->points; }
  [[nodiscard]] const std::vector<Vector>& vectors() const { return parts_->vectors; }
  // Each after those whose members its base is made of.
  [[nodiscard]] const std::vector<Body>& bodies() const { return parts_->bodies; }
  [[nodiscard]] const std::vector<Constraint>& constraints() const { return parts_->constraints; }
  [[nodiscard]] const std::vector<Driver>& drivers() const { return parts_->drivers; }
  [[nodiscard]] const std::vector<Measure>& measures() const { return parts_->measures; }
  [[nodiscard]] const std::vector<DeclaredGroup>& groups() const { return parts_->groups; }
  [[nodiscard]] const std::vector<std::string>& outputs() const { return outputs_; }  // as written; empty: everything
  [[nodiscard]] const TimeGrid& time() const { return time_; }
  // The CSV files that its laws were read from, as reading found them.
  [[nodiscard]] const std::vector<std::filesystem::path>& tables() const { return parts_->tables; }
  // Notes that are no errors: a vector that had to be normalised, ...
  [[nodiscard]] const std::vector<Diagnostic>& warnings() const { return parts_->warnings; }

  // The same mechanism with other wanted outputs: "C", "C.velocity", columns such as "C.vx", or "all" alone, which is
  // everything. Throws Error (input) for a name that is not there, with the names that are.
  [[nodiscard]] Scene with_outputs(std::vector<std::string> outputs) const;
  // Over another time grid; throws Error (input) if it has no whole number of steps.
  [[nodiscard]] Scene with_time(TimeGrid time) const;

 private:
  friend class SceneBuilder;
  struct Parts {
    std::string name;
    int dimension = 2;
    std::vector<Point> points;
    std::vector<Vector> vectors;
    std::vector<Body> bodies;
    std::vector<Constraint> constraints;
    std::vector<Driver> drivers;
    std::vector<Measure> measures;
    std::vector<DeclaredGroup> groups;
    std::vector<std::filesystem::path> tables;
    std::vector<Diagnostic> warnings;
  };
  std::shared_ptr<const Parts> parts_ = std::make_shared<const Parts>();  // of all copies
  std::vector<std::string> outputs_;
  TimeGrid time_;
};

// Collects a scene; build() checks it as a whole and reports everything that is wrong in one go. Order does not matter.
class SceneBuilder {
 public:
  SceneBuilder(std::string name, int dimension);

  SceneBuilder& point(std::string name, Triple at) { return add(Point{std::move(name), at, false}); }
  SceneBuilder& fixed_point(std::string name, Triple at) { return add(Point{std::move(name), at, true}); }
  SceneBuilder& vector(std::string name, Triple at, bool unit = true) {
    return add(Vector{std::move(name), at, false, unit});
  }
  SceneBuilder& fixed_vector(std::string name, Triple at) { return add(Vector{std::move(name), at, true, true}); }

  SceneBuilder& add(Point point);
  SceneBuilder& add(Vector vector);
  SceneBuilder& add(Body body);
  SceneBuilder& add(Constraint constraint);
  SceneBuilder& add(Driver driver);
  SceneBuilder& add(Measure measure);
  SceneBuilder& add(DeclaredGroup group);

  template <class Kind>
  SceneBuilder& constrain(std::string name, Kind kind) {
    return add(Constraint{std::move(name), std::move(kind)});
  }
  template <class Kind>
  SceneBuilder& drive(std::string name, Kind kind, bool relative = false) {
    return add(Driver{std::move(name), std::move(kind), relative});
  }
  template <class Kind>
  SceneBuilder& measure(std::string name, Kind kind) {
    return add(Measure{std::move(name), std::move(kind)});
  }
  // Room for as many; a scene may have millions.
  SceneBuilder& reserve(std::size_t points, std::size_t constraints);

  SceneBuilder& output(std::string name);
  SceneBuilder& time(double start, double end, double step);
  SceneBuilder& table(std::filesystem::path file);  // that a law was read from

  // What is already known to be wrong (a reader's own findings), reported together with those of build(), which finds
  // nothing again at, above or below that place. Without `what`: wrong for a reason given elsewhere.
  SceneBuilder& diagnose(Diagnostic diagnostic);

  // Throws Error (input) with every diagnostic.
  // An rvalue is used up, not copied.
  [[nodiscard]] Scene build() const& { return SceneBuilder(*this).finish(); }
  [[nodiscard]] Scene build() && { return finish(); }

 private:
  [[nodiscard]] Scene finish();

  Scene::Parts parts_;
  std::vector<std::string> outputs_;
  TimeGrid time_;
  std::vector<Diagnostic> found_;
};

// Values of parameters that replace those of the scene (`--set name=value`).
using Parameters = std::map<std::string, double>;

// Reads a scene file: a regular file of at most 1 GB. Its tables, CSV files of at most 256 MB, lie in its folder or in
// one of `more_folders`, wherever links lead. Throws Error: kind environment if the file cannot be read, kind input
// with every diagnostic ("FILE: /json/pointer: what") otherwise.
[[nodiscard]] Scene read_scene(const std::filesystem::path& file, const Parameters& set = {},
                               const std::vector<std::filesystem::path>& more_folders = {});

// The same from text; tables are looked up relative to `folder`, `name` stands in front of the diagnostics.
[[nodiscard]] Scene parse_scene(std::string_view text, const std::string& name = "scene",
                                const std::filesystem::path& folder = ".", const Parameters& set = {},
                                const std::vector<std::filesystem::path>& more_folders = {});

// A sample by its text: "stewart", "stewart:legs=22", "four_bar:64", ... Throws Error (input) that lists the samples.
[[nodiscard]] Scene sample(std::string_view text, const Parameters& set = {});

// True if the text before ':' is the name of a sample.
[[nodiscard]] bool is_sample(std::string_view text);

// A file if one of that name exists or only a file can be meant ('/', .json), else a sample: the command's SCENE.
[[nodiscard]] Scene open_scene(const std::string& file_or_sample, const Parameters& set = {},
                               const std::vector<std::filesystem::path>& more_folders = {});

// Many sets of parameters, for an ensemble: a CSV whose first line names them and whose further lines are one set each,
// a regular file of at most 256 MB.
// Throws Error: kind environment if the file cannot be read, kind input with what is wrong ("FILE: line 3, column 2
// (crank): what"). Whether a scene has such parameters is not asked here.
[[nodiscard]] std::vector<Parameters> read_variants(const std::filesystem::path& file);

}  // namespace assur
