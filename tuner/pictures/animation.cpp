#include "pictures/animation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <unordered_map>
#include <utility>

#include "equations/outputs.hpp"
#include "equations/system.hpp"
#include "numbers.hpp"
#include "output/format.hpp"
#include "pictures/animation_files.hpp"
#include "pictures/faces.hpp"
#include "pictures/html.hpp"
#include "pictures/moving_picture.hpp"
#include "pictures/packed.hpp"
#include "plan/preparation.hpp"
#include "start/closest.hpp"
#include "status_text.hpp"

namespace assur::pictures {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::int64_t kMostFrames = 1000;      // more would not be visible
constexpr std::int64_t kMostNumbers = 2000000;  // of points and outputs; four bytes of the page for each
constexpr std::size_t kMostNamed = 8;           // violated constraints
constexpr std::size_t kMostQuantities = 200;    // in the list to choose from

double six_digits(double value) {
  if (value == 0 || !std::isfinite(value)) return value;
  const double unit = std::pow(10, 5 - std::floor(std::log10(std::abs(value))));
  return std::isfinite(unit) && unit > 0 ? std::round(value * unit) / unit : value;
}

Json json(const Packed& packed) { return {{"low", packed.low}, {"span", packed.span}, {"text", packed.text}}; }

// The group of a point, or the reason why it has none.
Json solver(int group) {
  if (group >= 0) return group;
  return group == Drawing::Point::kDriven ? "driven" : group == Drawing::Point::kResting ? "at rest" : "fixed";
}

std::string kind_name(Drawing::Kind kind) {
  static constexpr std::array kNames = {"rod", "actuator", "relation"};
  static_assert(kNames.size() == static_cast<std::size_t>(Drawing::Kind::relation) + 1);
  return kNames[static_cast<std::size_t>(kind)];
}

std::string symbol_name(Drawing::Symbol symbol) {
  static constexpr std::array kNames = {"revolute", "prismatic", "cylindrical", "spherical", "universal", "planar"};
  static_assert(kNames.size() == static_cast<std::size_t>(Drawing::Symbol::planar) + 1);
  return kNames[static_cast<std::size_t>(symbol)];
}

Json json(const Drawing::Joint& j) {
  Json axes = Json::array();
  for (const Drawing::Axis& a : j.axes) axes.push_back(a.direction >= 0 ? Json{a.direction} : Json{a.from, a.to});
  return {{"name", j.name},     {"symbol", symbol_name(j.symbol)},
          {"point", j.point},   {"axes", axes},
          {"origin", j.origin}, {"of", j.of},
          {"driven", j.driven}};
}

std::vector<std::string> moving_places(const Scene& scene) {
  std::vector<std::string> places;
  const auto add = [&](const auto& items) {
    for (const auto& item : items) {
      if (!item.fixed) places.push_back(item.name);
    }
  };
  add(scene.points());
  add(scene.vectors());
  for (const Body& b : scene.bodies()) {
    if (b.name == "ground") continue;
    for (const auto* members : {&b.points, &b.vectors}) {
      for (const Member& m : *members) places.push_back(m.name);
    }
  }
  return places;
}

// The points and vectors that are not among the outputs of `shown`.
std::set<std::string> not_shown(const Prepared& shown) {
  std::set<std::string> columns, missing;
  for (std::string& name : column_names(*preparation(shown).structure->system)) columns.insert(std::move(name));
  for (std::string& name : moving_places(*shown.scene())) {
    if (columns.count(name + ".x") == 0) missing.insert(std::move(name));
  }
  return missing;
}

}  // namespace

Scene with_all_places(const Scene& scene) {
  if (scene.outputs().empty()) return scene;  // computes all outputs
  std::vector<std::string> places = moving_places(scene);
  const auto with = [&](const std::vector<std::string>& names) {
    std::vector<std::string> outputs = scene.outputs();
    for (const std::string& name : names) outputs.push_back(name + ".position");
    return scene.with_outputs(std::move(outputs));
  };
  for (;;) {
    Scene all = with(places);
    const GroupedSystem structure = group_equations(all);
    const std::set<std::string> free(structure.undetermined.begin(), structure.undetermined.end());
    const System& system = *structure.system;
    const auto is_free = [&](const Term& t) { return free.count(system.coordinate_name(t.coordinate)) != 0; };
    const std::size_t left_out = std::erase_if(places, [&](const std::string& name) {
      const Item& item = system.item(name);
      return std::any_of(item.form, item.form + item.components, [&](Index f) {
        const auto terms = system.form(f);
        return std::any_of(terms.begin(), terms.end(), is_free);
      });
    });
    if (left_out == 0) return all;
  }
}

Animation::Animation(const Prepared& wanted, const Prepared& shown, std::int64_t steps)
    : name_(wanted.name()), drawing_(drawing_of(*wanted.scene(), not_shown(shown))), steps_(steps) {
  std::unordered_map<std::string, std::size_t> column;
  for (const std::string& name : column_names(*preparation(shown).structure->system))
    column.emplace(name, column.size());
  for (std::size_t i = 0; i < drawing_.moving; ++i) {
    for (int k = 0; k < drawing_.dimension; ++k) {
      point_columns_.push_back(column.at(drawing_.points[i].name + "." + "xyz"[k]));
    }
  }
  for (const Drawing::Direction& d : drawing_.directions) {
    for (int k = 0; k < drawing_.dimension && !d.fixed; ++k) {
      way_columns_.push_back(column.at(d.name + "." + "xyz"[k]));
    }
  }
  // The requested outputs come before the added positions, so they have the same columns here.
  shown_ = quantities(wanted.structure());
  quantities_ = shown_.size();
  if (shown_.size() > kMostQuantities) shown_.resize(kMostQuantities);
  for (Quantity& q : shown_) {
    for (std::size_t& value : q.columns) {
      value_columns_.push_back(value);
      value = value_columns_.size() - 1;
    }
  }
  const auto numbers =
      static_cast<std::int64_t>(std::max(point_columns_.size() + way_columns_.size(), value_columns_.size()));
  const std::int64_t most = std::clamp<std::int64_t>(kMostNumbers / std::max<std::int64_t>(numbers, 1), 2, kMostFrames);
  stride_ = std::max<std::int64_t>((steps + most - 1) / most, 1);
}

Animation::Animation(const Scene& scene, const Structure& refused)
    : name_(scene.name()), drawing_(drawing_of(scene)), steps_(1), last_(1) {
  const System& system = *GroupedSystem::of(refused).system;
  const ClosestPosture closest = closest_posture(system);
  for (const std::vector<double>* q : {&system.guess, &closest.q}) {
    times_.push_back(static_cast<double>(times_.size()));
    for (std::size_t i = 0; i < drawing_.moving; ++i) {
      const Item& item = system.item(drawing_.points[i].name);
      for (int k = 0; k < item.components; ++k) {
        points_.push_back(form_value<double>(system, item.form[k], *q) * system.unit(1));
      }
    }
    for (const Drawing::Direction& d : drawing_.directions) {
      if (d.fixed) continue;
      const Item& item = system.item(d.name);
      for (int k = 0; k < item.components; ++k) ways_.push_back(form_value<double>(system, item.form[k], *q));
    }
  }
  postures_ = {"the guess", "the closest posture"};
  std::string worst;
  for (const ViolatedConstraint& v : closest.violated) {
    violated_.push_back(v.name);
    if (violated_.size() > kMostNamed) continue;
    worst += (worst.empty() ? "" : ", ") + v.name + " by " + output::number(v.by) + (v.is_length ? " m" : "");
  }
  if (violated_.size() > kMostNamed) worst += ", ...";
  ended_ = "The mechanism cannot be assembled: " + refused.cannot_assemble() +
           ". Shown are the guess and the closest posture, which violates " + worst;
}

void Animation::take(std::int64_t k, const Simulator& simulator) {
  last_ = k;
  if (k % stride_ == 0 || k == steps_) keep(simulator);
}

void Animation::end(const Simulator& simulator, std::string why) {
  ended_ = "The motion ends early: " + std::move(why);
  if (!times_.empty() && simulator.time() == times_.back()) return;
  keep(simulator);
  // The last posture is not a step of the motion, and at a fold the derivatives of outputs are unbounded.
  std::fill(values_.end() - static_cast<std::ptrdiff_t>(value_columns_.size()), values_.end(), kNan);
}

void Animation::keep(const Simulator& simulator) {
  const std::span<const double> now = simulator.outputs();
  times_.push_back(simulator.time());
  for (const std::size_t c : point_columns_) points_.push_back(now[c]);
  for (const std::size_t c : way_columns_) ways_.push_back(now[c]);
  for (const std::size_t c : value_columns_) values_.push_back(now[c]);
}

std::string Animation::data() const {
  const auto dimension = static_cast<std::size_t>(drawing_.dimension);
  const auto first_place = [&](int i) {
    Triple at = drawing_.points[static_cast<std::size_t>(i)].at;
    if (static_cast<std::size_t>(i) < drawing_.moving) {
      for (std::size_t k = 0; k < dimension; ++k) at[k] = points_[static_cast<std::size_t>(i) * dimension + k];
    }
    return at;
  };
  Json groups = Json::array(), points = Json::array(), links = Json::array(), bodies = Json::array(),
       directions = Json::array(), joints = Json::array(), outputs = Json::array();
  const auto rounded = [](const Triple& at) { return Json{six_digits(at[0]), six_digits(at[1]), six_digits(at[2])}; };
  for (const Drawing::Group& g : drawing_.groups) groups.push_back({g.name, g.level});
  for (const Drawing::Point& p : drawing_.points) {
    Json& row = points.emplace_back(Json{{"name", p.name}, {"group", solver(p.group)}});
    if (points.size() > drawing_.moving) row["at"] = rounded(p.at);
  }
  for (const Drawing::Direction& d : drawing_.directions) directions.push_back(d.fixed ? rounded(d.at) : Json());
  for (const Drawing::Link& l : drawing_.links) links.push_back({l.from, l.to, kind_name(l.kind), l.name, l.inside});
  for (const Drawing::Joint& j : drawing_.joints) joints.push_back(json(j));
  for (const Drawing::Body& b : drawing_.bodies) {
    std::vector<Triple> at;
    for (const int i : b.points) at.push_back(first_place(i));
    std::vector<std::vector<int>> corners = faces(at);
    for (std::vector<int>& face : corners) {
      for (int& corner : face) corner = b.points[static_cast<std::size_t>(corner)];
    }
    bodies.push_back({b.name, b.points, corners});
  }
  for (const Quantity& q : shown_) {
    outputs.push_back({{"of", q.output}, {"title", q.title}, {"unit", q.unit}, {"columns", q.columns}});
  }
  // Points share one range for each axis; outputs have their own.
  Json all = {{"dimension", drawing_.dimension},
              {"times", times_},
              {"groups", groups},
              {"points", points},
              {"links", links},
              {"bodies", bodies},
              {"directions", directions},
              {"joints", joints},
              {"outputs", outputs},
              {"places", json(packed(points_, dimension))},
              {"ways", json(packed(ways_, std::max<std::size_t>(way_columns_.size(), 1)))},
              {"values", json(packed(values_, std::max<std::size_t>(value_columns_.size(), 1)))}};
  if (!postures_.empty()) {
    all["postures"] = postures_;
    all["violated"] = violated_;
  }
  std::string text = all.dump();
  // Escapes '<', because "</script>" within the data would end their element.
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos;) text.replace(at, 1, "\\u003c");
  return text;
}

std::vector<std::string> Animation::notes() const {
  std::vector<std::string> notes;
  if (stride_ > 1) {
    notes.push_back(output::grouped(times_.size()) + " of " + output::counted(last_ + 1, "posture") +
                    " are shown, every " + output::grouped(stride_) +
                    (stride_ == 2   ? "nd"
                     : stride_ == 3 ? "rd"
                                    : "th") +
                    ".");
  }
  if (shown_.size() < quantities_) {
    notes.push_back(output::grouped(shown_.size()) + " of " + output::counted(quantities_, "diagram") +
                    " can be chosen; select others with --outputs.");
  }
  return notes;
}

std::string Animation::page(const std::vector<std::string>& about) const {
  std::string body = "<h1>" + escaped(name_) + "</h1>\n";
  if (!ended_.empty()) body += paragraph(ended_ + ".", "ended");
  body.append(animation_body());
  std::vector<std::string> sentences = notes();
  sentences.insert(sentences.end(), about.begin(), about.end());
  body += paragraph(sentences, "faint") + "<script type=\"application/json\" id=\"motion\">" + data() +
          "</script>\n<script>\n";
  body.append(animation_script()).append("</script>\n");
  return html_page(name_, animation_style(), body);
}

std::string Animation::picture() const {
  Postures postures{&drawing_, times_, points_, ways_};
  for (const Quantity& q : shown_) postures.outputs.push_back(q.output);
  return moving_picture(postures, name_);
}

Animation animation_of(const Prepared& wanted, Simulator& simulator, std::span<const double> times,
                       const std::function<bool(std::int64_t k)>& proceed) {
  const std::int64_t steps = static_cast<std::int64_t>(times.size()) - 1;
  Animation animation(wanted, simulator.prepared(), steps);
  for (std::int64_t k = 0; k <= steps; ++k) {
    if (k > 0 && !proceed(k)) {
      animation.end(simulator, explained(Code::interrupted));
      break;
    }
    if (const Status status = simulator.step(times[static_cast<std::size_t>(k)]); !status.arrived()) {
      animation.end(simulator, why_stopped(status, simulator.report().events, simulator.report().reached));
      break;
    }
    animation.take(k, simulator);
  }
  return animation;
}

}  // namespace assur::pictures
