#include <algorithm>
#include <type_traits>

#include "files/json_reader.hpp"

namespace assur {

template <class Item>
struct JsonReader::Kind {
  std::string_view key;
  vocabulary::Keys keys;
  void (*read)(JsonReader& reader, Object& object, Item& item);
};

// Exactly one key of an item gives its kind. own: keys that items of all kinds may have. told: keys that are refused
// with a message; the keys of the kinds are added.
template <class Item, class Row, class... Rows>
void JsonReader::read_kinds(const JsonNode* section, const Where& where, const Row& own,
                            const std::tuple<Rows...>& rows, vocabulary::Keys told) {
  std::vector<Kind<Item>> kinds;
  const auto add = [&]<class Struct, class... Keys>(const vocabulary::Row<Struct, Keys...>& row) {
    const auto& content = std::get<0>(row.keys).content;
    if constexpr (vocabulary::is_refused<std::remove_cvref_t<decltype(content)>>) {
      told.refused.emplace_back(row.name(), content);
    } else {
      if (kinds.empty() || kinds.back().key != row.name()) told.allowed.push_back(row.name());
      kinds.push_back({row.name(), vocabulary::keys_of(row, own), [](JsonReader& reader, Object& object, Item& item) {
                         Struct read;
                         reader.fill(read, object, vocabulary::row_of<Struct>());
                         item.kind = std::move(read);
                       }});
    }
  };
  std::apply([&](const auto&... row) { (add(row), ...); }, rows);

  each(section, where, [&](const std::string& name, const ValueAt& at) {
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
const JsonReader::Kind<Item>* JsonReader::told_kind(const std::vector<Kind<Item>>& kinds, const vocabulary::Keys& keys,
                                                    const ValueAt& at) {
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
  read_kinds<Constraint>(section, Where("/constraints"), vocabulary::kConstraint, vocabulary::kConstraints,
                         {{}, {std::begin(vocabulary::kNoConstraints), std::end(vocabulary::kNoConstraints)}});
}

void JsonReader::read_joints(const JsonNode* section) {
  read_kinds<Joint>(section, Where("/joints"), vocabulary::kJoint, vocabulary::kJoints, {});
}

void JsonReader::read_drivers(const JsonNode* section) {
  read_kinds<Driver>(section, Where("/drivers"), vocabulary::kDriver, vocabulary::kDrivers, {});
}

void JsonReader::read_measures(const JsonNode* section) {
  read_kinds<Measure>(section, Where("/measures"), vocabulary::kMeasure, vocabulary::kMeasures, {});
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
void JsonReader::put(DrivenCoordinate& out, const vocabulary::Slot<DrivenCoordinate, Law>&, const ValueAt& at) {
  out.law = law(at, out.coordinate.ends_with(".angle") ? angle_unit_ : 1);
}

void JsonReader::put(Limit& out, const vocabulary::Slot<Limit, Number>& bound, const ValueAt& at) {
  const bool of_angle = out.quantity.ends_with(".angle") || angle_names_.contains(out.quantity);
  out.*bound.member = number(at) * (of_angle ? angle_unit_ : 1);
}

void JsonReader::put(Combination& out, const vocabulary::Slot<Combination, Number>&, const ValueAt& at) {
  const bool of_angles = std::any_of(out.terms.begin(), out.terms.end(),
                                     [&](const auto& term) { return angle_names_.count(term.first) != 0; });
  out.constant = number(at) * (of_angles ? angle_unit_ : 1);
}

}  // namespace assur
