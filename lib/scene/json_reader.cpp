#include "scene/json_reader.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "numbers.hpp"

namespace assur {

JsonReader::JsonReader(const JsonDocument& document, TableFolders tables, const Parameters& set)
    : document_(document), tables_(std::move(tables)), set_(set), findings_(document.findings) {}

void JsonReader::note(const Where& where, std::string what) { findings_.push_back({where.text(), std::move(what)}); }

bool JsonReader::expect(const JsonNode& node, Type type, const Where& where, std::string_view example) {
  if (node.is(type)) return true;
  note(where, std::string(with_article(type)) + " is wanted here" +
                  (example.empty() ? "" : ", e.g. " + std::string(example)) + ", not " +
                  std::string(with_article(node.type())));
  return false;
}

// ---- objects

JsonReader::Object::Object(JsonReader& reader, const JsonNode& node, Where where, std::vector<std::string_view> allowed)
    : reader_(reader), node_(node.is(Type::object) ? &node : nullptr), where_(std::move(where)) {
  if (node_ == nullptr) {
    reader_.note(where_, "an object with the keys " + list_of(allowed) + " is wanted here, not " +
                             std::string(with_article(node.type())));
    return;
  }
  for (const std::string_view key : node.keys()) {
    if (std::find(allowed.begin(), allowed.end(), key) != allowed.end()) continue;
    std::vector<std::string_view> absent;
    for (const std::string_view name : allowed) {
      if (node.find(name) == nullptr) absent.push_back(name);
    }
    const std::string near = near_miss(key, absent);
    const std::string hint =
        !near.empty() ? "; did you mean " + in_quotes(near) + "?" : "; expected " + one_of(allowed);
    reader_.note(where_ / key, "unknown key " + in_quotes(key) + hint);
    const bool only_one_fits = near.empty() && allowed.size() == 1;
    if (near.empty() && !only_one_fits) continue;
    misspelt_.emplace(only_one_fits ? allowed[0] : near);
    reader_.broken(where_ / (only_one_fits ? allowed[0] : near));
  }
}

const JsonNode* JsonReader::Object::need(std::string_view key, std::string_view what) {
  const JsonNode* node = find(key);
  if (node == nullptr && node_ != nullptr && misspelt_.count(std::string(key)) == 0) {
    reader_.note(where_ / key, "this is missing: " + std::string(what));
  }
  return node;
}

// ---- values

double JsonReader::number(const JsonNode& node, const Where& where) {
  if (node.is(Type::number)) return node.number();
  if (node.is(Type::string) && !node.text().empty() && node.text().front() == '=') {
    const Expressions::Result result = expressions_.evaluate(std::string(node.text().substr(1)));
    if (result.ok()) return result.value;
    note(where, result.what);
  } else if (node.is(Type::string)) {
    note(where, "a number is wanted here, not the text " + in_quotes(node.text()) + "; an expression begins with '='");
  } else {
    note(where, "a number is wanted here, not " + std::string(with_article(node.type())));
  }
  return kNan;
}

std::vector<double> JsonReader::numbers(const JsonNode& node, const Where& where) {
  std::vector<double> values;
  if (!expect(node, Type::array, where, "[0, 1]")) return values;
  for (std::size_t i = 0; i < node.items().size(); ++i) values.push_back(number(node.items()[i], where / i));
  return values;
}

Triple JsonReader::triple(const JsonNode& node, const Where& where) {
  const Triple nowhere{kNan, kNan, kNan};
  if (!expect(node, Type::array, where, dimension_ == 3 ? "[0, 0, 0]" : "[0, 0]")) return nowhere;
  const std::size_t size = node.items().size();
  if (dimension_ != 0 ? size != static_cast<std::size_t>(dimension_) : size != 2 && size != 3) {
    note(where, dimension_ == 2 ? "2 numbers [x, y] are wanted in a scene of dimension 2, not " + std::to_string(size)
                : dimension_ == 3
                    ? "3 numbers [x, y, z] are wanted in a scene of dimension 3, not " + std::to_string(size)
                    : "2 or 3 numbers are wanted here, not " + std::to_string(size));
    return nowhere;
  }
  Triple at{};
  for (std::size_t i = 0; i < size; ++i) at[i] = number(node.items()[i], where / i);
  return at;
}

bool JsonReader::boolean(const JsonNode& node, const Where& where) {
  return expect(node, Type::boolean, where, "") && node.boolean();
}

std::string JsonReader::text(const JsonNode& node, const Where& where, std::string_view example) {
  return expect(node, Type::string, where, example) ? std::string(node.text()) : "";
}

std::vector<std::string> JsonReader::texts(const JsonNode& node, const Where& where, std::string_view example) {
  std::vector<std::string> values;
  if (!expect(node, Type::array, where, "[" + std::string(example) + "]")) return values;
  for (std::size_t i = 0; i < node.items().size(); ++i) values.push_back(text(node.items()[i], where / i, example));
  return values;
}

std::span<const JsonNode> JsonReader::list(const JsonNode& node, std::size_t size, const Where& where,
                                           std::string_view example) {
  if (!expect(node, Type::array, where, example)) return {};
  if (node.items().size() == size) return node.items();
  note(where, std::to_string(size) + " items are wanted here, e.g. " + std::string(example) + ", not " +
                  std::to_string(node.items().size()));
  return {};
}

std::array<std::string, 2> JsonReader::pair(const JsonNode& node, const Where& where) {
  const auto items = list(node, 2, where, "[\"A\", \"B\"]");
  if (items.empty()) return {};
  return {text(items[0], where / std::size_t{0}, "\"A\""), text(items[1], where / std::size_t{1}, "\"A\"")};
}

Direction JsonReader::direction(const JsonNode& node, const Where& where) {
  if (node.is(Type::string)) return {std::string(node.text())};
  if (node.is(Type::array)) {
    const auto [from, to] = pair(node, where);
    return {from, to};
  }
  note(where, "a direction is wanted here: the name of a vector or a pair of points [\"A\", \"B\"]");
  return {};
}

void JsonReader::each(const JsonNode* section, const Where& where,
                      const std::function<void(const std::string&, const JsonNode&, const Where&)>& read) {
  if (section == nullptr || !expect(*section, Type::object, where, "{\"name\": ...}")) return;
  for (std::size_t i = 0; i < section->items().size(); ++i) {
    const std::string name(section->keys()[i]);
    const Where item = where / name;
    if (parameter_names_.count(name) != 0) {
      note(item, in_quotes(name) + " is a parameter already; all kinds share one set of names");
    }
    read(name, section->items()[i], item);
  }
}

// ---- the scene

SceneBuilder JsonReader::read(const std::string& name) {
  check_version();
  Object scene(*this, document_.root, Where(),
               {"assur", "name", "dimension", "angles", "parameters", "points", "vectors", "bodies", "constraints",
                "drivers", "measures", "groups", "outputs", "time"});
  if (!scene.is_object()) throw Error(Error::Kind::input, std::move(findings_));
  (void)scene.need("assur", "the version of the format, \"assur\": 1");
  read_dimension(scene);
  read_angles(scene);
  const JsonNode* title = scene.find("name");
  std::string own_name = title ? excerpt(text(*title, scene.where() / "name", "\"four_bar\"")) : name;
  builder_ = SceneBuilder(std::move(own_name), dimension_);

  const auto count = [&](std::string_view key) { return scene.find(key) ? scene.find(key)->items().size() : 0; };
  builder_.reserve(count("points"), count("constraints"));

  read_parameters(scene.find("parameters"));
  remember_names(document_.root);
  read_points(scene.find("points"));
  read_vectors(scene.find("vectors"));
  read_bodies(scene.find("bodies"));
  read_constraints(scene.find("constraints"));
  read_drivers(scene.find("drivers"));
  read_measures(scene.find("measures"));
  read_groups(scene.find("groups"));
  read_outputs(scene.find("outputs"));
  read_time(scene.find("time"));

  for (Diagnostic& finding : findings_) builder_.diagnose(std::move(finding));
  return std::move(builder_);
}

// Another version may mean anything: then nothing else is read.
void JsonReader::check_version() const {
  const JsonNode* version = document_.root.find("assur");
  if (version == nullptr || (version->is(Type::number) && version->number() == 1)) return;
  throw Error(Error::Kind::input, {{"/assur", "this version of the format is not known; \"assur\": 1 is"}});
}

void JsonReader::read_dimension(Object& scene) {
  const JsonNode* node = scene.need("dimension", "2 for the plane, 3 for space");
  if (node == nullptr) return;
  if (node->is(Type::number) && (node->number() == 2 || node->number() == 3)) {
    dimension_ = static_cast<int>(node->number());
  } else {
    note(scene.where() / "dimension", "the dimension is 2 or 3");
  }
}

void JsonReader::read_angles(Object& scene) {
  const JsonNode* node = scene.find("angles");
  if (node == nullptr || (node->is(Type::string) && node->text() == "rad")) return;
  if (node->is(Type::string) && node->text() == "deg") {
    angle_unit_ = std::numbers::pi / 180;
  } else {
    note(scene.where() / "angles", "the unit of all angles of the file, \"rad\" or \"deg\", is wanted here");
  }
}

void JsonReader::read_parameters(const JsonNode* section) {
  const Where where("/parameters");
  std::vector<Expressions::Parameter> parameters;
  std::vector<std::string> unusable;
  std::vector<std::string_view> names;
  if (section != nullptr) names.assign(section->keys().begin(), section->keys().end());
  each(section, where, [&](const std::string& name, const JsonNode& node, const Where& here) {
    const auto replaced = set_.find(name);
    if (std::string wrong = why_no_name(name); !wrong.empty()) {
      note(here, std::move(wrong));
    } else if (replaced != set_.end() && std::isfinite(replaced->second)) {
      parameters.push_back({name, replaced->second});
    } else if (replaced != set_.end()) {
      note(here, "the parameter is set to " + shortest(replaced->second) + "; a finite number is wanted");
      unusable.push_back(name);
    } else if (node.is(Type::number)) {
      parameters.push_back({name, node.number()});
    } else if (node.is(Type::string) && !node.text().empty() && node.text().front() == '=') {
      parameters.push_back({name, std::string(node.text().substr(1))});
    } else {
      (void)number(node, here);  // says what is wrong
      unusable.push_back(name);
    }
  });
  for (const std::string_view name : names) parameter_names_.emplace(name);
  for (const auto& [name, value] : set_) {
    if (parameter_names_.count(name) != 0) continue;
    note(where, "there is no parameter " + in_quotes(name) + " to be set" + suggestion(name, names));
  }
  for (auto& finding : expressions_.define(parameters, unusable))
    note(where / finding.parameter, std::move(finding.what));
}

}  // namespace assur
