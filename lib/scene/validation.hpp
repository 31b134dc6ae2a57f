// What makes a scene wrong, apart from the shape of its file: names, kinds, values, geometry.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "assur/scene.hpp"
#include "scene/names.hpp"
#include "scene/symbols.hpp"

namespace assur {

// True if the constraint brings along an unknown "lambda" or "mu".
[[nodiscard]] bool has_auxiliary(const Constraint& constraint, std::string_view part);

// One check of one scene. Places are those of the scene format, also for scenes built in C++.
class Validation {
 public:
  // `known`: findings made before; nothing is found again at, above or below their places.
  Validation(const Scene& scene, const std::vector<Diagnostic>& known);

  // Every finding, in the order of the scene format's sections.
  [[nodiscard]] std::vector<Diagnostic> scene();
  // Only what Scene::with_outputs and Scene::with_time can make wrong.
  [[nodiscard]] std::vector<Diagnostic> outputs();
  [[nodiscard]] std::vector<Diagnostic> time();

  // Local coordinates of a member whose coordinates were given in the ground. Valid after scene(), without findings.
  [[nodiscard]] const Triple& local(const std::string& member) const { return local_.at(member); }

  // Indices of bodies such that each comes after the bodies that own its base. Valid after scene().
  [[nodiscard]] const std::vector<std::size_t>& body_order() const { return body_order_; }

 private:
  // A point, vector or direction that a constraint, driver or measure involves.
  struct Involved {
    bool usable = false;  // found, and nothing about it is broken
    bool fixed = false;
    Triple at{};  // of a direction: its components
  };
  // "P.x", "name.lambda"
  struct Scalar {
    bool usable = false;
    bool fixed = false;
  };

  void report(const Where& where, std::string what);
  [[nodiscard]] std::vector<Diagnostic> sorted();
  [[nodiscard]] int dimension() const { return scene_.dimension(); }

  // names (validation.cpp)
  const Symbol* want(const std::string& name, NameKind kind, const Where& where);
  Involved point(const std::string& name, const Where& where);
  Involved vector(const std::string& name, const Where& where);
  Involved point_or_vector(const std::string& name, const Where& where);
  Involved direction(const Direction& direction, const Where& where);
  void check_axis(const std::string& name, std::initializer_list<std::pair<const Direction&, Involved>> of,
                  const Where& where);
  Scalar scalar(const std::string& text, const Where& where);
  void unknown_name(const std::string& name, std::initializer_list<NameKind> kinds, const Where& where);
  bool finite(double number, const Where& where);

  // points, vectors, time (validation.cpp)
  void check_points();
  void check_vectors();
  void check_triple(const Triple& at, const Where& where, bool is_direction);
  void check_time();

  // bodies (validation_bodies.cpp)
  void check_bodies();
  void order_bodies();
  void check_base(const Body& body, const Where& where);
  void check_frame(const Body& body, const Where& where);
  void check_fixed_axes(const Body& body, const std::vector<Involved>& axes, const Where& where);
  void place_members(const Body& body, const Where& where);

  // constraints (validation_constraints.cpp)
  void check_constraints();
  void check(const Distance& c, const Where& where);
  void check(const EqualDistance& c, const Where& where);
  void check(const Dot& c, const Where& where);
  void check(const Parallel& c, const Where& where);
  void check(const Linear& c, const Where& where);
  void check(const FixedCoordinate& c, const Where& where);
  void check(const OnLine& c, const Where& where);
  void check(const OnPlane& c, const Where& where);
  void check(const Callback& c, const Where& where);
  void check_moves(std::initializer_list<Involved> involved, const Where& where);

  // drivers (validation_drivers.cpp)
  void check_drivers();
  void check(const PointAngle& d, const Driver& driver, const Where& where);
  void check(const RelativeAngle& d, const Driver& driver, const Where& where);
  void check(const DrivenDistance& d, const Driver& driver, const Where& where);
  void check(const DrivenCoordinate& d, const Driver& driver, const Where& where);
  void check(const Pose& d, const Driver& driver, const Where& where);
  void check_law(const Law& law, const Where& where);
  void check_arm(const PointAngle& d, const Involved& a, const Involved& b, const Where& where);
  void check_driven(std::initializer_list<Involved> involved, const Where& where);
  void claim(const std::string& what, const Driver& driver, const Where& where);
  void claim_point(const std::string& name, const Driver& driver, const Where& where);

  // measures, groups, outputs (validation_outputs.cpp)
  void check_measures();
  void check(const AbsoluteAngle& m, const Where& where);
  void check(const AngleBetween& m, const Where& where);
  void check(const MeasuredDistance& m, const Where& where);
  void check(const MeasuredCoordinate& m, const Where& where);
  void check(const Combination& m, const Where& where);
  void check_groups();
  void check_unknown(const std::string& name, const Where& where);
  void check_outputs();
  void check_output(const std::string& text, const Where& where);
  [[nodiscard]] int auxiliary(const Symbol& symbol, const std::string& name) const;

  const Scene& scene_;
  Known known_;
  Symbols symbols_;
  std::vector<Diagnostic> found_;
  std::vector<std::size_t> body_order_;
  std::unordered_map<std::string, Triple> local_;         // of members given in the ground
  std::unordered_map<std::string, std::string> claimed_;  // what is driven -> name of its driver
  int suggestions_left_ = 100;  // each looks at every name: a scene full of unknown names stays fast
};

}  // namespace assur
