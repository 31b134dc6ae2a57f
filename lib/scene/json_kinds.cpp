#include <algorithm>
#include <type_traits>

#include "scene/json_reader.hpp"

namespace assur {
namespace {

constexpr std::string_view kJoints =
    "joints come in a later format version; write bodies that share points and vectors, and the constraints of this "
    "version";
constexpr std::string_view kGear = "a gear is a Callback of the C++ interface and cannot stand in a file";
constexpr std::string_view kOwnCode = "equations of your own code cannot stand in a file; add a Callback in C++";

}  // namespace

// An item has exactly one key that tells its kind. `later`: keys that this version refuses, with the reason.
template <class Item>
void JsonReader::read_kinds(const JsonNode* section, const Where& where, const std::vector<Kind<Item>>& kinds,
                            const std::vector<std::pair<std::string_view, std::string_view>>& later) {
  std::vector<std::string_view> all_keys, kind_keys;
  for (const auto& kind : kinds) {
    kind_keys.push_back(kind.key);
    all_keys.push_back(kind.key);
    all_keys.insert(all_keys.end(), kind.more.begin(), kind.more.end());
  }
  each(section, where, [&](const std::string& name, const JsonNode& node, const Where& here) {
    const auto unreadable = [&] {
      broken(here);
      builder_.add(Item{name, {}});
    };
    if (!node.is(Type::object)) {
      note(here, "an object with one of the keys " + one_of(kind_keys) + " is wanted here, not " +
                     std::string(with_article(node.type())));
      return unreadable();
    }
    for (const auto& [key, reason] : later) {
      if (node.find(key) == nullptr) continue;
      note(here / key, std::string(reason));
      return unreadable();
    }
    std::vector<const Kind<Item>*> told;
    for (const auto& kind : kinds) {
      if (node.find(kind.key) != nullptr) told.push_back(&kind);
    }
    if (told.size() > 1) {
      note(here / told[1]->key,
           "both " + in_quotes(told[0]->key) + " and " + in_quotes(told[1]->key) + " are given; one item has one kind");
      return unreadable();
    }
    if (told.empty()) {
      const auto strange = std::find_if(node.keys().begin(), node.keys().end(),
                                        [&](std::string_view key) { return !near_miss(key, kind_keys).empty(); });
      if (strange == node.keys().end()) {
        note(here, "the kind is missing; expected one of " + one_of(kind_keys));
      } else {
        note(here / *strange, "unknown key " + in_quotes(*strange) + suggestion(*strange, kind_keys));
      }
      return unreadable();
    }
    std::vector<std::string_view> allowed{told[0]->key};
    allowed.insert(allowed.end(), told[0]->more.begin(), told[0]->more.end());
    const Object object(*this, node, here, allowed);
    Item item{name, (this->*told[0]->read)(object, *node.find(told[0]->key))};
    if constexpr (std::is_same_v<Item, Driver>) {
      if (const JsonNode* relative = object.find("relative")) item.relative = boolean(*relative, here / "relative");
    }
    builder_.add(std::move(item));
  });
}

void JsonReader::read_constraints(const JsonNode* section) {
  static const std::vector<Kind<Constraint>> kKinds = {
      {"distance", {"value"}, &JsonReader::distance}, {"equal_distance", {}, &JsonReader::equal_distance},
      {"dot", {"value"}, &JsonReader::dot},           {"parallel", {}, &JsonReader::parallel},
      {"linear", {"value"}, &JsonReader::linear},     {"coordinate", {"value"}, &JsonReader::fixed_coordinate},
      {"on_line", {}, &JsonReader::on_line},          {"on_plane", {}, &JsonReader::on_plane},
  };
  read_kinds<Constraint>(section, Where("/constraints"), kKinds,
                         {{"revolute", kJoints},
                          {"prismatic", kJoints},
                          {"cylindrical", kJoints},
                          {"spherical", kJoints},
                          {"universal", kJoints},
                          {"planar", kJoints},
                          {"callback", kOwnCode},
                          {"gear", kGear}});
}

void JsonReader::read_drivers(const JsonNode* section) {
  static const std::vector<Kind<Driver>> kKinds = {
      {"angle", {"axis", "law", "relative"}, &JsonReader::driven_angle},
      {"distance", {"law", "relative"}, &JsonReader::driven_distance},
      {"coordinate", {"law", "relative"}, &JsonReader::driven_coordinate},
      {"pose", {"translation", "rotation", "relative"}, &JsonReader::pose},
  };
  read_kinds<Driver>(section, Where("/drivers"), kKinds, {});
}

void JsonReader::read_measures(const JsonNode* section) {
  static const std::vector<Kind<Measure>> kKinds = {
      {"angle", {"axis"}, &JsonReader::measured_angle},
      {"distance", {}, &JsonReader::measured_distance},
      {"coordinate", {}, &JsonReader::measured_coordinate},
      {"sum", {"constant"}, &JsonReader::sum},
  };
  read_kinds<Measure>(section, Where("/measures"), kKinds, {});
}

// ---- constraints

decltype(Constraint::kind) JsonReader::distance(const Object& item, const JsonNode& node) {
  auto [p, q] = pair(node, item.where() / "distance");
  Distance c{std::move(p), std::move(q), {}};
  if (const JsonNode* value = item.find("value")) c.value = number(*value, item.where() / "value");
  return c;
}

decltype(Constraint::kind) JsonReader::equal_distance(const Object& item, const JsonNode& node) {
  const Where where = item.where() / "equal_distance";
  const auto pairs = list(node, 2, where, "[[\"P\", \"Q\"], [\"R\", \"S\"]]");
  if (pairs.empty()) return EqualDistance{};
  auto [p, q] = pair(pairs[0], where / std::size_t{0});
  auto [r, s] = pair(pairs[1], where / std::size_t{1});
  return EqualDistance{std::move(p), std::move(q), std::move(r), std::move(s)};
}

decltype(Constraint::kind) JsonReader::dot(const Object& item, const JsonNode& node) {
  const Where where = item.where() / "dot";
  Dot c;
  if (const auto items = list(node, 2, where, "[\"u\", \"v\"]"); !items.empty()) {
    c.d = direction(items[0], where / std::size_t{0});
    c.e = direction(items[1], where / std::size_t{1});
  }
  if (const JsonNode* value = item.find("value")) c.value = number(*value, item.where() / "value");
  return c;
}

decltype(Constraint::kind) JsonReader::parallel(const Object& item, const JsonNode& node) {
  const Where where = item.where() / "parallel";
  const auto items = list(node, 2, where, "[\"u\", \"v\"]");
  if (items.empty()) return Parallel{};
  return Parallel{direction(items[0], where / std::size_t{0}), direction(items[1], where / std::size_t{1})};
}

decltype(Constraint::kind) JsonReader::linear(const Object& item, const JsonNode& node) {
  const Where where = item.where() / "linear";
  Linear c;
  if (expect(node, Type::array, where, "[[\"B\", 2], [\"C\", -1]]")) {
    for (std::size_t i = 0; i < node.items().size(); ++i) {
      const Where here = where / i;
      const auto term = list(node.items()[i], 2, here, "[\"B\", 2]");
      if (term.empty()) {
        c.terms.emplace_back("", 1);
      } else {
        c.terms.emplace_back(text(term[0], here / std::size_t{0}, "\"B\""), number(term[1], here / std::size_t{1}));
      }
    }
  }
  const JsonNode* value = item.find("value");
  if (value == nullptr) return c;
  if (value->is(Type::array)) {
    c.value = triple(*value, item.where() / "value");
  } else {
    const double number_for_each = number(*value, item.where() / "value");
    for (std::size_t k = 0; k < static_cast<std::size_t>(std::max(dimension_, 2)); ++k) c.value[k] = number_for_each;
  }
  return c;
}

decltype(Constraint::kind) JsonReader::fixed_coordinate(const Object& item, const JsonNode& node) {
  FixedCoordinate c{text(node, item.where() / "coordinate", "\"P.x\""), 0};
  if (const JsonNode* value = item.find("value")) {
    c.value = number(*value, item.where() / "value");
  } else {
    note(item.where() / "value", "this is missing: the constant that the coordinate has");
  }
  return c;
}

decltype(Constraint::kind) JsonReader::on_line(const Object& item, const JsonNode& node) {
  const Where where = item.where() / "on_line";
  const auto items = list(node, 3, where, "[\"P\", \"A\", \"d\"]");
  if (items.empty()) return OnLine{};
  return OnLine{text(items[0], where / std::size_t{0}, "\"P\""), text(items[1], where / std::size_t{1}, "\"A\""),
                direction(items[2], where / std::size_t{2})};
}

decltype(Constraint::kind) JsonReader::on_plane(const Object& item, const JsonNode& node) {
  const Where where = item.where() / "on_plane";
  const auto items = list(node, 4, where, "[\"P\", \"A\", \"d\", \"e\"]");
  if (items.empty()) return OnPlane{};
  return OnPlane{text(items[0], where / std::size_t{0}, "\"P\""), text(items[1], where / std::size_t{1}, "\"A\""),
                 direction(items[2], where / std::size_t{2}), direction(items[3], where / std::size_t{3})};
}

// ---- drivers

// Two names of points are the angle of one pair; vectors and pairs are two directions.
decltype(Driver::kind) JsonReader::driven_angle(const Object& item, const JsonNode& node) {
  const Where where = item.where() / "angle";
  std::string axis;
  if (const JsonNode* name = item.find("axis")) axis = text(*name, item.where() / "axis", "\"u\"");
  Law motion = needed_law(item, angle_unit_);
  const auto items = list(node, 2, where, "[\"A\", \"B\"]");
  if (items.empty()) return PointAngle{"", "", std::move(axis), std::move(motion)};
  const Direction d = direction(items[0], where / std::size_t{0});
  const Direction e = direction(items[1], where / std::size_t{1});
  if (!d.is_pair() && !e.is_pair() && (is_point(d.first) || is_point(e.first))) {
    return PointAngle{d.first, e.first, std::move(axis), std::move(motion)};
  }
  return RelativeAngle{d, e, std::move(axis), std::move(motion)};
}

decltype(Driver::kind) JsonReader::driven_distance(const Object& item, const JsonNode& node) {
  auto [a, b] = pair(node, item.where() / "distance");
  return DrivenDistance{std::move(a), std::move(b), needed_law(item, 1)};
}

decltype(Driver::kind) JsonReader::driven_coordinate(const Object& item, const JsonNode& node) {
  return DrivenCoordinate{text(node, item.where() / "coordinate", "\"P.x\""), needed_law(item, 1)};
}

decltype(Driver::kind) JsonReader::pose(const Object& item, const JsonNode& node) {
  Pose pose;
  pose.body = text(node, item.where() / "pose", "\"terminal\"");
  const Where translation = item.where() / "translation", rotation = item.where() / "rotation";
  if (const JsonNode* laws = item.find("translation"); laws == nullptr) {
    note(translation, "this is missing: a list of laws, one for each coordinate of the origin");
  } else if (expect(*laws, Type::array, translation, "[law, law]")) {
    for (std::size_t k = 0; k < laws->items().size(); ++k)
      pose.translation.push_back(law(laws->items()[k], translation / k, 1));
  }
  const JsonNode* node_of_rotation = item.find("rotation");
  if (node_of_rotation == nullptr) return pose;
  if (dimension_ == 2) {
    Object angles(*this, *node_of_rotation, rotation, {"angle"});
    if (const JsonNode* angle = angles.need("angle", "the law of the angle from +x")) {
      pose.rotation.push_back(law(*angle, rotation / "angle", angle_unit_));
    }
  } else {
    Object angles(*this, *node_of_rotation, rotation, {"euler_zyx"});
    const JsonNode* euler = angles.need("euler_zyx", "the laws [psi, theta, phi] of Rz Ry Rx");
    if (euler == nullptr) return pose;
    const auto laws = list(*euler, 3, rotation / "euler_zyx", "[psi, theta, phi]");
    for (std::size_t k = 0; k < laws.size(); ++k) {
      pose.rotation.push_back(law(laws[k], rotation / "euler_zyx" / k, angle_unit_));
    }
  }
  return pose;
}

// ---- measures

decltype(Measure::kind) JsonReader::measured_angle(const Object& item, const JsonNode& node) {
  const Where where = item.where() / "angle";
  const auto items = list(node, 2, where, "[\"A\", \"B\"]");
  if (items.empty()) return AngleBetween{};
  const Direction d = direction(items[0], where / std::size_t{0});
  const Direction e = direction(items[1], where / std::size_t{1});
  const JsonNode* axis = item.find("axis");
  if (!d.is_pair() && !e.is_pair() && (is_point(d.first) || is_point(e.first))) {
    if (axis != nullptr) {
      note(item.where() / "axis",
           "the angle of one pair of points is for the plane and has no axis; write two directions, [[\"A\", \"B\"], "
           "[\"C\", \"D\"]]");
      broken(where);
    }
    return AbsoluteAngle{d.first, e.first};
  }
  return AngleBetween{d, e, axis ? text(*axis, item.where() / "axis", "\"u\"") : ""};
}

decltype(Measure::kind) JsonReader::measured_distance(const Object& item, const JsonNode& node) {
  auto [a, b] = pair(node, item.where() / "distance");
  return MeasuredDistance{std::move(a), std::move(b)};
}

decltype(Measure::kind) JsonReader::measured_coordinate(const Object& item, const JsonNode& node) {
  return MeasuredCoordinate{text(node, item.where() / "coordinate", "\"P.x\"")};
}

decltype(Measure::kind) JsonReader::sum(const Object& item, const JsonNode& node) {
  const Where where = item.where() / "sum";
  Combination c;
  bool of_angles = false;
  if (expect(node, Type::array, where, "[[\"toe\", 1], [\"steer\", -1]]")) {
    for (std::size_t i = 0; i < node.items().size(); ++i) {
      const auto term = list(node.items()[i], 2, where / i, "[\"toe\", 1]");
      if (term.empty()) {
        c.terms.emplace_back("", 1);
        continue;
      }
      c.terms.emplace_back(text(term[0], where / i / std::size_t{0}, "\"toe\""),
                           number(term[1], where / i / std::size_t{1}));
      of_angles = of_angles || is_angle(c.terms.back().first);
    }
  }
  if (const JsonNode* constant = item.find("constant")) {
    c.constant = number(*constant, item.where() / "constant") * (of_angles ? angle_unit_ : 1);
  }
  return c;
}

}  // namespace assur
