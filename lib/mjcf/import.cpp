// Writes the scene of a model: bodies and joints as they are, loops as joints, actuated joints as drivers.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "assur/mjcf.hpp"
#include "decimal.hpp"
#include "mjcf/model.hpp"
#include "scene/names.hpp"

namespace assur {
namespace {

using mjcf::Actuator;
using mjcf::kNone;
using mjcf::kWorld;
using mjcf::Loop;
using mjcf::Model;
using mjcf::refuse;
using Json = nlohmann::ordered_json;
using ModelJoint = mjcf::Joint;
using JointKind = mjcf::Joint::Kind;

constexpr double kToldChange = 1e-9;  // rad or m: smaller moves of joints, to close loops, are rounding
constexpr std::size_t kMostNotes = 20;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

Json triple(const mjcf::Vector3d& v) { return {v.x() + 0.0, v.y() + 0.0, v.z() + 0.0}; }

[[noreturn]] void refuse_drive(const std::string& joint, const std::string& what) {
  throw Error(Error::Kind::input, {{"--drive " + excerpt(joint), what}});
}

// A law of the scene format, from the text of --drive.
Json law_of(const std::string& joint, const std::string& text) {
  if (text.starts_with('{') || text.starts_with('[')) {
    Json law = Json::parse(text, nullptr, false);
    if (law.is_discarded()) refuse_drive(joint, in_quotes(text) + " is not JSON");
    return law;
  }
  Json coefficients = Json::array();
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string number = text.substr(begin, end - begin);
    double value = 0;
    const auto [stop, error] = std::from_chars(number.data(), number.data() + number.size(), value);
    if (error != std::errc() || stop != number.data() + number.size() || !std::isfinite(value)) {
      refuse_drive(joint, in_quotes(text) +
                              " is not a law; write coefficients of a polynomial of t, \"0,6.28\", a law of "
                              "the scene format, {\"constant\": 0}, or free");
    }
    coefficients.push_back(value);
    begin = end + 1;
  }
  return {{"polynomial", coefficients}};
}

// The law times a factor; empty if it has a table, which cannot be multiplied.
Json times(double factor, Json law) {
  if (law.is_array()) {
    for (Json& part : law) {
      part = times(factor, part);
      if (part.empty()) return {};
    }
    return law;
  }
  const auto multiply = [&](Json& number) {
    if (number.is_string() && number.get<std::string>().starts_with('=')) {
      number = "=" + shortest(factor) + "*(" + number.get<std::string>().substr(1) + ")";
    } else if (number.is_number()) {
      number = factor * number.get<double>();
    }
  };
  if (!law.is_object() || law.contains("table")) return {};
  for (const char* key : {"constant", "offset"}) {
    if (law.contains(key)) multiply(law[key]);
  }
  if (law.contains("polynomial") && law["polynomial"].is_array()) {
    for (Json& c : law["polynomial"]) multiply(c);
  }
  if (law.contains("harmonics") && law["harmonics"].is_array()) {
    for (Json& term : law["harmonics"]) {
      if (term.is_object() && term.contains("amplitude")) multiply(term["amplitude"]);
    }
  }
  return law;
}

class Writer {
 public:
  Writer(const Model& model, const ModelOptions& options) : model_(model), options_(options) { out_.name = model.name; }

  ImportedModel write() {
    start();
    now_ = posture(model_, q_);
    name_all();
    write_bodies();
    write_joints();
    write_drivers();
    write_sites();
    finish();
    return std::move(out_);
  }

 private:
  // ---- the start posture

  void start() {
    q_ = reference(model_);
    if (!options_.key.empty()) {
      const auto key = model_.keys.find(options_.key);
      if (key == model_.keys.end()) {
        std::vector<std::string_view> names;
        for (const auto& [name, values] : model_.keys) names.push_back(name);
        throw Error(Error::Kind::input, {{"--key", "there is no keyframe " + in_quotes(options_.key) +
                                                       known_instead(options_.key, names)}});
      }
      q_ = key->second;
    }
    const mjcf::Change change = close(model_, q_);
    if (change.size > kToldChange) {
      const std::string& name = model_.joints[at(change.joint)].name;
      note("closing the loops moved joints by up to " + general(change.size, 3) +
           (name.empty() ? "" : ", " + in_quotes(name) + " the farthest"));
    }
  }

  void note(std::string text) { notes_.push_back(std::move(text)); }

  // ---- names

  // A name that the scene allows and nothing else has. kind: for elements without a name, and to tell one from another.
  std::string free_name(const std::string& given, const std::string& kind, std::size_t count) {
    std::string name = given.empty() ? kind + std::to_string(count) : given;
    for (char& c : name) {
      const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
      if (!letter) c = '_';
    }
    if (name[0] >= '0' && name[0] <= '9') name = "_" + name;
    if (name.size() > 200) name.resize(200);
    if (names_.count(name) != 0) name += "_" + kind;
    const std::string stem = name;
    for (std::size_t i = std::max<std::size_t>(next_[stem], 2); names_.count(name) != 0; ++i) {
      name = stem + std::to_string(i);
      next_[stem] = i + 1;
    }
    names_.insert(name);
    if (!given.empty() && name != given) note(kind + " " + in_quotes(given) + " is called " + name + " in the scene");
    return name;
  }

  // Joints and sites, which users name, keep theirs if another kind has the same.
  void name_all() {
    for (std::size_t i = 0; i < model_.joints.size(); ++i) {
      joints_.push_back(free_name(model_.joints[i].name, "joint", i + 1));
    }
    for (std::size_t i = 0; i < model_.sites.size(); ++i) {
      sites_.push_back(free_name(model_.sites[i].name, "site", i + 1));
    }
    bodies_.resize(model_.bodies.size());
    for (std::size_t b = 1; b < model_.bodies.size(); ++b) {
      if (!model_.bodies[b].joints.empty()) bodies_[b] = free_name(model_.bodies[b].name, "body", b);
    }
    bodies_[kWorld] = "ground";
    for (std::size_t i = 0; i < model_.loops.size(); ++i) {
      const Loop& loop = model_.loops[i];
      const char* kind = loop.kind == Loop::Kind::connect ? "connect"
                         : loop.kind == Loop::Kind::weld  ? "weld"
                                                          : "equality";
      loops_.push_back(free_name(loop.name, kind, i + 1));
    }
  }

  [[nodiscard]] const std::string& mover(int body) const { return bodies_[at(model_.mover(body))]; }
  [[nodiscard]] const std::string& title(int joint) const {
    const std::string& own = model_.joints[at(joint)].name;
    return own.empty() ? joints_[at(joint)] : own;
  }
  [[nodiscard]] std::string coordinate(int joint) const {
    return joints_[at(joint)] + (model_.joints[at(joint)].kind == JointKind::hinge ? ".angle" : ".displacement");
  }

  // ---- bodies and joints

  void write_bodies() {
    for (std::size_t b = 1; b < model_.bodies.size(); ++b) {
      if (!model_.bodies[b].joints.empty()) body_items_.push_back({bodies_[b], Json::object()});
    }
    out_.bodies = body_items_.size();
  }

  // Several joints of one body make a chain of bodies, each of which has one.
  void write_joints() {
    for (std::size_t b = 1; b < model_.bodies.size(); ++b) {
      const mjcf::Body& body = model_.bodies[b];
      std::string before = body.parent == kNone ? "" : mover(body.parent);
      for (std::size_t k = 0; k < body.joints.size(); ++k) {
        const int i = body.joints[k];
        const ModelJoint& j = model_.joints[at(i)];
        if (j.kind == JointKind::free) continue;
        std::string after = bodies_[b];
        if (k + 1 < body.joints.size()) {
          after = free_name("", joints_[at(i)] + "_part", 1);
          body_items_.push_back({after, Json::object()});
        }
        const Json ends = {before, after}, place = triple(now_.anchors[at(i)]), axis = triple(now_.axes[at(i)]);
        Json item;
        if (j.kind == JointKind::hinge) item = {{"revolute", ends}, {"at", place}, {"axis", axis}};
        if (j.kind == JointKind::slide) item = {{"prismatic", ends}, {"axis", axis}};
        if (j.kind == JointKind::ball) item = {{"spherical", ends}, {"at", place}};
        joint_items_.push_back({joints_[at(i)], std::move(item)});
        if (j.has_coordinate()) {
          out_.coordinates.push_back({title(i), coordinate(i), q_[j.first], false});
          outputs_.push_back(coordinate(i));
          if (j.range) {
            const double start = q_[j.first];
            limit_items_.push_back(
                {coordinate(i),
                 {{"min", (*j.range)[0] - start}, {"max", (*j.range)[1] - start}, {"reaction", "flag"}}});
          }
        }
        before = after;
      }
    }
    out_.joints = model_.joints.size();
    for (std::size_t i = 0; i < model_.loops.size(); ++i) {
      const Loop& loop = model_.loops[i];
      if (loop.kind == Loop::Kind::joint) continue;
      const int one = model_.mover(loop.body1), other = model_.mover(loop.body2);
      if (one == other) {
        ++left_out_["equality of parts of one body"];
        continue;
      }
      const Json ends = {bodies_[at(one)], bodies_[at(other)]};
      if (loop.kind == Loop::Kind::weld) {
        joint_items_.push_back({loops_[i], {{"fixed", ends}}});
      } else {
        joint_items_.push_back(
            {loops_[i], {{"spherical", ends}, {"at", triple(now_.bodies[at(loop.body1)] * loop.frame1.at)}}});
      }
    }
    out_.loops = model_.loops.size();
  }

  // ---- drivers

  void drive(int joint, const std::string& name, Json law, bool controlled) {
    law_[joint] = law;
    driver_items_.push_back({name, {{"coordinate", coordinate(joint)}, {"law", std::move(law)}}});
    out_.drivers.push_back({name, coordinate(joint), controlled});
    for (ImportedModel::Coordinate& c : out_.coordinates) {
      if (c.name == coordinate(joint)) c.driven = true;
    }
  }

  int find_joint(const std::string& name) const {
    std::vector<std::string_view> names;
    for (const bool own : {true, false}) {
      for (std::size_t i = 0; i < model_.joints.size(); ++i) {
        if (!model_.joints[i].has_coordinate()) continue;
        const std::string& known = own ? title(static_cast<int>(i)) : joints_[i];
        if (known == name) return static_cast<int>(i);
        if (own) names.push_back(known);
      }
    }
    refuse_drive(name, "there is no such hinge or slide" + known_instead(name, names));
  }

  void write_drivers() {
    std::map<int, std::string> asked;
    for (const auto& [joint, law] : options_.drive) {
      if (!asked.emplace(find_joint(joint), law).second) refuse_drive(joint, "the joint is named twice");
    }
    for (std::size_t i = 0; i < model_.actuators.size(); ++i) {
      const Actuator& actuator = model_.actuators[i];
      const auto law = asked.find(actuator.joint);
      const bool has_law = law != asked.end();
      if (has_law && law->second == "free") continue;
      const std::string name = actuator.name.empty() ? free_name(joints_[at(actuator.joint)] + "_drive", "drive", i + 1)
                                                     : free_name(actuator.name, "drive", i + 1);
      drive(actuator.joint, name, has_law ? law_of(title(actuator.joint), law->second) : Json{{"constant", 0}},
            !has_law);
    }
    for (const auto& [joint, law] : asked) {
      if (law_.count(joint) != 0) continue;
      if (law != "free") {
        drive(joint, free_name(joints_[at(joint)] + "_drive", "drive", 1), law_of(title(joint), law), false);
      } else if (std::none_of(model_.actuators.begin(), model_.actuators.end(),
                              [&, j = joint](const Actuator& a) { return a.joint == j; })) {
        refuse_drive(title(joint), "the joint has no actuator, so it is free already");
      }
    }
    couple();
  }

  // Joints that move together: one of the two has a law, the other one follows.
  void couple() {
    std::vector<std::size_t> open;
    for (std::size_t i = 0; i < model_.loops.size(); ++i) {
      if (model_.loops[i].kind == Loop::Kind::joint) open.push_back(i);
    }
    for (bool more = true; more;) {
      more = false;
      for (std::size_t k = 0; k < open.size(); ++k) {
        const Loop& loop = model_.loops[open[k]];
        const bool has1 = law_.count(loop.joint1) != 0, has2 = loop.joint2 == kNone || law_.count(loop.joint2) != 0;
        if (has1 && has2) {
          refuse(*loop.node, "both joints have drivers already; drive one of them, the other one follows");
        }
        if (!has1 && !has2) continue;
        if (has1 && loop.factor == 0) refuse(*loop.node, "joint1 has a driver, and the equality holds it still");
        const int follower = has1 ? loop.joint2 : loop.joint1;
        const double factor = has1 ? 1 / loop.factor : loop.factor;
        Json law = loop.joint2 == kNone ? Json{{"constant", 0}} : times(factor, law_[has1 ? loop.joint1 : loop.joint2]);
        if (law.empty())
          refuse(*loop.node, "the law that the other joint follows has a table, which cannot be multiplied");
        drive(follower, loops_[open[k]], std::move(law), false);
        open.erase(open.begin() + static_cast<std::ptrdiff_t>(k));
        more = true;
        break;
      }
    }
    if (open.empty()) return;
    const Loop& loop = model_.loops[open[0]];
    refuse(*loop.node, "joints that move together are read if one of them is driven; write --drive " +
                           title(loop.joint2) + "=LAW or --drive " + title(loop.joint1) + "=LAW");
  }

  // ---- sites, and the rest

  void write_sites() {
    std::map<std::string, Json> points;
    for (std::size_t i = 0; i < model_.sites.size(); ++i) {
      const mjcf::Site& site = model_.sites[i];
      const std::string& body = mover(site.body);
      points[body][sites_[i]] = {{"at", triple(now_.bodies[at(site.body)] * site.frame.at)}};
      if (body != "ground") outputs_.push_back(sites_[i]);
    }
    for (auto& [name, item] : body_items_) {
      if (const auto own = points.find(name); own != points.end()) item["points"] = own->second;
    }
    if (const auto own = points.find("ground"); own != points.end()) {
      for (auto& [name, value] : own->second.items()) value = value["at"];
      body_items_.insert(body_items_.begin(), {"ground", {{"points", own->second}}});
    }
  }

  using Items = std::vector<std::pair<std::string, Json>>;

  static std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

  static std::string section(const std::string& name, const Items& items) {
    if (items.empty()) return "";
    std::string text = "  \"" + name + "\": {\n";
    for (std::size_t i = 0; i < items.size(); ++i) {
      text +=
          "    " + text_of(items[i].first) + ": " + text_of(items[i].second) + (i + 1 < items.size() ? ",\n" : "\n");
    }
    return text + "  },\n";
  }

  void finish() {
    std::string& text = out_.scene;
    text = "{\n  \"assur\": 1,\n  \"name\": " + text_of(model_.name) + ",\n  \"dimension\": 3,\n";
    text += section("bodies", body_items_) + section("joints", joint_items_) + section("drivers", driver_items_) +
            section("limits", limit_items_);
    if (!outputs_.empty()) text += "  \"outputs\": " + text_of(outputs_) + ",\n";
    text += "  \"time\": {\"start\": 0, \"end\": 1, \"step\": 0.01}\n}\n";
    for (const auto& [kind, count] : model_.left_out) left_out_[kind] += count;
    out_.left_out.assign(left_out_.begin(), left_out_.end());
    if (notes_.size() > kMostNotes) {
      const std::size_t more = notes_.size() - kMostNotes;
      notes_.resize(kMostNotes);
      notes_.push_back("and " + std::to_string(more) + " more notes");
    }
    out_.notes = std::move(notes_);
  }

  const Model& model_;
  const ModelOptions& options_;
  ImportedModel out_;
  mjcf::Values q_;
  mjcf::Posture now_;
  std::set<std::string> names_ = {"ground"};
  std::map<std::string, std::size_t> next_;                   // number for the next name with this stem
  std::vector<std::string> joints_, sites_, bodies_, loops_;  // names in the scene
  Items body_items_, joint_items_, driver_items_, limit_items_;
  std::map<int, Json> law_;  // of driven joints
  Json outputs_ = Json::array();
  std::map<std::string, std::size_t> left_out_;
  std::vector<std::string> notes_;
};

}  // namespace

ImportedModel import_model(const std::filesystem::path& file, const ModelOptions& options) {
  const mjcf::Document document = mjcf::read_document(file);
  const Model model = mjcf::read_model(document, file.stem().string());
  return Writer(model, options).write();
}

}  // namespace assur
