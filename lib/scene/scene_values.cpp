// Other values of the parameters and numbers of a scene.
#include <algorithm>
#include <memory>
#include <optional>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "scene/names.hpp"
#include "scene/scene_source.hpp"

namespace assur {

Scene SceneSource::attach(Scene scene, SceneSource source) {
  scene.source_ = std::make_shared<const SceneSource>(std::move(source));
  return scene;
}

Scene parametric_scene(const Parameters& defaults, std::function<Scene(const Parameters&)> make) {
  Scene scene = make(defaults);
  SceneSource source;
  for (const auto& [name, value] : defaults) source.parameters.push_back(name);
  source.again = [defaults, make = std::move(make)](const Parameters& values) {
    Parameters all = values;
    all.insert(defaults.begin(), defaults.end());
    return parametric_scene(all, make);
  };
  return SceneSource::attach(std::move(scene), std::move(source));
}

const std::vector<std::string>& Scene::parameters() const {
  static const std::vector<std::string> none;
  return source_ ? source_->parameters : none;
}

namespace {

// The numbers of a scene that have names.
class NamedNumbers {
 public:
  explicit NamedNumbers(int dimension) : dimension_(dimension) {}

  void add(const std::string& name, Triple& at) {
    for (std::size_t k = 0; k < static_cast<std::size_t>(dimension_); ++k) {
      number_of_.emplace(name + "." + "xyz"[k], &at[k]);
    }
  }
  void add(const Joint& joint, Anchor& anchor) {
    if (auto* at = std::get_if<Triple>(&anchor)) add(joint.name, *at);
  }
  void add(Constraint& c) {
    if (c.as<Gear>() != nullptr) return add_value(c, *c.as<Gear>(), [](Gear& gear) { return &gear.ratio; });
    if (c.as<Dot>() != nullptr) return add_value(c, *c.as<Dot>(), [](Dot& dot) { return &dot.value.emplace(); });
    if (auto* distance = std::get_if<Distance>(&c.kind)) {
      value_of_.emplace(c.name, [distance](const Number& value) { distance->value = value; });
    } else if (auto* fixed = std::get_if<FixedCoordinate>(&c.kind)) {
      value_of_.emplace(c.name, [fixed](const Number& value) { fixed->value = value; });
    }
  }

  [[nodiscard]] bool has(const std::string& name) const {
    return number_of_.contains(name) || value_of_.contains(name);
  }

  void set(const std::string& name, const Number& value) {
    if (const auto number = number_of_.find(name); number != number_of_.end()) {
      *number->second = value;
    } else {
      value_of_.at(name)(value);
    }
  }

  // parameters: other names that are known.
  [[noreturn]] void refuse(const std::string& name, std::span<const std::string> parameters) const {
    std::vector<std::string_view> names(parameters.begin(), parameters.end());
    for (const auto& [known, unused] : number_of_) names.push_back(known);
    for (const auto& [known, unused] : value_of_) names.push_back(known);
    throw Error(Error::Kind::input,
                "the scene has no parameter and no number " + in_quotes(name) + suggestion(name, names));
  }

 private:
  // Constraints of other kinds share their content with copies of the scene, so that it is replaced as a whole.
  template <class Kind, class Slot>
  void add_value(Constraint& c, const Kind& kind, const Slot& slot) {
    value_of_.emplace(c.name, [&c, kind, slot](const Number& value) {
      Kind other = kind;
      *slot(other) = value;
      c.kind = Apart<Kind>(std::move(other));
    });
  }

  int dimension_;
  std::unordered_map<std::string, Number*> number_of_;
  std::unordered_map<std::string, std::function<void(const Number&)>> value_of_;
};

template <class Parts>
NamedNumbers named_numbers(Parts& parts) {
  NamedNumbers numbers(parts.dimension);
  for (Point& p : parts.points) numbers.add(p.name, p.at);
  for (Vector& v : parts.vectors) numbers.add(v.name, v.at);
  for (Body& b : parts.bodies) {
    for (auto* members : {&b.points, &b.vectors}) {
      for (Member& m : *members) numbers.add(m.name, m.local);
    }
  }
  for (Joint& j : parts.joints) {
    std::visit(
        [&](auto& kind) {
          if constexpr (requires { kind.at; }) numbers.add(j, kind.at);
        },
        j.kind);
  }
  for (Constraint& c : parts.constraints) numbers.add(c);
  return numbers;
}

}  // namespace

void SceneSource::check_names(const Scene& scene, std::span<const std::string> names) {
  Scene::Parts parts = scene.written();
  const NamedNumbers numbers = named_numbers(parts);
  const auto& parameters = scene.parameters();
  for (const std::string& name : names) {
    const bool is_known = std::find(parameters.begin(), parameters.end(), name) != parameters.end();
    if (!is_known && !numbers.has(name)) numbers.refuse(name, parameters);
  }
}

void Scene::set_numbers(Parts& parts, const Parameters& values) {
  NamedNumbers numbers = named_numbers(parts);
  for (const auto& [name, value] : values) numbers.set(name, value);
}

Scene Scene::with_values(const Parameters& values) const {
  std::vector<std::string> names;
  for (const auto& [name, value] : values) names.push_back(name);
  SceneSource::check_names(*this, names);
  Parameters of_source, of_parts;
  for (const auto& [name, value] : values) {
    const auto& known = parameters();
    (std::find(known.begin(), known.end(), name) != known.end() ? of_source : of_parts).emplace(name, value);
  }
  Scene scene = *this;
  if (!of_source.empty()) {
    scene = source_->again(of_source);
    if (has_other_time_) scene = scene.with_time(time_);
    if (has_other_outputs_) scene = scene.with_outputs(written_outputs_);
  }
  if (of_parts.empty()) return scene;
  SceneBuilder builder(scene.name(), scene.dimension());
  builder.parts_ = scene.written();
  builder.parts_.warnings.clear();
  set_numbers(builder.parts_, of_parts);
  builder.outputs_ = scene.written_outputs_;
  builder.time_ = scene.time_;
  Scene changed = std::move(builder).build();
  changed.has_other_time_ = has_other_time_;
  changed.has_other_outputs_ = has_other_outputs_;
  if (!source_) return changed;
  // A parameter that is set later keeps the numbers that are set now.
  return SceneSource::attach(std::move(changed),
                             {parameters(), [source = source_, all = values](const Parameters& more) {
                                Parameters both = more;
                                both.insert(all.begin(), all.end());
                                return source->again({}).with_values(both);
                              }});
}

}  // namespace assur
