// The vocabulary of a scene file: a row for each kind of constraint, driver and measure, and for the other objects. A
// row has the keys of an object, the meaning of their values, and the members that they set. Reading (json_*.cpp),
// writing (json_writer.cpp) and the common checks (validation_vocabulary.hpp) follow the rows. A new kind needs a
// struct in assur/scene.hpp, a row here, its lowering, and a rule() of Validation for conditions beyond the row.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "assur/scene.hpp"

namespace assur::vocabulary {

// Meaning of a value beyond its type.
enum class Means : std::uint8_t {
  plain,     // a number in SI units, or without unit
  angle,     // rad; in the file the unit of its angles
  of_terms,  // in the unit of the measures summed up
  each,      // one number for each coordinate, or one for all of them
  rotation,  // laws: {"angle": law} or {"euler_zyx": [law, law, law]}
  text,      // a name that a rule looks up
  point,     // names of such objects
  vector,
  point_or_vector,
  body,
  measure,
  scalar,  // "P.x", "name.lambda"
};

struct About {
  Means means = Means::plain;
  std::string_view example = {};  // for messages; of a text without quotes
  // The refusal if an entry of a list equals the entry before it. The first {} is that entry, the second {} this one.
  // Empty: they may be equal.
  std::string_view same = {};
};

template <class Struct, class Value>
struct Slot {
  Value Struct::*member;
  About about;
};

// An array with these entries.
template <class... Entries>
struct List {
  std::tuple<Entries...> entries;
};

// The content of a key that is refused.
struct Refused {
  std::string_view why;
};

template <class Content>
struct Key {
  std::string_view name;
  Content content;
  std::string_view missing = {};  // description for the message if the key is missing, {}: coordinates; empty: optional
};

template <class Kind, class... Keys>
struct Row {
  using Struct = Kind;
  std::tuple<Keys...> keys;                    // the first one gives the kind
  std::array<std::string_view, 2> unknowns{};  // those that a constraint adds: "lambda" is NAME.lambda
  std::string_view not_in_the_plane = {};      // reason why a plane scene cannot have it

  // Empty for a row without keys.
  [[nodiscard]] constexpr std::string_view name() const {
    if constexpr (sizeof...(Keys) == 0) {
      return {};
    } else {
      return std::get<0>(keys).name;
    }
  }
  [[nodiscard]] constexpr Row brings(std::string_view first, std::string_view second = {}) const {
    return {keys, {first, second}, not_in_the_plane};
  }
  [[nodiscard]] constexpr Row only_in_space(std::string_view why) const { return {keys, unknowns, why}; }
};

// ---- functions that make rows

template <class Struct, class... Keys>
constexpr Row<Struct, Keys...> row(Keys... keys) {
  return {{keys...}};
}
template <class Content>
constexpr Key<Content> key(std::string_view name, Content content, std::string_view missing = {}) {
  return {name, content, missing};
}
template <class... Entries>
constexpr List<Entries...> list(Entries... entries) {
  return {{entries...}};
}
template <class Struct, class Value>
constexpr Slot<Struct, Value> slot(Value Struct::*member, About about = {}) {
  return {member, about};
}
template <class Struct>
constexpr auto point(std::string Struct::*member, std::string_view example, std::string_view same = {}) {
  return slot(member, {Means::point, example, same});
}
template <class Struct>
constexpr auto direction(Direction Struct::*member, std::string_view example, std::string_view same = {}) {
  return slot(member, {Means::plain, example, same});
}
template <class Struct>
constexpr auto scalar(std::string Struct::*member) {
  return slot(member, {Means::scalar, "P.x"});
}

inline constexpr std::string_view kNoLength = "a distance from {} to itself; two different points are wanted";
inline constexpr std::string_view kNoDirection = "a direction from {} to itself; two different points are wanted";
inline constexpr std::string_view kNoMotion = "the motion, e.g. {\"polynomial\": [0, 1]}";

// ---- the kinds. If two kinds have the same key, the first is for points, the second for directions.

inline constexpr std::tuple kConstraints{
    row<Distance>(key("distance", list(point(&Distance::p, "A"), point(&Distance::q, "B", kNoLength))),
                  key("value", slot(&Distance::value))),
    row<EqualDistance>(
        key("equal_distance", list(list(point(&EqualDistance::p, "P"), point(&EqualDistance::q, "Q", kNoLength)),
                                   list(point(&EqualDistance::r, "R"), point(&EqualDistance::s, "S", kNoLength))))),
    row<Dot>(key("dot", list(direction(&Dot::d, "u"), direction(&Dot::e, "v"))), key("value", slot(&Dot::value))),
    row<Parallel>(key("parallel", list(direction(&Parallel::d, "u"),
                                       direction(&Parallel::e, "v",
                                                 "{} is always parallel to itself; two different directions are "
                                                 "wanted"))))
        .brings("lambda"),
    row<Linear>(key("linear", slot(&Linear::terms, {Means::point_or_vector, R"([["B", 2], ["C", -1]])"})),
                key("value", slot(&Linear::value, {Means::each}))),
    row<FixedCoordinate>(key("coordinate", scalar(&FixedCoordinate::coordinate)),
                         key("value", slot(&FixedCoordinate::value), "the constant that the coordinate has")),
    row<OnLine>(key("on_line", list(point(&OnLine::p, "P"),
                                    point(&OnLine::a, "A",
                                          "{} is always on a line through itself; two different points are wanted"),
                                    direction(&OnLine::d, "d"))))
        .brings("lambda"),
    row<OnPlane>(key("on_plane", list(point(&OnPlane::p, "P"),
                                      point(&OnPlane::a, "A",
                                            "{} is always on a plane through itself; two different points are wanted"),
                                      direction(&OnPlane::d, "d"),
                                      direction(&OnPlane::e, "e", "{} and {} are one direction; a plane needs two"))))
        .brings("lambda", "mu")
        .only_in_space("on_plane is for 3D; in the plane every point is on it"),
    row<Gear>(key("gear", list(slot(&Gear::a, {Means::text, "A.angle"}), slot(&Gear::b, {Means::text, "B.angle"}))),
              key("ratio", slot(&Gear::ratio), "the motion of the second coordinate by that of the first")),
    row<Callback>(
        key("callback", Refused{"equations of your own code cannot be written in a file; add a Callback in C++"})),
};

inline constexpr std::tuple kDrivers{
    row<PointAngle>(key("angle", list(point(&PointAngle::a, "A"), point(&PointAngle::b, "B", kNoDirection))),
                    key("axis", slot(&PointAngle::axis)),
                    key("law", slot(&PointAngle::law, {Means::angle}), kNoMotion)),
    row<RelativeAngle>(
        key("angle", list(direction(&RelativeAngle::d, "A"),
                          direction(&RelativeAngle::e, "B",
                                    "an angle from a direction to itself; two different directions are wanted"))),
        key("axis", slot(&RelativeAngle::axis)), key("law", slot(&RelativeAngle::law, {Means::angle}), kNoMotion)),
    row<DrivenDistance>(
        key("distance", list(point(&DrivenDistance::a, "A"), point(&DrivenDistance::b, "B", kNoLength))),
        key("law", slot(&DrivenDistance::law), kNoMotion)),
    row<DrivenCoordinate>(key("coordinate", scalar(&DrivenCoordinate::coordinate)),
                          key("law", slot(&DrivenCoordinate::law), kNoMotion)),
    row<Pose>(key("pose", slot(&Pose::body, {Means::body, "terminal"})),
              key("translation", slot(&Pose::translation), "a list of laws, one for each coordinate of the origin"),
              key("rotation", slot(&Pose::rotation, {Means::rotation}))),
};

inline constexpr std::tuple kMeasures{
    row<AbsoluteAngle>(
        key("angle", list(point(&AbsoluteAngle::a, "A"), point(&AbsoluteAngle::b, "B", kNoDirection))),
        key("axis", Refused{"the angle of one pair of points is for the plane and has no axis; write two directions, "
                            R"([["A", "B"], ["C", "D"]])"})),
    row<AngleBetween>(key("angle", list(direction(&AngleBetween::d, "A"), direction(&AngleBetween::e, "B"))),
                      key("axis", slot(&AngleBetween::axis))),
    row<MeasuredDistance>(
        key("distance", list(point(&MeasuredDistance::a, "A"), point(&MeasuredDistance::b, "B", kNoLength)))),
    row<MeasuredCoordinate>(key("coordinate", scalar(&MeasuredCoordinate::coordinate))),
    row<Combination>(key("sum", slot(&Combination::terms, {Means::measure, R"([["toe", 1], ["steer", -1]])"})),
                     key("constant", slot(&Combination::constant, {Means::of_terms}))),
    row<Orientation>(key("orientation", Refused{"the orientation of a body is an output: write the name of the body"})),
};

template <class Kind>
constexpr auto two_bodies() {
  return list(slot(&Kind::a, {Means::text, "frame"}), slot(&Kind::b, {Means::text, "crank"}));
}
inline constexpr std::string_view kAnyPlace = "a place on the axis, {} in the ground as written or the name of a point";
inline constexpr std::string_view kAxis = "the axis, {} or the name of a vector";

inline constexpr std::tuple kJoints{
    row<Revolute>(key("revolute", two_bodies<Revolute>()), key("at", slot(&Revolute::at), kAnyPlace),
                  key("axis", slot(&Revolute::axis))),
    row<Prismatic>(key("prismatic", two_bodies<Prismatic>()), key("axis", slot(&Prismatic::axis), kAxis)),
    row<Cylindrical>(key("cylindrical", two_bodies<Cylindrical>()), key("at", slot(&Cylindrical::at), kAnyPlace),
                     key("axis", slot(&Cylindrical::axis), kAxis)),
    row<Spherical>(key("spherical", two_bodies<Spherical>()),
                   key("at", slot(&Spherical::at), "the centre, {} in the ground as written or the name of a point")),
    row<Universal>(
        key("universal", two_bodies<Universal>()),
        key("at", slot(&Universal::at), "the centre, {} in the ground as written or the name of a point"),
        key("axes", list(slot(&Universal::axis_a, {Means::plain, "u"}), slot(&Universal::axis_b, {Means::plain, "v"})),
            "the axis of the first body and that of the second one")),
    row<Planar>(key("planar", two_bodies<Planar>()),
                key("normal", slot(&Planar::normal), "the normal of the plane, {} or the name of a vector")),
    row<Fixed>(key("fixed", two_bodies<Fixed>())),
};

// Kinds that are not constraints.
inline constexpr Refused kJointElsewhere{"this is a joint; joints have a section of their own, \"joints\""};
inline constexpr std::pair<std::string_view, Refused> kNoConstraints[] = {
    {"revolute", kJointElsewhere},  {"prismatic", kJointElsewhere}, {"cylindrical", kJointElsewhere},
    {"spherical", kJointElsewhere}, {"universal", kJointElsewhere}, {"planar", kJointElsewhere}};
static_assert(std::size(kNoConstraints) + 1 ==
              std::tuple_size_v<decltype(kJoints)>);  // "fixed" fixes a coordinate, too

// ---- other objects

inline constexpr auto kDriver = row<Driver>(key("relative", slot(&Driver::relative)));  // keys of every kind
inline constexpr auto kJoint = row<Joint>();
inline constexpr auto kConstraint = row<Constraint>();
inline constexpr auto kMeasure = row<Measure>();
inline constexpr auto kPoint =
    row<Point>(key("at", slot(&Point::at), "the position {}"), key("fixed", slot(&Point::fixed)));
inline constexpr auto kVector = row<Vector>(key("at", slot(&Vector::at), "the direction {}"),
                                            key("fixed", slot(&Vector::fixed)), key("unit", slot(&Vector::unit)));
inline constexpr auto kBody = row<Body>(
    key("origin", slot(&Body::origin, {Means::text, "O"})), key("frame", slot(&Body::frame, {Means::text, "u"})),
    key("base", slot(&Body::base, {Means::text, "A"})), key("points", slot(&Body::points)),
    key("vectors", slot(&Body::vectors)), key("rigid", slot(&Body::rigid, {Means::text, "A"})));
inline constexpr auto kMember =
    row<Member>(key("at", slot(&Member::local), "the ground coordinates in the posture as written"));
inline constexpr auto kGroup = row<DeclaredGroup>(
    key("unknowns", slot(&DeclaredGroup::unknowns, {Means::text, "B"}), "the names of points and vectors"),
    key("keep", slot(&DeclaredGroup::keep)));
inline constexpr auto kLimit =
    row<Limit>(key("min", slot(&Limit::min)), key("max", slot(&Limit::max)), key("reaction", slot(&Limit::reaction)));
inline constexpr auto kTime = row<TimeGrid>(key("start", slot(&TimeGrid::start), "the first time, s"),
                                            key("end", slot(&TimeGrid::end), "the last time, s"),
                                            key("step", slot(&TimeGrid::step), "the time step, s"));
inline constexpr auto kHarmonic =
    row<Harmonic>(key("amplitude", slot(&Harmonic::amplitude), "the amplitude of the sine"),  // in the unit of its law
                  key("frequency", slot(&Harmonic::frequency), "the frequency in Hz"),
                  key("phase", slot(&Harmonic::phase, {Means::angle})));

// ---- functions that read rows

template <class Kind, std::size_t I = 0, class... Rows>
constexpr const auto& find(const std::tuple<Rows...>& rows) {
  static_assert(I < sizeof...(Rows), "the kind has no row");
  if constexpr (std::is_same_v<typename std::tuple_element_t<I, std::tuple<Rows...>>::Struct, Kind>) {
    return std::get<I>(rows);
  } else {
    return find<Kind, I + 1>(rows);
  }
}

inline constexpr auto kKinds = std::tuple_cat(kJoints, kConstraints, kDrivers, kMeasures);

template <class Kind>
constexpr const auto& row_of() {
  return find<Kind>(kKinds);
}

// visit(key) for each key of a row, in its order.
template <class Row, class Visitor>
constexpr void for_each_key(const Row& row, Visitor&& visit) {
  std::apply([&](const auto&... key) { (visit(key), ...); }, row.keys);
}

template <class Content>
inline constexpr bool is_refused = std::is_same_v<Content, Refused>;

// Allowed and refused keys of an object.
struct Keys {
  std::vector<std::string_view> allowed;
  std::vector<std::pair<std::string_view, Refused>> refused = {};

  template <class Row>
  void add(const Row& row) {
    for_each_key(row, [&]<class Content>(const Key<Content>& key) {
      if constexpr (is_refused<Content>) {
        refused.emplace_back(key.name, key.content);
      } else {
        allowed.push_back(key.name);
      }
    });
  }
};

template <class... Rows>
Keys keys_of(const Rows&... rows) {
  Keys keys;
  (keys.add(rows), ...);
  return keys;
}

}  // namespace assur::vocabulary
