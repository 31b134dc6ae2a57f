#include <algorithm>
#include <type_traits>

#include "files/json_reader.hpp"

namespace assur {

template <class Item>
struct JsonReader::Kind {
  std::string_view key;
  rows::Keys keys;
  void (*read)(JsonReader& reader, Object& object, Item& item);
};

// Exactly one key of an item gives its kind. own: keys that items of all kinds may have. told: keys that are refused
// with a message; the keys of the kinds are added.
template <class Item, class Row, class... Rows>
void JsonReader::read_kinds(const JsonNode* section, const Where& where, const Row& own,
                            const std::tuple<Rows...>& rows, rows::Keys told) {
  std::vector<Kind<Item>> kinds;
  const auto add = [&]<class Struct, class... Keys>(const rows::Row<Struct, Keys...>& row) {
    const auto& content = std::get<0>(row.keys).content;
    if constexpr (rows::is_refused<std::remove_cvref_t<decltype(content)>>) {
      told.refused.emplace_back(row.name(), content);
    } else {
      if (kinds.empty() || kinds.back().key != row.name()) told.allowed.push_back(row.name());
      kinds.push_back({row.name(), rows::keys_of(row, own), [](JsonReader& reader, Object& object, Item& item) {
                         Struct read;
                         reader.fill(read, object, rows::row_of<Struct>());
                         item.kind = std::move(read);
                       }});
    }
  };
  std::apply([&](const auto&... row) { (add(row), ...); }, rows);

  each(section, where, [&](const std::string& name, const Place& at) {
    Item item{name, {}};
    const Kind<Item>* kind = told_kind(kinds, told, at);
    if (kind != nullptr) {
      Object object(*this, at, kind->keys);
      kind->read(*this, object, item);
      fill(item, object, own);
    } else {
      broken(at.where);
    }
    builder_.add(std::move(item));
  });
}

// Null if a finding was reported.
template <class Item>
const JsonReader::Kind<Item>* JsonReader::told_kind(const std::vector<Kind<Item>>& kinds, const rows::Keys& keys,
                                                    const Place& at) {
  const auto& [node, where] = at;
  if (!node.is(Type::object)) {
    note(where, "an object with one of the keys " + one_of(keys.allowed) + " is wanted here, not " +
                    std::string(with_article(node.type())));
    return nullptr;
  }
  for (const auto& [key, refused] : keys.refused) {
    if (node.find(key) != nullptr && is_refused(key, keys, where)) return nullptr;
  }
  const Kind<Item>* told = nullptr;
  for (const Kind<Item>& kind : kinds) {
    const JsonNode* content = node.find(kind.key);
    if (content == nullptr) continue;
    if (told != nullptr && told->key != kind.key) {
      note(where / kind.key,
           "both " + in_quotes(told->key) + " and " + in_quotes(kind.key) + " are given; an item has exactly one kind");
      return nullptr;
    }
    if (told == nullptr || !is_pair_of_points(*content)) told = &kind;
  }
  if (told != nullptr) return told;
  const auto strange = std::find_if(node.keys().begin(), node.keys().end(),
                                    [&](std::string_view key) { return !near_miss(key, keys.allowed).empty(); });
  if (strange == node.keys().end()) {
    note(where, "the kind is missing; expected one of " + one_of(keys.allowed));
  } else {
    note(where / *strange, "unknown key " + in_quotes(*strange) + suggestion(*strange, keys.allowed));
  }
  return nullptr;
}

void JsonReader::read_constraints(const JsonNode* section) {
  read_kinds<Constraint>(section, Where("/constraints"), rows::kConstraint, rows::kConstraints,
                         {{}, {std::begin(rows::kNoConstraints), std::end(rows::kNoConstraints)}});
}

void JsonReader::read_joints(const JsonNode* section) {
  read_kinds<Joint>(section, Where("/joints"), rows::kJoint, rows::kJoints, {});
}

void JsonReader::read_drivers(const JsonNode* section) {
  read_kinds<Driver>(section, Where("/drivers"), rows::kDriver, rows::kDrivers, {});
}

void JsonReader::read_measures(const JsonNode* section) {
  read_kinds<Measure>(section, Where("/measures"), rows::kMeasure, rows::kMeasures, {});
}

// True for two names, at least one of them a point: then the angle is that of one pair, not between two directions.
bool JsonReader::is_pair_of_points(const JsonNode& node) const {
  const auto items = node.items();
  const auto is_pair = [](const JsonNode& item) { return item.items().size() == 2; };
  const auto is_point = [&](const JsonNode& item) { return point_names_.count(item.text()) != 0; };
  return items.size() == 2 && std::none_of(items.begin(), items.end(), is_pair) &&
         std::any_of(items.begin(), items.end(), is_point);
}

// The angle of a joint is in the unit of angles.
void JsonReader::put(DrivenCoordinate& out, const rows::Slot<DrivenCoordinate, Law>&, const Place& at) {
  out.law = law(at, out.coordinate.ends_with(".angle") ? angle_unit_ : 1);
}

void JsonReader::put(Limit& out, const rows::Slot<Limit, Number>& bound, const Place& at) {
  const bool of_angle = out.quantity.ends_with(".angle") || angle_names_.contains(out.quantity);
  out.*bound.member = number(at) * (of_angle ? angle_unit_ : 1);
}

void JsonReader::put(Combination& out, const rows::Slot<Combination, Number>&, const Place& at) {
  const bool of_angles = std::any_of(out.terms.begin(), out.terms.end(),
                                     [&](const auto& term) { return angle_names_.count(term.first) != 0; });
  out.constant = number(at) * (of_angles ? angle_unit_ : 1);
}

}  // namespace assur
