// Builds the scene of a model: bodies and joints as they are, loops as joints, actuated joints as drivers.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <deque>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "assur/mjcf.hpp"
#include "decimal.hpp"
#include "files/json_reader.hpp"
#include "mjcf/model.hpp"
#include "scene/law_sum.hpp"
#include "scene/names.hpp"

namespace assur {
namespace {

using mjcf::Actuator;
using mjcf::kNone;
using mjcf::kWorld;
using mjcf::Loop;
using mjcf::Model;
using mjcf::refuse;
using ModelJoint = mjcf::Joint;
using JointKind = mjcf::Joint::Kind;

constexpr double kToldChange = 1e-9;    // rad or m: smaller motions of joints that close loops are rounding
constexpr std::size_t kMostNotes = 20;  // a choice: about a page of a terminal

std::size_t at(int i) { return static_cast<std::size_t>(i); }

Triple triple(const mjcf::Vector3d& v) { return {v.x() + 0.0, v.y() + 0.0, v.z() + 0.0}; }  // no -0

[[noreturn]] void refuse_drive(const std::string& joint, const std::string& what) {
  throw Error(Error::Kind::input, {{"--drive " + excerpt(joint), what}});
}

// Coefficients of a polynomial.
Law polynomial_of(const std::string& joint, const std::string& text) {
  std::vector<Number> coefficients;
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
  return Law::polynomial(std::move(coefficients));
}

class Importer {
 public:
  Importer(const Model& model, const ModelOptions& options, const std::filesystem::path& file)
      : model_(model), options_(options), tables_{file.parent_path(), options.tables}, builder_(model.name, 3) {
    out_.name = model.name;
  }

  ImportedModel import() {
    start();
    name_all();
    add_joints();
    add_drivers();
    add_bodies();
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
           (name.empty() ? "" : ", " + in_quotes(name) + " the most"));
    }
    now_ = posture(model_, q_);
  }

  void note(std::string text) { notes_.push_back(std::move(text)); }

  // ---- names

  // A name that the scene allows and nothing else has. kind: base of the name if the element has none, and suffix of a
  // name that is taken.
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

  // Joints and sites are named first and keep their names, because users refer to them.
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

  // ---- joints

  // Several joints of one body make a chain of bodies, each of which has one.
  void add_joints() {
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
          parts_.push_back(after);
        }
        const Triple place = triple(now_.anchors[at(i)]), axis = triple(now_.axes[at(i)]);
        const std::string& name = joints_[at(i)];
        if (j.kind == JointKind::hinge) builder_.joint(name, Revolute{before, after, place, axis});
        if (j.kind == JointKind::slide) builder_.joint(name, Prismatic{before, after, axis});
        if (j.kind == JointKind::ball) builder_.joint(name, Spherical{before, after, place});
        if (j.has_coordinate()) {
          coordinate_of_[i] = out_.coordinates.size();
          out_.coordinates.push_back({title(i), coordinate(i), q_[j.first], false});
          builder_.output(coordinate(i));
          if (j.range) {
            const double start = q_[j.first];
            builder_.limit(coordinate(i), (*j.range)[0] - start, (*j.range)[1] - start, Limit::Reaction::flag);
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
      const std::string &a = bodies_[at(one)], &b = bodies_[at(other)];
      if (loop.kind == Loop::Kind::weld) {
        builder_.joint(loops_[i], Fixed{a, b});
      } else {
        builder_.joint(loops_[i], Spherical{a, b, triple(now_.bodies[at(loop.body1)] * loop.frame1.at)});
      }
    }
    out_.loops = model_.loops.size();
  }

  // ---- drivers

  // The law that --drive gives a joint.
  [[nodiscard]] Law law_of(int joint, const std::string& text) {
    if (!text.starts_with('{') && !text.starts_with('[')) return polynomial_of(title(joint), text);
    try {
      std::vector<std::filesystem::path> files;
      Law law = parse_law(text, tables_, files);
      for (std::filesystem::path& file : files) builder_.table(std::move(file));
      return law;
    } catch (const Error& error) {
      const Diagnostic& first = error.diagnostics().front();
      refuse_drive(title(joint), (first.where.empty() ? "" : first.where + ": ") + first.what);
    }
  }

  void drive(int joint, const std::string& name, const Law& law, bool controlled) {
    law_[joint] = law;
    builder_.drive(name, DrivenCoordinate{coordinate(joint), law});
    out_.drivers.push_back({name, coordinate(joint), controlled});
    out_.coordinates[coordinate_of_.at(joint)].driven = true;
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

  void add_drivers() {
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
      drive(actuator.joint, name, has_law ? law_of(actuator.joint, law->second) : Law::constant(0), !has_law);
    }
    for (const auto& [joint, law] : asked) {
      if (law_.count(joint) != 0) continue;
      if (law != "free") {
        drive(joint, free_name(joints_[at(joint)] + "_drive", "drive", 1), law_of(joint, law), false);
      } else if (std::none_of(model_.actuators.begin(), model_.actuators.end(),
                              [&, j = joint](const Actuator& a) { return a.joint == j; })) {
        refuse_drive(title(joint), "the joint has no actuator, so it is free already");
      }
    }
    couple();
  }

  // Joints that move together: one of the two has a law, the other one follows.
  void couple() {
    std::map<int, std::vector<std::size_t>> loops_of;  // loops of each joint
    std::deque<std::size_t> work;
    std::set<std::size_t> open;
    for (std::size_t i = 0; i < model_.loops.size(); ++i) {
      const Loop& loop = model_.loops[i];
      if (loop.kind != Loop::Kind::joint) continue;
      for (const int joint : {loop.joint1, loop.joint2}) loops_of[joint].push_back(i);
      work.push_back(i);
      open.insert(i);
    }
    for (; !work.empty(); work.pop_front()) {
      const std::size_t i = work.front();
      const Loop& loop = model_.loops[i];
      const bool has1 = law_.count(loop.joint1) != 0, has2 = loop.joint2 == kNone || law_.count(loop.joint2) != 0;
      if ((!has1 && !has2) || open.erase(i) == 0) continue;
      if (has1 && has2) {
        refuse(*loop.node, "both joints have drivers already; drive one of them, the other one follows");
      }
      if (has1 && loop.factor == 0) refuse(*loop.node, "joint1 has a driver, but the equality holds it still");
      const int follower = has1 ? loop.joint2 : loop.joint1;
      const double factor = has1 ? 1 / loop.factor : loop.factor;
      try {
        drive(follower, loops_[i],
              loop.joint2 == kNone ? Law::constant(0) : times(factor, law_[has1 ? loop.joint1 : loop.joint2]), false);
      } catch (const Error&) {
        refuse(*loop.node, "the law of the other joint times " + general(factor, 6) + " is not finite");
      }
      const std::vector<std::size_t>& next = loops_of[follower];
      work.insert(work.end(), next.begin(), next.end());
    }
    if (open.empty()) return;
    const Loop& loop = model_.loops[*open.begin()];
    refuse(*loop.node, "an equality of joints is read only if one of the joints is driven; write --drive " +
                           title(loop.joint2) + "=LAW or --drive " + title(loop.joint1) + "=LAW");
  }

  // ---- bodies with their sites, and the rest

  void add_bodies() {
    std::map<std::string, std::vector<Member>> points;  // points of each body
    for (std::size_t i = 0; i < model_.sites.size(); ++i) {
      const mjcf::Site& site = model_.sites[i];
      const std::string& body = mover(site.body);
      const bool moves = body != bodies_[kWorld];
      points[body].push_back({sites_[i], triple(now_.bodies[at(site.body)] * site.frame.at), moves});
      if (moves) builder_.output(sites_[i]);
    }
    const auto add = [&](const std::string& name) {
      Body body{name};
      if (const auto own = points.find(name); own != points.end()) body.points = std::move(own->second);
      builder_.add(std::move(body));
    };
    if (points.count(bodies_[kWorld]) != 0) add(bodies_[kWorld]);
    for (std::size_t b = 1; b < model_.bodies.size(); ++b) {
      if (model_.bodies[b].joints.empty()) continue;
      add(bodies_[b]);
      ++out_.bodies;
    }
    for (const std::string& name : parts_) add(name);
  }

  void finish() {
    out_.scene = std::move(builder_.time(0, 1, 0.01)).build();
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
  TableFolders tables_;
  SceneBuilder builder_;
  ImportedModel out_;
  mjcf::Values q_;
  mjcf::Posture now_;
  std::set<std::string> names_ = {"ground"};
  std::map<std::string, std::size_t> next_;                   // number for the next name with this stem
  std::vector<std::string> joints_, sites_, bodies_, loops_;  // names in the scene
  std::vector<std::string> parts_;                            // names of bodies between joints of one body
  std::map<int, std::size_t> coordinate_of_;                  // index of each joint in ImportedModel::coordinates
  std::map<int, Law> law_;                                    // laws of driven joints
  std::map<std::string, std::size_t> left_out_;
  std::vector<std::string> notes_;
};

}  // namespace

ImportedModel import_model(const std::filesystem::path& file, const ModelOptions& options) {
  const mjcf::Document document = mjcf::read_document(file);
  const Model model = mjcf::read_model(document, file.stem().string());
  try {
    return Importer(model, options, file).import();
  } catch (const Error& error) {
    const std::vector<Diagnostic>& all = error.diagnostics();
    const bool is_of_scene = all.front().where.starts_with('/');  // a finding of build()
    throw is_of_scene ? Error(error.kind(), all, file.string()) : error;
  }
}

}  // namespace assur
