// Checks the meaning of a scene: names, kinds, values, geometry.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "assur/scene.hpp"
#include "scene/names.hpp"
#include "scene/symbols.hpp"
#include "scene/vocabulary.hpp"

namespace assur {

// Names of the unknowns that a constraint adds, such as "lambda"; true if `part` is one of them.
[[nodiscard]] std::span<const std::string_view> auxiliaries(const Constraint& constraint);
[[nodiscard]] bool has_auxiliary(const Constraint& constraint, std::string_view part);

// One check of one scene. Places are those of the scene format, also for scenes built in C++.
class Validation {
 public:
  // `known`: earlier findings; nothing else is reported at, above or below their places.
  Validation(const Scene& scene, const std::vector<Diagnostic>& known);

  // Every finding, in the order of the scene format's sections.
  [[nodiscard]] std::vector<Diagnostic> scene();
  // Checks only outputs, or only times and what depends on them, for Scene::with_outputs and Scene::with_time.
  [[nodiscard]] std::vector<Diagnostic> outputs();
  [[nodiscard]] std::vector<Diagnostic> time();

  // Local coordinates of a member that was given in ground coordinates. To be called after scene() without findings.
  [[nodiscard]] const Triple& local(const std::string& member) const { return local_.at(member); }

  // Indices of bodies; each body comes after the bodies that own its base. To be called after scene().
  [[nodiscard]] const std::vector<std::size_t>& body_order() const { return body_order_; }

 private:
  // An object that a constraint, driver or measure refers to.
  struct Involved {
    bool usable = false;  // found, and not broken
    bool fixed = false;
    Triple at{};                        // of a direction: its components
    const std::string* name = nullptr;  // of a pair: the first one
    const std::string* to = nullptr;    // of a pair: the second one

    [[nodiscard]] bool is(const Involved& other) const;  // equal; a pair in either order
    [[nodiscard]] std::string text() const;              // 'u', [A, B]
  };

  void report(const Where& where, std::string what);
  [[nodiscard]] std::vector<Diagnostic> sorted();
  [[nodiscard]] int dimension() const { return scene_.dimension(); }

  // names (validation.cpp)
  const Symbol* want(const std::string& name, NameKind kind, const Where& where);
  Involved one(NameKind kind, const std::string& name, const Where& where);
  Involved point(const std::string& name, const Where& where) { return one(NameKind::point, name, where); }
  Involved vector(const std::string& name, const Where& where) { return one(NameKind::vector, name, where); }
  Involved point_or_vector(const std::string& name, const Where& where);
  Involved direction(const Direction& direction, const Where& where);
  void check_axis(const std::string& name, std::initializer_list<std::pair<const Direction&, Involved>> of,
                  const Where& where);
  Involved scalar(const std::string& text, const Where& where);  // "P.x", "name.lambda"
  Involved pair(const Involved& from, const Involved& to, const Direction& names, const Where& where);
  // names_all: lists all names if none is near.
  void unknown_name(const std::string& name, std::initializer_list<NameKind> kinds, const Where& where,
                    bool names_all = false);
  bool finite(const Number& number, const Where& where);

  // rows of vocabulary.hpp: names, numbers and laws, and the objects that they refer to (validation_vocabulary.hpp).
  // False if an entry of a list equals the entry before it; the rule of the kind is then skipped.
  template <class Kind>
  bool check_row(const Kind& kind, const Where& where);
  template <class Kind, class... Entries>
  bool check_content(const Kind& kind, const vocabulary::List<Entries...>& list, const Where& where);
  template <class Kind, class Value>
  bool check_content(const Kind& kind, const vocabulary::Slot<Kind, Value>& slot, const Where& where) {
    check_value(kind.*slot.member, slot.about, where);
    return true;
  }
  template <class Kind>
  bool check_content(const Kind&, const vocabulary::Refused&, const Where&) {
    return true;
  }
  void check_value(const std::string& name, const vocabulary::About& about, const Where& where);
  void check_value(const Anchor&, const vocabulary::About&, const Where&) {}  // the rules of the kinds look at axes
  void check_value(const Direction& way, const vocabulary::About& about, const Where& where);
  void check_value(const Number& number, const vocabulary::About& about, const Where& where);
  void check_value(const std::optional<Number>& number, const vocabulary::About& about, const Where& where);
  void check_value(const Triple& numbers, const vocabulary::About& about, const Where& where);
  void check_value(const std::vector<std::pair<std::string, Number>>& terms, const vocabulary::About& about,
                   const Where& where);
  void check_value(const Law& law, const vocabulary::About& about, const Where& where);
  void check_value(const std::vector<Law>& laws, const vocabulary::About& about, const Where& where);
  bool check_differ(const vocabulary::About& about, const Where& where);
  bool all_fixed() const;

  // points, vectors, time (validation.cpp)
  void check_points();
  void check_vectors();
  void check_triple(const Triple& at, const Where& where, bool is_direction);
  void check_time();

  // bodies (validation_bodies.cpp)
  void check_bodies();
  void order_bodies();
  void check_base(const Body& body, const Where& where);
  // The direction of entry i >= 1 of a base as written: a vector, or from the first point to this one.
  [[nodiscard]] Triple base_direction(const Body& body, std::size_t i) const;
  void check_frame(const Body& body, const Where& where);
  void check_fixed_axes(const Body& body, const std::vector<Involved>& axes, const Where& where);
  void place_members(const Body& body, const Where& where);

  // constraints (validation_constraints.cpp)
  void check_constraints();
  void check(const Callback& c, const Where& where);
  template <class Kind>
  void check(const Kind& kind, const Where& where);
  // Conditions beyond the row of a kind.
  template <class Kind>
  void rule(const Kind&, const Where&) {}
  void rule(const Distance& c, const Where& where);
  void rule(const EqualDistance& c, const Where& where);
  void rule(const Dot& c, const Where& where);
  void rule(const Linear& c, const Where& where);

  // drivers (validation_drivers.cpp)
  void check_drivers();
  void rule(const PointAngle& d, const Driver& driver, const Where& where);
  void rule(const RelativeAngle& d, const Driver& driver, const Where& where);
  void rule(const DrivenDistance& d, const Driver& driver, const Where& where);
  void rule(const DrivenCoordinate& d, const Driver& driver, const Where& where);
  void rule(const Pose& d, const Driver& driver, const Where& where);
  void check_law(const Law& law, const Where& where);
  void check_arm(const PointAngle& d, const Involved& a, const Involved& b, const Where& where);
  // The constraints that keep the distance of two points.
  using Kept = std::unordered_multimap<std::string, const Constraint*>;
  [[nodiscard]] std::pair<Kept::const_iterator, Kept::const_iterator> kept_distances(const std::string& a,
                                                                                     const std::string& b);
  // The driver of the distance of two points; null: there is none. Searches all drivers.
  [[nodiscard]] const DrivenDistance* driven_distance(const std::string& a, const std::string& b) const;
  void claim(const std::string& what, const Driver& driver, const Where& where);
  void claim_point(const std::string& name, const Driver& driver, const Where& where);

  // measures, limits, groups, outputs (validation_outputs.cpp)
  void check_measures();
  void rule(const AbsoluteAngle& m, const Where& where);
  void rule(const AngleBetween& m, const Where& where);
  void rule(const Combination& m, const Where& where);
  void check_limits();
  void check_limit(const Limit& limit, const Where& where);
  void check_groups();
  void check_unknown(const std::string& name, const Where& where);
  void check_outputs();
  void check_output(const std::string& text, const Where& where);
  [[nodiscard]] int auxiliary(const Symbol& symbol, const std::string& name) const;

  const Scene& scene_;
  FindingsByPlace known_;
  Symbols symbols_;
  std::vector<Diagnostic> found_;
  std::vector<std::size_t> body_order_;
  std::unordered_map<std::string, Triple> local_;         // of members given in the ground
  std::unordered_map<std::string, std::string> claimed_;  // driven quantity -> name of its driver
  std::optional<Kept> kept_;                              // when it was asked for
  std::vector<Involved> involved_;                        // of the current item, in the order of its row
  bool is_made_ = false;        // the current constraint is one of a joint, which may connect parts that do not move
  int suggestions_left_ = 100;  // each compares all names; the limit keeps scenes full of unknown names fast
};

}  // namespace assur
