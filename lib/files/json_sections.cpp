#include <algorithm>
#include <cmath>
#include <numbers>

#include "files/json_reader.hpp"

namespace assur {

void JsonReader::each(const JsonNode* section, const Where& where,
                      const std::function<void(const std::string&, const ValueAt&)>& read) {
  if (section == nullptr || !expect({*section, where}, Type::object, "{\"name\": ...}")) return;
  for (std::size_t i = 0; i < section->items().size(); ++i) {
    const std::string name(section->keys()[i]);
    const ValueAt item{section->items()[i], where / name};
    if (parameter_names_.count(name) != 0) {
      note(item.where, in_quotes(name) + " is a parameter already; all kinds share one set of names");
    }
    read(name, item);
  }
}

template <class Item, class Row>
void JsonReader::read_items(const JsonNode* section, const Where& where, const Row& row) {
  const vocabulary::Keys keys = vocabulary::keys_of(row);
  each(section, where, [&](const std::string& name, const ValueAt& at) {
    Object object(*this, at, keys);
    Item item;
    item.name = name;
    fill(item, object, row);
    builder_.add(std::move(item));
  });
}

SceneBuilder JsonReader::read(const std::string& name) {
  check_version();
  Object scene(*this, {document_.root, Where()},
               {{"assur", "name", "dimension", "angles", "parameters", "points", "vectors", "bodies", "joints",
                 "constraints", "drivers", "measures", "limits", "groups", "outputs", "time"}});
  if (!scene.is_object()) throw Error(Error::Kind::input, std::move(findings_));
  (void)scene.need("assur", "the version of the format, \"assur\": 1");
  read_dimension(scene);
  read_angles(scene);
  const JsonNode* title = scene.find("name");
  std::string own_name = title ? excerpt(text({*title, Where("/name")}, "four_bar")) : name;
  builder_ = SceneBuilder(std::move(own_name), dimension_);

  const auto count = [&](std::string_view key) { return scene.find(key) ? scene.find(key)->items().size() : 0; };
  builder_.reserve(count("points"), count("constraints"));

  read_parameters(scene.find("parameters"));
  remember_names(document_.root);
  read_items<Point>(scene.find("points"), Where("/points"), vocabulary::kPoint);
  read_items<Vector>(scene.find("vectors"), Where("/vectors"), vocabulary::kVector);
  read_items<Body>(scene.find("bodies"), Where("/bodies"), vocabulary::kBody);
  read_joints(scene.find("joints"));
  read_constraints(scene.find("constraints"));
  read_drivers(scene.find("drivers"));
  read_measures(scene.find("measures"));
  read_limits(scene.find("limits"));
  read_items<DeclaredGroup>(scene.find("groups"), Where("/groups"), vocabulary::kGroup);
  read_outputs(scene.find("outputs"));
  read_time(scene.find("time"));

  for (std::filesystem::path& file : files_) builder_.table(std::move(file));
  for (Diagnostic& finding : findings_) builder_.diagnose(std::move(finding));
  return std::move(builder_);
}

// In another version everything may differ, so nothing else is read.
void JsonReader::check_version() const {
  const JsonNode* version = document_.root.find("assur");
  if (version == nullptr || (version->is(Type::number) && version->number() == 1)) return;
  throw Error(Error::Kind::input, {{"/assur", "this version of the format is unknown; write \"assur\": 1"}});
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
  each(section, where, [&](const std::string& name, const ValueAt& at) {
    const std::string_view text = at.node.text();
    const auto replaced = set_.find(name);
    if (std::string wrong = why_no_name(name); !wrong.empty()) {
      note(at.where, std::move(wrong));
    } else if (replaced != set_.end() && isfinite(replaced->second)) {
      parameters.push_back({name, replaced->second});
    } else if (replaced != set_.end()) {
      note(at.where, "the parameter is set to " + shortest(replaced->second.value()) + "; a finite number is wanted");
      unusable.push_back(name);
    } else if (at.node.is(Type::number)) {
      parameters.push_back({name, at.node.number()});
    } else if (text.starts_with('=')) {
      parameters.push_back({name, std::string(text.substr(1))});
    } else {
      (void)number(at);  // reports the error
      unusable.push_back(name);
    }
  });
  for (const std::string_view name : names) parameter_names_.emplace(name);
  for (const auto& [name, value] : set_) {
    if (parameter_names_.count(name) != 0) continue;
    note(where, "there is no parameter " + in_quotes(name) + " to set" + suggestion(name, names));
  }
  for (auto& finding : expressions_.define(parameters, unusable))
    note(where / finding.parameter, std::move(finding.what));
}

// Remembers names of points, members, and joints (whose bodies share a point of this name), which distinguish an angle
// of points from one of vectors, and of measured angles and their sums.
void JsonReader::remember_names(const JsonNode& scene) {
  const auto remember = [&](const JsonNode* points) {
    if (points != nullptr) point_names_.insert(points->keys().begin(), points->keys().end());
  };
  remember(scene.find("points"));
  remember(scene.find("joints"));
  if (const JsonNode* measures = scene.find("measures"); measures != nullptr) {
    const auto is_angle = [&](const JsonNode& measure) {
      const JsonNode* const coordinate = measure.find("coordinate");
      return measure.find("angle") != nullptr || (coordinate != nullptr && coordinate->text().ends_with(".angle"));
    };
    const auto is_sum_of_angles = [&](const JsonNode& measure) {
      const JsonNode* const sum = measure.find("sum");
      return sum != nullptr && std::ranges::any_of(sum->items(), [&](const JsonNode& term) {
               return !term.items().empty() && angle_names_.contains(term.items()[0].text());
             });
    };
    std::vector<std::string_view> sums;
    for (std::size_t i = 0; i < measures->keys().size(); ++i) {
      if (is_angle(measures->items()[i])) angle_names_.insert(measures->keys()[i]);
    }
    for (std::size_t i = 0; i < measures->keys().size(); ++i) {
      if (is_sum_of_angles(measures->items()[i])) sums.push_back(measures->keys()[i]);
    }
    angle_names_.insert(sums.begin(), sums.end());
  }
  const JsonNode* bodies = scene.find("bodies");
  if (bodies == nullptr) return;
  for (const JsonNode& body : bodies->items()) remember(body.find("points"));
}

void JsonReader::read_limits(const JsonNode* section) {
  const vocabulary::Keys keys = vocabulary::keys_of(vocabulary::kLimit);
  each(section, Where("/limits"), [&](const std::string& quantity, const ValueAt& at) {
    Object object(*this, at, keys);
    Limit limit{.quantity = quantity};
    fill(limit, object, vocabulary::kLimit);
    builder_.add(std::move(limit));
  });
}

void JsonReader::read_outputs(const JsonNode* section) {
  if (section == nullptr) return;
  std::vector<std::string> names;
  read(names, {vocabulary::Means::text, "C"}, {*section, Where("/outputs")});
  for (std::string& name : names) builder_.output(std::move(name));
}

// All members of a table have the end and the step of the first one. A start that follows from the values is converted,
// so that each member is prepared alone.
void JsonReader::put(TimeGrid& out, const vocabulary::Slot<TimeGrid, double>& slot, const ValueAt& at) {
  const Number value = number(at);
  out.*slot.member = slot.member == &TimeGrid::start ? double{value} : value.value();
}

void JsonReader::read_time(const JsonNode* section) {
  if (section == nullptr) return;
  Object object(*this, {*section, Where("/time")}, vocabulary::keys_of(vocabulary::kTime));
  TimeGrid time;
  if (!fill(time, object, vocabulary::kTime)) return broken(object.where());
  builder_.time(time.start, time.end, time.step);
}

}  // namespace assur
