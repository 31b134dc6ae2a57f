// The mechanisms of scenes/ are the samples of the same name. The schema in scenes/ has the rows of
// scene/vocabulary.hpp.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <variant>
#include <vector>

#include "assur/scene.hpp"
#include "files/json_document.hpp"
#include "files/shipped_files.hpp"
#include "samples/samples.hpp"
#include "scene/vocabulary.hpp"
#include "source_dir.hpp"

namespace assur {
namespace {

constexpr double kRounding = 4e-16;  // dimensions of size 1, computed by expressions
constexpr double kGuess = 1e-5;      // files give guesses to five decimals or more

template <class T>
std::map<std::string, T> by_name(const std::vector<T>& items) {
  std::map<std::string, T> map;
  for (const T& item : items) map.emplace(item.name, item);
  return map;
}

void expect_near(const Triple& a, const Triple& b, double tolerance) {
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance);
}
void expect_same(const std::optional<double>& a, const std::optional<double>& b) {
  ASSERT_EQ(a.has_value(), b.has_value());
  if (a) {
    EXPECT_NEAR(*a, *b, kRounding);
  }
}
void expect_same(const Direction& a, const Direction& b) {
  EXPECT_EQ(a.first, b.first);
  EXPECT_EQ(a.second, b.second);
}
void expect_same(const Law& a, const Law& b) {
  for (const double t : {0.0, 0.4, 3.0}) {
    EXPECT_NEAR(a(t).value, b(t).value, 8 * kRounding * (1 + std::abs(b(t).value)));
    EXPECT_NEAR(a(t).rate, b(t).rate, 8 * kRounding * (1 + std::abs(b(t).rate)));
    EXPECT_NEAR(a(t).acceleration, b(t).acceleration, 8 * kRounding * (1 + std::abs(b(t).acceleration)));
  }
}
void expect_same(const std::vector<Law>& a, const std::vector<Law>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) expect_same(a[i], b[i]);
}

void expect_same(const Point& a, const Point& b) {
  EXPECT_EQ(a.fixed, b.fixed);
  expect_near(a.at, b.at, a.fixed ? kRounding : kGuess);
}
void expect_same(const Vector& a, const Vector& b) {
  EXPECT_EQ(a.fixed, b.fixed);
  EXPECT_EQ(a.unit, b.unit);
  expect_near(a.at, b.at, a.fixed ? kRounding : kGuess);
}
void expect_same(const Member& a, const Member& b) { expect_near(a.local, b.local, kRounding); }

template <class T>
void expect_same_items(const std::vector<T>& a, const std::vector<T>& b);

void expect_same(const Body& a, const Body& b) {
  EXPECT_EQ(a.origin, b.origin);
  EXPECT_EQ(a.frame, b.frame);
  EXPECT_EQ(a.base, b.base);
  expect_same_items(a.points, b.points);
  expect_same_items(a.vectors, b.vectors);
}

void expect_same(const Distance& a, const Distance& b) {
  EXPECT_EQ(a.p + " " + a.q, b.p + " " + b.q);
  expect_same(a.value, b.value);
}
void expect_same(const Dot& a, const Dot& b) {
  expect_same(a.d, b.d);
  expect_same(a.e, b.e);
  expect_same(a.value, b.value);
}
void expect_same(const Linear& a, const Linear& b) {
  ASSERT_EQ(a.terms.size(), b.terms.size());
  for (std::size_t i = 0; i < a.terms.size(); ++i) {
    EXPECT_EQ(a.terms[i].first, b.terms[i].first);
    EXPECT_NEAR(a.terms[i].second, b.terms[i].second, kRounding);
  }
  expect_near(a.value, b.value, kRounding);
}
void expect_same(const FixedCoordinate& a, const FixedCoordinate& b) {
  EXPECT_EQ(a.coordinate, b.coordinate);
  EXPECT_NEAR(a.value, b.value, kRounding);
}
void expect_same(const OnLine& a, const OnLine& b) {
  EXPECT_EQ(a.p + " " + a.a, b.p + " " + b.a);
  expect_same(a.d, b.d);
}

void expect_same(const PointAngle& a, const PointAngle& b) {
  EXPECT_EQ(a.a + " " + a.b, b.a + " " + b.b);
  EXPECT_EQ(a.axis, b.axis);
  expect_same(a.law, b.law);
}
void expect_same(const DrivenCoordinate& a, const DrivenCoordinate& b) {
  EXPECT_EQ(a.coordinate, b.coordinate);
  expect_same(a.law, b.law);
}
void expect_same(const DrivenDistance& a, const DrivenDistance& b) {
  EXPECT_EQ(a.a + " " + a.b, b.a + " " + b.b);
  expect_same(a.law, b.law);
}
void expect_same(const Pose& a, const Pose& b) {
  EXPECT_EQ(a.body, b.body);
  expect_same(a.translation, b.translation);
  expect_same(a.rotation, b.rotation);
}

void expect_same(const AbsoluteAngle& a, const AbsoluteAngle& b) { EXPECT_EQ(a.a + " " + a.b, b.a + " " + b.b); }
void expect_same(const AngleBetween& a, const AngleBetween& b) {
  expect_same(a.d, b.d);
  expect_same(a.e, b.e);
  EXPECT_EQ(a.axis, b.axis);
}
void expect_same(const MeasuredCoordinate& a, const MeasuredCoordinate& b) { EXPECT_EQ(a.coordinate, b.coordinate); }

// For kinds without a comparison, which no file uses so far.
template <class Kind>
void expect_same(const Kind&, const Kind&) {
  ADD_FAILURE() << "no comparison is written for this kind";
}

template <class Kind>
void expect_same(const Apart<Kind>& a, const Apart<Kind>& b) {
  expect_same(static_cast<const Kind&>(a), static_cast<const Kind&>(b));
}

template <class... Kinds>
void expect_same_kind(const std::variant<Kinds...>& a, const std::variant<Kinds...>& b) {
  ASSERT_EQ(a.index(), b.index());
  std::visit([&b]<class Kind>(const Kind& kind) { expect_same(kind, std::get<Kind>(b)); }, a);
}
void expect_same(const Constraint& a, const Constraint& b) { expect_same_kind(a.kind, b.kind); }
void expect_same(const Driver& a, const Driver& b) { expect_same_kind(a.kind, b.kind); }
void expect_same(const Measure& a, const Measure& b) { expect_same_kind(a.kind, b.kind); }
void expect_same(const DeclaredGroup& a, const DeclaredGroup& b) {
  EXPECT_EQ(a.unknowns, b.unknowns);
  EXPECT_EQ(a.keep, b.keep);
}

template <class T>
void expect_same_items(const std::vector<T>& a, const std::vector<T>& b) {
  EXPECT_EQ(a.size(), b.size());
  const auto others = by_name(b);
  for (const T& item : a) {
    SCOPED_TRACE(item.name);
    const auto other = others.find(item.name);
    if (other == others.end()) {
      ADD_FAILURE() << "only in the file";
    } else {
      expect_same(item, other->second);
    }
  }
}

void expect_same(const Scene& file, const Scene& sample) {
  EXPECT_EQ(file.name(), sample.name());
  EXPECT_EQ(file.dimension(), sample.dimension());
  expect_same_items(file.points(), sample.points());
  expect_same_items(file.vectors(), sample.vectors());
  expect_same_items(file.bodies(), sample.bodies());
  expect_same_items(file.constraints(), sample.constraints());
  expect_same_items(file.drivers(), sample.drivers());
  expect_same_items(file.measures(), sample.measures());
  expect_same_items(file.groups(), sample.groups());
  EXPECT_EQ(file.outputs(), sample.outputs());
  EXPECT_NEAR(file.time().start, sample.time().start, 0);
  EXPECT_NEAR(file.time().end, sample.time().end, kRounding * sample.time().end);
  EXPECT_NEAR(file.time().step, sample.time().step, kRounding);
}

const std::filesystem::path kScenes = std::filesystem::path(ASSUR_SOURCE_DIR) / "scenes";

TEST(SceneFiles, EqualTheSamplesOfTheirName) {
  int files = 0;
  for (const auto& file : test::shipped_files()) {
    const std::string name = file.stem().string();
    if (std::ranges::none_of(samples::table(), [&](const samples::SampleMechanism& s) { return s.name == name; }))
      continue;
    SCOPED_TRACE(name);
    const Scene scene = read_scene(file);
    EXPECT_TRUE(scene.warnings().empty());
    expect_same(scene, sample(name));
    ++files;
  }
  EXPECT_EQ(files, 8);
}

TEST(SceneFiles, FollowTheirParameters) {
  const auto compare = [](const std::string& name, const Parameters& set) {
    SCOPED_TRACE(name);
    expect_same(read_scene(kScenes / (name + ".json"), set), sample(name, set));
  };
  compare("stewart", {{"omega", 2}, {"step", 0.002}, {"steps", 500}});
  compare("four_bar", {{"omega", 1}});
  compare("slider_crank", {{"offset", 0.05}, {"crank_length", 0.4}, {"rod_length", 0.7}});
  compare("andrews", {{"xb", 0.03635}, {"omega", 3}});
  compare("jansen", {{"omega", 2}});
  compare("scissor", {{"arm", 3}, {"closed", 2.5}, {"open", 0.5}, {"time", 5}});
  compare("almost_parallelogram", {{"delta", 1e-9}, {"step", 0.005}, {"steps", 200}});
}

// The keys of an object, and its required keys.
struct Keys {
  std::set<std::string_view> all, needed;

  bool operator==(const Keys&) const = default;
};

void PrintTo(const Keys& keys, std::ostream* out) {
  for (const std::string_view key : keys.all) *out << key << (keys.needed.count(key) != 0 ? "! " : " ");
}

const JsonNode& at(const JsonNode& node, std::initializer_list<std::string_view> path) {
  const JsonNode* found = &node;
  for (const std::string_view key : path) {
    found = found->find(key);
    if (found == nullptr) throw std::out_of_range(std::string(key));
  }
  return *found;
}

Keys keys_of_schema(const JsonNode& object) {
  Keys keys;
  const auto names = at(object, {"properties"}).keys();
  keys.all.insert(names.begin(), names.end());
  if (const JsonNode* needed = object.find("required")) {
    for (const JsonNode& name : needed->items()) keys.needed.insert(name.text());
  }
  return keys;
}

template <class Row>
void add_keys(Keys& keys, const Row& row) {
  vocabulary::for_each_key(row, [&]<class Content>(const vocabulary::Key<Content>& key) {
    if constexpr (vocabulary::is_refused<Content>) return;
    keys.all.insert(key.name);
    if (!key.missing.empty()) keys.needed.insert(key.name);
  });
}

// Kinds with the same first key are one kind in the schema.
template <class Own, class... Rows>
std::map<std::string_view, Keys> keys_of_kinds(const Own& own, const std::tuple<Rows...>& kinds) {
  std::map<std::string_view, Keys> keys;
  const auto add = [&](const auto& row) {
    if constexpr (vocabulary::is_refused<std::remove_cvref_t<decltype(std::get<0>(row.keys).content)>>) return;
    Keys& kind = keys[row.name()];
    kind.needed.insert(row.name());
    add_keys(kind, row);
    add_keys(kind, own);
  };
  std::apply([&](const auto&... row) { (add(row), ...); }, kinds);
  return keys;
}

TEST(SceneSchema, HasTheKeysOfAllRows) {
  std::ifstream file(kScenes / "scene.schema.json");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const JsonDocument schema = parse_json(text);
  const auto item = [&](std::string_view section) -> const JsonNode& {
    return at(schema.root, {"properties", section, "additionalProperties"});
  };
  const auto kinds = [&](std::string_view section) {
    std::map<std::string_view, Keys> found;
    for (const JsonNode& kind : at(item(section), {"oneOf"}).items()) {
      found[at(kind, {"required"}).items()[0].text()] = keys_of_schema(kind);
    }
    return found;
  };
  EXPECT_EQ(kinds("constraints"), keys_of_kinds(vocabulary::kConstraint, vocabulary::kConstraints));
  EXPECT_EQ(kinds("drivers"), keys_of_kinds(vocabulary::kDriver, vocabulary::kDrivers));
  EXPECT_EQ(kinds("joints"), keys_of_kinds(vocabulary::kJoint, vocabulary::kJoints));
  EXPECT_EQ(kinds("measures"), keys_of_kinds(vocabulary::kMeasure, vocabulary::kMeasures));

  const auto expect_object = [](const JsonNode& object, const auto& row) {
    Keys keys;
    add_keys(keys, row);
    EXPECT_EQ(keys_of_schema(object), keys);
  };
  expect_object(item("points"), vocabulary::kPoint);
  expect_object(item("vectors"), vocabulary::kVector);
  expect_object(item("bodies"), vocabulary::kBody);
  expect_object(item("limits"), vocabulary::kLimit);
  expect_object(item("groups"), vocabulary::kGroup);
  expect_object(at(schema.root, {"properties", "time"}), vocabulary::kTime);

  // The fuzzer of scenes knows all keys of kinds.
  std::ifstream dictionary(kScenes.parent_path() / "tests/fuzz/scene.dict");
  const std::string words{std::istreambuf_iterator<char>(dictionary), {}};
  for (const char* section : {"constraints", "drivers", "joints", "measures"}) {
    for (const auto& [kind, keys] : kinds(section)) {
      for (const std::string_view key : keys.all) {
        EXPECT_NE(words.find("\\\"" + std::string(key) + "\\\""), std::string::npos) << key;
      }
    }
  }
}

}  // namespace
}  // namespace assur
