#include "files/json_reader.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "numbers.hpp"

namespace assur {

JsonReader::JsonReader(const JsonDocument& document, TableFolders tables, const Parameters& set)
    : document_(document), tables_(std::move(tables)), set_(set), findings_(document.findings) {}

void JsonReader::note(const Where& where, std::string what) { findings_.push_back({where.text(), std::move(what)}); }

bool JsonReader::expect(const ValueAt& at, Type type, std::string_view example) {
  if (at.node.is(type)) return true;
  note(at.where, std::string(with_article(type)) + " is wanted here" +
                     (example.empty() ? "" : ", e.g. " + std::string(example)) + ", not " +
                     std::string(with_article(at.node.type())));
  return false;
}

bool JsonReader::is_refused(std::string_view key, const vocabulary::Keys& keys, const Where& where) {
  for (const auto& [refused, reason] : keys.refused) {
    if (key != refused) continue;
    note(where / key, std::string(reason.why));
    broken(where);
    return true;
  }
  return false;
}

// ---- objects

JsonReader::Object::Object(JsonReader& reader, const ValueAt& at, const vocabulary::Keys& keys)
    : reader_(reader), node_(at.node.is(Type::object) ? &at.node : nullptr), where_(at.where) {
  const std::vector<std::string_view>& allowed = keys.allowed;
  if (node_ == nullptr) {
    reader_.note(where_, "an object with the keys " + list_of(allowed) + " is wanted here, not " +
                             std::string(with_article(at.node.type())));
    return;
  }
  const auto is_allowed = [&](std::string_view key) {
    return std::find(allowed.begin(), allowed.end(), key) != allowed.end();
  };
  if (std::all_of(at.node.keys().begin(), at.node.keys().end(), is_allowed)) return;
  std::vector<std::string_view> absent;
  for (const std::string_view name : allowed) {
    if (find(name) == nullptr) absent.push_back(name);
  }
  for (const std::string_view key : at.node.keys()) {
    if (is_allowed(key)) continue;
    if (reader_.is_refused(key, keys, where_)) continue;
    const bool only_one_fits = allowed.size() == 1 && absent.size() == 1;
    const std::string near = near_miss(key, absent);
    const std::string hint =
        !near.empty() ? "; did you mean " + in_quotes(near) + "?" : "; expected " + one_of(allowed);
    reader_.note(where_ / key, "unknown key " + in_quotes(key) + hint);
    if (near.empty() && !only_one_fits) continue;
    misspelt_.emplace(near.empty() ? allowed[0] : near);
    reader_.broken(where_ / (near.empty() ? allowed[0] : near));
  }
}

const JsonNode* JsonReader::Object::need(std::string_view key, std::string_view what) {
  const JsonNode* node = find(key);
  if (node == nullptr && node_ != nullptr && misspelt_.count(std::string(key)) == 0) {
    const std::string_view coordinates = reader_.dimension_ == 3 ? "[x, y, z]" : "[x, y]";
    reader_.note(where_ / key, "this is missing: " + filled(what, coordinates));
  }
  return node;
}

// ---- values

Number JsonReader::number(const ValueAt& at) {
  if (at.node.is(Type::number)) return at.node.number();
  const std::string_view text = at.node.text();
  if (text.starts_with('=')) {
    const Expressions::Result result = expressions_.evaluate(std::string(text.substr(1)));
    if (result.ok()) return result.value;
    note(at.where, result.what);
  } else {
    note(at.where, "a number is wanted here, not " +
                       (at.node.is(Type::string) ? "the text " + in_quotes(text) + "; an expression begins with '='"
                                                 : std::string(with_article(at.node.type()))));
  }
  return kNan;
}

Triple JsonReader::triple(const ValueAt& at) {
  const Triple nowhere{kNan, kNan, kNan};
  if (!expect(at, Type::array, dimension_ == 3 ? "[0, 0, 0]" : "[0, 0]")) return nowhere;
  const std::size_t size = at.size();
  if (dimension_ != 0 ? size != static_cast<std::size_t>(dimension_) : size != 2 && size != 3) {
    note(at.where, (dimension_ == 2   ? "2 numbers [x, y] are wanted in a scene of dimension 2, not "
                    : dimension_ == 3 ? "3 numbers [x, y, z] are wanted in a scene of dimension 3, not "
                                      : "2 or 3 numbers are wanted here, not ") +
                       std::to_string(size));
    return nowhere;
  }
  Triple numbers{};
  for (std::size_t i = 0; i < size; ++i) numbers[i] = number(at[i]);
  return numbers;
}

std::string JsonReader::text(const ValueAt& at, std::string_view example) {
  if (at.node.is(Type::string)) return std::string(at.node.text());
  (void)expect(at, Type::string, "\"" + std::string(example) + "\"");
  return "";
}

bool JsonReader::is_list(const ValueAt& at, std::size_t size, std::string_view example) {
  if (!expect(at, Type::array, example)) return false;
  if (at.size() == size) return true;
  note(at.where, std::to_string(size) + " items are wanted here, e.g. " + std::string(example) + ", not " +
                     std::to_string(at.size()));
  return false;
}

void JsonReader::read(Number& out, const vocabulary::About& about, const ValueAt& at) {
  out = number(at);
  if (about.means == vocabulary::Means::angle) out *= angle_unit_;
}

void JsonReader::read(std::optional<Number>& out, const vocabulary::About& about, const ValueAt& at) {
  read(out.emplace(), about, at);
}

void JsonReader::read(bool& out, const vocabulary::About&, const ValueAt& at) {
  out = expect(at, Type::boolean, "") && at.node.boolean();
}

void JsonReader::read(Triple& out, const vocabulary::About& about, const ValueAt& at) {
  if (about.means != vocabulary::Means::each || at.node.is(Type::array)) {
    out = triple(at);
  } else {
    std::fill_n(out.begin(), std::max(dimension_, 2), number(at));
  }
}

void JsonReader::read(std::string& out, const vocabulary::About& about, const ValueAt& at) {
  out = text(at, about.example);
}

void JsonReader::read(std::vector<std::string>& out, const vocabulary::About& about, const ValueAt& at) {
  if (!expect(at, Type::array, "[\"" + std::string(about.example) + "\"]")) return;
  for (std::size_t i = 0; i < at.size(); ++i) out.push_back(text(at[i], about.example));
}

void JsonReader::read(Anchor& out, const vocabulary::About&, const ValueAt& at) {
  if (at.node.is(Type::string)) {
    out = std::string(at.node.text());
  } else {
    out = triple(at);
  }
}

void JsonReader::read(Direction& out, const vocabulary::About&, const ValueAt& at) {
  if (at.node.is(Type::string)) {
    out.first = at.node.text();
  } else if (!at.node.is(Type::array)) {
    note(at.where, "a direction is wanted here: the name of a vector or a pair of points [\"A\", \"B\"]");
  } else if (is_list(at, 2, R"(["A", "B"])")) {
    out = {text(at[0], "A"), text(at[1], "B")};
  }
}

// about.example is a list of terms.
void JsonReader::read(std::vector<std::pair<std::string, Number>>& out, const vocabulary::About& about,
                      const ValueAt& at) {
  if (!expect(at, Type::array, about.example)) return;
  const std::string_view one = about.example.substr(1, about.example.find(']'));
  const std::string_view name = one.substr(2, one.find('"', 2) - 2);
  for (std::size_t i = 0; i < at.size(); ++i) {
    auto& term = out.emplace_back("", 1);
    if (is_list(at[i], 2, one)) term = {text(at[i][0], name), number(at[i][1])};
  }
}

void JsonReader::read(Limit::Reaction& out, const vocabulary::About&, const ValueAt& at) {
  const std::string_view text = at.node.text();
  if (text != "end" && text != "flag") {
    return note(at.where, "what a motion does at the limit is wanted here: \"end\" or \"flag\"");
  }
  out = text == "end" ? Limit::Reaction::end : Limit::Reaction::flag;
}

// Members of bodies: local coordinates, or an object with ground coordinates.
void JsonReader::read(std::vector<Member>& out, const vocabulary::About&, const ValueAt& at) {
  const vocabulary::Keys keys = vocabulary::keys_of(vocabulary::kMember);
  each(&at.node, at.where, [&](const std::string& name, const ValueAt& one) {
    Member& member = out.emplace_back(Member{name, {}, one.node.is(Type::object)});
    if (member.in_ground) {
      Object object(*this, one, keys);
      fill(member, object, vocabulary::kMember);
    } else {
      member.local = triple(one);
    }
  });
}

}  // namespace assur
