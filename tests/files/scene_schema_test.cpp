// Every scene that the library ships or writes is valid by the schema of scenes/.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "assur/plan.hpp"
#include "assur/scene.hpp"
#include "files/json_document.hpp"
#include "files/shipped_files.hpp"
#include "source_dir.hpp"

namespace assur {
namespace {

using Type = JsonNode::Type;

std::string read(const std::filesystem::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

bool equal(const JsonNode& a, const JsonNode& b) {
  const auto same = [](const JsonNode& x, const JsonNode& y) { return equal(x, y); };
  return a.type() == b.type() && a.boolean() == b.boolean() && a.number() == b.number() && a.text() == b.text() &&
         std::ranges::equal(a.keys(), b.keys()) && std::ranges::equal(a.items(), b.items(), same);
}

// The keywords of JSON Schema 2020-12 that scene.schema.json uses; any other keyword throws.
class Schema {
 public:
  explicit Schema(const JsonNode& root) : root_(root) {}

  // "" or the first fault, with its place.
  [[nodiscard]] std::string fault(const JsonNode& value) const { return fault(root_, value, ""); }

 private:
  [[nodiscard]] std::string fault(const JsonNode& schema, const JsonNode& value, const std::string& at) const {
    if (schema.is(Type::boolean)) return schema.boolean() ? "" : at + " is not expected";
    for (std::size_t i = 0; i < schema.keys().size(); ++i) {
      const std::string_view key = schema.keys()[i];
      const std::string found = apply(key, schema, schema.items()[i], value, at);
      if (!found.empty()) return found;
    }
    return "";
  }

  [[nodiscard]] std::string apply(std::string_view key, const JsonNode& schema, const JsonNode& rule,
                                  const JsonNode& value, const std::string& at) const {
    const auto unless = [&](bool holds) { return holds ? "" : at + " breaks \"" + std::string(key) + '"'; };
    const auto holds = [&](const JsonNode& other) { return fault(other, value, at).empty(); };
    const auto count = [&] { return std::ranges::count_if(rule.items(), holds); };
    const auto has = [&](const JsonNode& name) { return value.find(name.text()) != nullptr; };
    const auto size = static_cast<double>(value.is(Type::string) ? value.text().size() : value.items().size());
    const bool list = value.is(Type::array), object = value.is(Type::object), text = value.is(Type::string);
    const auto each = [&](std::size_t from, const auto& of) -> std::string {
      for (std::size_t i = from; i < value.items().size(); ++i) {
        if (std::string found = of(i); !found.empty()) return found;
      }
      return "";
    };

    if (key == "$ref") return fault(definition(rule.text()), value, at);
    if (key == "type") return unless(type_of(value) == rule.text());
    if (key == "const") return unless(equal(rule, value));
    if (key == "enum") return unless(std::ranges::any_of(rule.items(), [&](const auto& x) { return equal(x, value); }));
    if (key == "anyOf") return unless(count() > 0);
    if (key == "oneOf") return unless(count() == 1);
    if (key == "not") return unless(!holds(rule));
    if (key == "required") return unless(!object || std::ranges::all_of(rule.items(), has));
    if (key == "dependentRequired") {
      for (std::size_t i = 0; object && i < rule.keys().size(); ++i) {
        if (value.find(rule.keys()[i]) != nullptr && !std::ranges::all_of(rule.items()[i].items(), has)) {
          return unless(false);
        }
      }
      return "";
    }
    if (key == "properties" || key == "propertyNames" || key == "additionalProperties") {
      const JsonNode* const known = key == "properties" ? &rule : schema.find("properties");
      if (!object) return "";
      return each(0, [&](std::size_t i) -> std::string {
        const std::string_view name = value.keys()[i];
        const std::string place = at + '/' + std::string(name);
        if (key == "propertyNames") return fault(rule, JsonNode(name), place);
        const JsonNode* own = known != nullptr ? known->find(name) : nullptr;
        if (key == "properties") return own != nullptr ? fault(*own, value.items()[i], place) : "";
        return own == nullptr ? fault(rule, value.items()[i], place) : "";
      });
    }
    if (key == "items" || key == "prefixItems") {
      const JsonNode* const first = key == "items" ? schema.find("prefixItems") : nullptr;
      if (!list) return "";
      return each(first != nullptr ? first->items().size() : 0, [&](std::size_t i) -> std::string {
        if (key == "prefixItems" && i >= rule.items().size()) return "";
        return fault(key == "items" ? rule : rule.items()[i], value.items()[i], at + '/' + std::to_string(i));
      });
    }
    if (key == "uniqueItems") {
      return unless(!list || each(1, [&](std::size_t i) -> std::string {
                               return std::any_of(value.items().begin(), value.items().begin() + static_cast<int>(i),
                                                  [&](const auto& x) { return equal(x, value.items()[i]); })
                                          ? "twice"
                                          : "";
                             }).empty());
    }
    if (key == "minItems") return unless(!list || size >= rule.number());
    if (key == "maxItems") return unless(!list || size <= rule.number());
    if (key == "minLength") return unless(!text || size >= rule.number());
    if (key == "maxLength") return unless(!text || size <= rule.number());
    if (key == "exclusiveMinimum") return unless(!value.is(Type::number) || value.number() > rule.number());
    if (key == "pattern") {
      return unless(!text || std::regex_search(std::string(value.text()), std::regex(std::string(rule.text()))));
    }
    static const std::vector<std::string_view> kNotes = {"$schema", "$id", "title", "description", "default", "$defs"};
    if (std::ranges::find(kNotes, key) == kNotes.end()) throw std::logic_error("unknown keyword " + std::string(key));
    return "";
  }

  [[nodiscard]] const JsonNode& definition(std::string_view path) const {
    constexpr std::string_view kStart = "#/$defs/";
    const JsonNode* const found = root_.find("$defs")->find(path.substr(kStart.size()));
    if (!path.starts_with(kStart) || found == nullptr) throw std::logic_error(std::string(path));
    return *found;
  }

  static std::string_view type_of(const JsonNode& value) {
    static const std::map<Type, std::string_view> kNames = {{Type::null, "null"},     {Type::boolean, "boolean"},
                                                            {Type::number, "number"}, {Type::string, "string"},
                                                            {Type::array, "array"},   {Type::object, "object"}};
    return kNames.at(value.type());
  }

  const JsonNode& root_;
};

class SchemaOfScenes : public testing::Test {
 protected:
  // "" or the first fault of a scene.
  [[nodiscard]] std::string fault(const std::string& scene) const {
    const JsonDocument document = parse_json(scene);
    return Schema(schema_.root).fault(document.root);
  }

 private:
  JsonDocument schema_ = parse_json(read(ASSUR_SOURCE_DIR "/scenes/scene.schema.json"));
};

TEST_F(SchemaOfScenes, AcceptsTheShippedScenes) {
  for (const auto& file : test::shipped_files()) {
    EXPECT_EQ(fault(read(file)), "") << file.filename();
    EXPECT_EQ(fault(write_scene(read_scene(file))), "") << file.filename() << ", written again";
  }
}

// One scene with outputs, members of joints, and laws of all kinds.
std::string scene_with(const std::string& from, const std::string& to) {
  std::string scene = R"({"assur": 1, "dimension": 3,
    "points": {"A": {"at": [0, 0, 0], "fixed": true}, "B": {"at": [0, 1, 0], "fixed": true}},
    "bodies": {"rod": {"points": {"P": {"at": [1, 0, 0]}}}},
    "joints": {"J": {"revolute": ["ground", "rod"], "at": "A", "axis": [0, 0, 1]}},
    "drivers": {"m": {"coordinate": "J.angle", "law": [{"constant": 1}, {"table": [[0, 0], [1, 2]], "monotone": true}]}},
    "measures": {"tilt": {"angle": ["J.axis", ["A", "P"]]},
                 "turn": {"angle": [["A", "B"], ["A", "P"]], "axis": "J.axis"},
                 "same": {"angle": [["A", "B"], ["A", "P"]], "axis": [0, 0, 2]}},
    "outputs": ["P", "P.vx", "J.angle.rate", "J.axis", "rod", "rod.origin.velocity", "tilt.value"],
    "time": {"start": 0, "end": 1, "step": 0.1}})";
  const std::size_t at = scene.find(from);
  return at == std::string::npos ? "" : scene.replace(at, from.size(), to);
}

TEST_F(SchemaOfScenes, AcceptsWhatTheReaderAccepts) {
  const std::string scene = scene_with("", "");
  EXPECT_NO_THROW((void)parse_scene(scene));
  EXPECT_EQ(fault(scene), "");
}

TEST_F(SchemaOfScenes, RefusesWhatTheReaderRefuses) {
  for (const auto& [from, to] : std::map<std::string, std::string>{{R"("assur": 1)", R"("assur": 2)"},
                                                                   {R"("dimension": 3)", R"("dimension": 4)"},
                                                                   {R"("fixed": true)", R"("fixed": 1)"},
                                                                   {R"("fixed": true)", R"("mass": 1)"},
                                                                   {"[1, 0, 0]", "[]"},
                                                                   {R"("rod"])", R"("rod", "rod"])"},
                                                                   {R"("rod.origin.velocity")", R"("rod..x")"},
                                                                   {R"({"constant": 1})", R"({"constant": "x"})"},
                                                                   {R"("step": 0.1)", R"("step": 0)"}}) {
    SCOPED_TRACE(from + " -> " + to);
    const std::string scene = scene_with(from, to);
    ASSERT_FALSE(scene.empty());
    EXPECT_THROW((void)prepare(parse_scene(scene)), Error);
    EXPECT_NE(fault(scene), "");
  }
}

}  // namespace
}  // namespace assur
