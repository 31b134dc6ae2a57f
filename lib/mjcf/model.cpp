#include "mjcf/model.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <set>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>

#include "scene/names.hpp"

namespace assur::mjcf {
namespace {

constexpr std::string_view kTurns[] = {"quat", "axisangle", "xyaxes", "zaxis", "euler"};
constexpr double kFlat = 1e-10;  // shortest vector that has a direction

// Sections and elements that are ignored or read. All others are refused.
constexpr std::string_view kSections[] = {"option", "size",   "statistic", "visual",     "asset",    "contact",
                                          "sensor", "tendon", "custom",    "deformable", "extension"};
constexpr std::string_view kRead[] = {"compiler", "default", "worldbody", "equality", "actuator", "keyframe"};
constexpr std::string_view kWithoutMotion[] = {"inertial", "geom", "camera", "light", "plugin"};

class Reading {
 public:
  Reading(const Document& document, const std::string& name) : document_(document) { model_.name = name; }

  Model read() {
    const Node& root = document_.root;
    if (const std::string* name = root.find("model"); name != nullptr && !name->empty()) {
      model_.name = excerpt(*name);
    }
    for (const Node& section : root.children) {
      if (section.tag == "compiler") read_compiler(section);
      if (section.tag == "default") check_defaults(section), defaults_.add(section);
    }
    model_.bodies.push_back({&root, "world", kNone, {}, {}});
    each("worldbody", [&](const Node& section) { read_children(section, kWorld, {}, Defaults::kMain); });
    refer_ = posture(model_, reference(model_));
    each("equality", [&](const Node& section) {
      for (const Node& node : section.children) read_equality(node);
    });
    each("actuator", [&](const Node& section) {
      for (const Node& node : section.children) read_actuator(node);
    });
    each("keyframe", [&](const Node& section) {
      for (const Node& node : section.children) read_key(node);
    });
    for (const Node& section : root.children) leave_out(section);
    return std::move(model_);
  }

 private:
  void each(std::string_view tag, const std::function<void(const Node&)>& read) {
    for (const Node& section : document_.root.children) {
      if (section.tag == tag) read(section);
    }
  }

  static bool is_one_of(std::string_view word, std::span<const std::string_view> words) {
    return std::find(words.begin(), words.end(), word) != words.end();
  }

  // ---- sections

  void leave_out(const Node& section) {
    if (is_one_of(section.tag, kRead)) return;
    if (!is_one_of(section.tag, kSections)) {
      std::vector<std::string_view> all(std::begin(kRead), std::end(kRead));
      all.insert(all.end(), std::begin(kSections), std::end(kSections));
      refuse(section, "there is no such section" + suggestion(section.tag, all));
    }
    if (section.children.empty()) ++model_.left_out[section.tag];
    for (const Node& child : section.children) ++model_.left_out[child.tag];
  }

  void read_compiler(const Node& node) {
    const auto is = [&](std::string_view name, std::string_view one, std::string_view other) {
      const std::string* value = node.find(name);
      if (value == nullptr) return 0;
      if (*value != one && *value != other) {
        refuse(node, "the attribute " + in_quotes(name) + " is " + std::string(one) + " or " + std::string(other) +
                         ", not " + in_quotes(*value));
      }
      return *value == one ? 1 : 2;
    };
    if (const int angle = is("angle", "degree", "radian"); angle != 0) unit_ = angle == 1 ? std::numbers::pi / 180 : 1;
    if (is("coordinate", "local", "global") == 2) {
      refuse(node, "global coordinates are not read; MuJoCo itself has given them up: save the model with local ones");
    }
    if (const int automatic = is("autolimits", "true", "false"); automatic != 0) limits_ranges_ = automatic == 1;
    if (is("alignfree", "false", "true") == 2) {
      refuse(node, "alignfree=\"true\" moves frames to centres of mass, which are not read");
    }
    if (const std::string* sequence = node.find("eulerseq"); sequence != nullptr) {
      if (sequence->size() != 3 || sequence->find_first_not_of("xyzXYZ") != std::string::npos) {
        refuse(node, "the attribute 'eulerseq' is three letters of x, y, z, X, Y, Z, not " + in_quotes(*sequence));
      }
      sequence_ = *sequence;
    }
  }

  static void check_defaults(const Node& node) {
    static constexpr std::string_view kOthers[] = {
        "mesh",     "material", "geom",        "camera", "light",    "pair",   "tendon",   "general", "motor",
        "position", "velocity", "intvelocity", "damper", "cylinder", "muscle", "adhesion", "flex",    "plugin"};
    for (const Node& child : node.children) {
      if (child.tag == "default") {
        check_defaults(child);
      } else if (child.tag != "joint" && child.tag != "site" && child.tag != "equality" &&
                 !is_one_of(child.tag, kOthers)) {
        std::vector<std::string_view> all(std::begin(kOthers), std::end(kOthers));
        all.insert(all.end(), {"default", "joint", "site", "equality"});
        refuse(child, "there are no defaults of this kind" + suggestion(child.tag, all));
      }
    }
  }

  // ---- bodies

  void read_children(const Node& of, int body, const Frame& frame, std::size_t outer) {
    const std::string* child_class = of.find("childclass");
    const std::size_t own = child_class != nullptr ? defaults_.find(*child_class, of) : outer;
    for (const Node& node : of.children) {
      if (node.tag == "body") {
        read_body(node, body, frame, own);
      } else if (node.tag == "frame") {
        read_children(node, body, frame * frame_of(Attributes(node, defaults_, own)), own);
      } else if (node.tag == "joint" || node.tag == "freejoint") {
        if (of.tag != "body") {
          refuse(node, of.tag == "frame" ? "joints inside a <frame> are not read; write them in the body itself"
                                         : "the world has no joints");
        }
        read_joint(node, body, own);
      } else if (node.tag == "site") {
        read_site(node, body, frame, own);
      } else if (is_one_of(node.tag, kWithoutMotion)) {
        ++model_.left_out[node.tag];
      } else {
        static const std::vector<std::string_view> kAll = {"body",     "frame", "joint",  "freejoint", "site",
                                                           "inertial", "geom",  "camera", "light",     "plugin"};
        static constexpr std::string_view kOthers[] = {"composite", "flexcomp", "replicate", "attach"};
        refuse(node, is_one_of(node.tag, kOthers) ? "this element makes bodies in a way that is not read; save the "
                                                    "model from MuJoCo, which writes them out"
                                                  : "there is no such element" + suggestion(node.tag, kAll));
      }
    }
  }

  std::size_t class_of(const Node& node, std::size_t outer) const {
    const std::string* name = node.find("class");
    return name != nullptr ? defaults_.find(*name, node) : outer;
  }

  // Remembers a name, which must be the only one of its kind, as that of the item with this index.
  std::string name_of(const Node& node, const char* kind, std::size_t index) {
    const std::string* name = node.find("name");
    if (name == nullptr || name->empty()) return "";
    if (!names_[kind].emplace(*name, static_cast<int>(index)).second) {
      refuse(node, std::string("another ") + kind + " has this name");
    }
    return *name;
  }

  void read_body(const Node& node, int parent, const Frame& around, std::size_t outer) {
    const int self = static_cast<int>(model_.bodies.size());
    const Attributes attributes(node, defaults_, outer);
    if (attributes.is_true("mocap", false)) {
      refuse(node, "bodies that a program moves (mocap) are not read; give the body joints, and drive them");
    }
    model_.bodies.push_back(
        {&node, name_of(node, "body", model_.bodies.size()), parent, around * frame_of(attributes), {}});
    read_children(node, self, {}, outer);
  }

  void read_joint(const Node& node, int body, std::size_t outer) {
    Joint j;
    j.node = &node;
    j.name = name_of(node, "joint", model_.joints.size());
    j.body = body;
    const Attributes attributes(node, defaults_, node.tag == "joint" ? class_of(node, outer) : Defaults::kMain);
    if (node.tag == "freejoint") {
      j.kind = Joint::Kind::free;
    } else if (const std::string* type = attributes.text("type"); type != nullptr) {
      static const std::vector<std::string_view> kTypes = {"hinge", "slide", "ball", "free"};
      const auto found = std::find(kTypes.begin(), kTypes.end(), *type);
      if (found == kTypes.end())
        refuse(node, "there is no joint type " + in_quotes(*type) + known_instead(*type, kTypes));
      j.kind = static_cast<Joint::Kind>(found - kTypes.begin());
    }
    if (const auto at = attributes.numbers<3>("pos"); at && j.kind != Joint::Kind::free) j.at = vector(*at);
    if (const auto axis = attributes.numbers<3>("axis"); axis && j.has_coordinate()) {
      j.axis = direction(node, "axis", vector(*axis));
    }
    read_range(attributes, j);
    if (j.has_coordinate()) j.reference = attributes.number("ref", 0) * (j.kind == Joint::Kind::hinge ? unit_ : 1);
    Body& of = model_.bodies[static_cast<std::size_t>(body)];
    if (j.kind == Joint::Kind::free && of.parent != kWorld) {
      refuse(node, "only a body whose parent is the world can be free");
    }
    const auto is_free = [&](int i) { return model_.joints[static_cast<std::size_t>(i)].kind == Joint::Kind::free; };
    if (!of.joints.empty() && (j.kind == Joint::Kind::free || is_free(of.joints.front()))) {
      refuse(node, "a free body has no other joint");
    }
    j.first = model_.values;
    model_.values += j.values();
    of.joints.push_back(static_cast<int>(model_.joints.size()));
    model_.joints.push_back(std::move(j));
  }

  // As MuJoCo decides: a joint is limited if it says so, or if it has a range and does not say otherwise.
  void read_range(const Attributes& attributes, Joint& j) {
    const Node& node = attributes.node();
    const std::string* const says = attributes.text("limited");
    const bool automatic = says == nullptr || *says == "auto";
    if (!automatic && *says != "true" && *says != "false") {
      refuse(node, "the attribute 'limited' is true, false or auto, not " + in_quotes(*says));
    }
    const auto range = attributes.numbers<2>("range");
    const bool limited = automatic ? range && limits_ranges_ : *says == "true";
    if (!limited || j.kind == Joint::Kind::free) return;
    if (!j.has_coordinate()) {
      ++model_.left_out["range of a ball joint"];
      return;
    }
    if (!range || !((*range)[0] < (*range)[1])) {
      refuse(node, "a limited joint needs a range of two numbers, of which the first is the smaller one");
    }
    const double unit = j.kind == Joint::Kind::hinge ? unit_ : 1;
    j.range = {(*range)[0] * unit, (*range)[1] * unit};
  }

  void read_site(const Node& node, int body, const Frame& around, std::size_t outer) {
    const Attributes attributes(node, defaults_, class_of(node, outer));
    Site site{&node, name_of(node, "site", model_.sites.size()), body, around * frame_of(attributes), true};
    if (const auto ends = attributes.numbers<6>("fromto"); ends) {
      const Eigen::Map<const Vector3d> from(ends->data()), to(ends->data() + 3);
      site.frame = around * Frame{(from + to) / 2, Quaterniond::Identity()};
      site.has_frame = false;
    }
    model_.sites.push_back(std::move(site));
  }

  // ---- places and directions

  static Vector3d vector(const std::array<double, 3>& values) { return {values[0], values[1], values[2]}; }

  static Vector3d direction(const Node& node, std::string_view name, const Vector3d& along) {
    if (!(along.norm() > kFlat))
      refuse(node, "the attribute " + in_quotes(name) + " has no direction; its length is 0");
    return along.normalized();
  }

  Frame frame_of(const Attributes& a) const {
    Frame frame;
    if (const auto at = a.numbers<3>("pos"); at) frame.at = vector(*at);
    frame.turn = turn_of(a);
    return frame;
  }

  // An orientation of the element takes precedence over one of its class.
  Quaterniond turn_of(const Attributes& a) const {
    std::string_view chosen;
    for (const bool own : {true, false}) {
      for (const std::string_view name : kTurns) {
        if (own ? !a.has_own(name) : a.text(name) == nullptr) continue;
        if (!chosen.empty()) {
          refuse(a.node(), "the orientation is given twice, by " + in_quotes(chosen) + " and " + in_quotes(name));
        }
        chosen = name;
      }
      if (!chosen.empty()) break;
    }
    if (chosen.empty()) return Quaterniond::Identity();
    if (chosen == "quat") {
      const auto q = *a.numbers<4>(chosen);
      const Quaterniond turn(q[0], q[1], q[2], q[3]);
      if (!(turn.norm() > kFlat)) refuse(a.node(), "the attribute 'quat' is 0");
      return turn.normalized();
    }
    if (chosen == "axisangle") {
      const auto v = *a.numbers<4>(chosen);
      return Quaterniond(Eigen::AngleAxisd(v[3] * unit_, direction(a.node(), chosen, {v[0], v[1], v[2]})));
    }
    if (chosen == "xyaxes") {
      const auto v = *a.numbers<6>(chosen);
      const Vector3d x = direction(a.node(), chosen, {v[0], v[1], v[2]}), given(v[3], v[4], v[5]);
      const Vector3d y = direction(a.node(), chosen, given - x * x.dot(given));
      Eigen::Matrix3d axes;
      axes << x, y, x.cross(y);
      return Quaterniond(axes).normalized();
    }
    if (chosen == "zaxis") {
      const auto v = *a.numbers<3>(chosen);
      return Quaterniond::FromTwoVectors(Vector3d::UnitZ(), direction(a.node(), chosen, vector(v)));
    }
    const auto v = *a.numbers<3>(chosen);
    Quaterniond turn = Quaterniond::Identity();
    for (std::size_t k = 0; k < 3; ++k) {
      const bool fixed_axes = sequence_[k] < 'a';  // capitals
      const Vector3d axis = Vector3d::Unit(sequence_[k] - (fixed_axes ? 'X' : 'x'));
      const Quaterniond one(Eigen::AngleAxisd(v[k] * unit_, axis));
      turn = fixed_axes ? one * turn : turn * one;
    }
    return turn.normalized();
  }

  // ---- equalities, actuators and keyframes, which refer to bodies, joints and sites

  int find(const Node& node, const std::string& kind, const std::string& name) const {
    std::vector<std::string_view> names;
    if (const auto all = names_.find(kind); all != names_.end()) {
      if (const auto found = all->second.find(name); found != all->second.end()) return found->second;
      for (const auto& [other, index] : all->second) names.push_back(other);
    }
    refuse(node, "there is no " + kind + " " + in_quotes(name) + known_instead(name, names));
  }

  const Frame& refer(int body) const { return refer_.bodies[static_cast<std::size_t>(body)]; }

  void read_equality(const Node& node) {
    if (node.tag != "connect" && node.tag != "weld" && node.tag != "joint") {
      static const std::vector<std::string_view> kAll = {"connect", "weld", "joint"};
      static constexpr std::string_view kOthers[] = {"tendon", "flex", "flexvert", "flexstrain", "distance"};
      refuse(node, is_one_of(node.tag, kOthers) ? "equalities of this kind are not read; connect, weld and joint are"
                                                : "there is no such equality" + suggestion(node.tag, kAll));
    }
    const Attributes a(node, defaults_, class_of(node, Defaults::kMain));
    if (!a.is_true("active", true)) {
      ++model_.left_out["equality that is not active"];
      return;
    }
    Loop loop;
    loop.node = &node;
    loop.name = name_of(node, "equality", model_.loops.size());
    if (node.tag == "joint") {
      read_joint_equality(a, loop);
    } else {
      loop.kind = node.tag == "weld" ? Loop::Kind::weld : Loop::Kind::connect;
      read_places(a, loop);
    }
    model_.loops.push_back(std::move(loop));
  }

  void read_places(const Attributes& a, Loop& loop) {
    const Node& node = a.node();
    const bool is_weld = loop.kind == Loop::Kind::weld;
    if (is_weld && a.number("torquescale", 1) == 0) {
      refuse(node, "a weld with torquescale=\"0\" keeps a point only; write it as <connect>");
    }
    const std::string *site1 = node.find("site1"), *site2 = node.find("site2");
    const std::string *body1 = node.find("body1"), *body2 = node.find("body2");
    if (site1 != nullptr || site2 != nullptr) {
      if (site1 == nullptr || site2 == nullptr || body1 != nullptr || body2 != nullptr || a.has_own("anchor")) {
        refuse(node, "either 'site1' and 'site2' are wanted, or 'body1' with 'body2' and 'anchor'");
      }
      for (const auto& [name, body, frame] :
           {std::tuple(site1, &loop.body1, &loop.frame1), std::tuple(site2, &loop.body2, &loop.frame2)}) {
        const Site& site = model_.sites[static_cast<std::size_t>(find(node, "site", *name))];
        if (is_weld && !site.has_frame) {
          refuse(node, "the site " + in_quotes(*name) + " has 'fromto'; welds need sites with an orientation");
        }
        *body = site.body;
        *frame = site.frame;
      }
      return;
    }
    if (body1 == nullptr) refuse(node, "the attribute 'body1' is missing");
    loop.body1 = find(node, "body", *body1);
    if (body2 != nullptr) loop.body2 = find(node, "body", *body2);
    const auto anchor = a.numbers<3>("anchor");
    const Frame &first = refer(loop.body1), &second = refer(loop.body2);
    if (!is_weld) {
      if (!anchor) refuse(node, "the attribute 'anchor' is missing");
      loop.frame1.at = vector(*anchor);
      loop.frame2.at = second.inverse() * (first * loop.frame1.at);
      return;
    }
    const auto pose = a.numbers<7>("relpose");
    const bool has_pose = pose && std::any_of(pose->begin() + 3, pose->end(), [](double x) { return x != 0; });
    loop.frame1 = has_pose ? Frame{{(*pose)[0], (*pose)[1], (*pose)[2]},
                                   Quaterniond((*pose)[3], (*pose)[4], (*pose)[5], (*pose)[6]).normalized()}
                           : first.inverse() * second;
  }

  void read_joint_equality(const Attributes& a, Loop& loop) {
    const Node& node = a.node();
    loop.kind = Loop::Kind::joint;
    const auto joint = [&](const char* name, int& out) {
      const std::string* text = node.find(name);
      if (text == nullptr) return;
      out = find(node, "joint", *text);
      if (!model_.joints[static_cast<std::size_t>(out)].has_coordinate()) {
        refuse(node, "the joint " + in_quotes(*text) + " is neither hinge nor slide");
      }
    };
    joint("joint1", loop.joint1);
    joint("joint2", loop.joint2);
    if (loop.joint1 == kNone) refuse(node, "the attribute 'joint1' is missing");
    if (loop.joint1 == loop.joint2) refuse(node, "both joints are " + in_quotes(*node.find("joint1")));
    const auto c = a.numbers<5>("polycoef", 0).value_or(std::array<double, 5>{0, 1, 0, 0, 0});
    loop.offset = c[0];
    loop.factor = loop.joint2 == kNone ? 0 : c[1];
    if (loop.joint2 != kNone && (c[2] != 0 || c[3] != 0 || c[4] != 0)) {
      refuse(node, "'polycoef' has powers of the joint from the square on; only c0 + c1 joint2 is read");
    }
  }

  void read_actuator(const Node& node) {
    static const std::vector<std::string_view> kKinds = {"general", "motor",  "position", "velocity", "intvelocity",
                                                         "damper",  "muscle", "cylinder", "adhesion", "plugin"};
    if (!is_one_of(node.tag, kKinds)) refuse(node, "there is no such actuator" + suggestion(node.tag, kKinds));
    Actuator actuator{&node, name_of(node, "actuator", model_.actuators.size()), kNone};
    const std::string* joint = node.find("joint");
    if (joint == nullptr) joint = node.find("jointinparent");
    if (joint == nullptr) {
      ++model_.left_out["actuator without joint"];
      return;
    }
    actuator.joint = find(node, "joint", *joint);
    if (!model_.joints[static_cast<std::size_t>(actuator.joint)].has_coordinate()) {
      ++model_.left_out["actuator of a ball or free joint"];
      return;
    }
    if (!actuated_.insert(actuator.joint).second) {
      ++model_.left_out["further actuator of a joint"];
      return;
    }
    model_.actuators.push_back(std::move(actuator));
  }

  void read_key(const Node& node) {
    if (node.tag != "key") refuse(node, "there is no such element; the only one here is key");
    const std::string name = name_of(node, "key", model_.keys.size());
    const std::string* text = node.find("qpos");
    std::vector<double> q = text == nullptr ? reference(model_) : numbers_of(node, "qpos", *text);
    if (q.size() != model_.values) {
      refuse(node, "the attribute 'qpos' has " + std::to_string(q.size()) + " numbers; the joints have " +
                       std::to_string(model_.values));
    }
    for (const Joint& j : model_.joints) {
      if (j.has_coordinate()) continue;
      const std::size_t at = j.first + (j.kind == Joint::Kind::free ? 3 : 0);
      const Eigen::Map<const Eigen::Vector4d> turn(q.data() + at);
      if (!(turn.norm() > kFlat)) refuse(node, "the quaternion of a joint in 'qpos' is 0");
    }
    if (!name.empty()) model_.keys.emplace(name, std::move(q));
  }

  const Document& document_;
  Model model_;
  Defaults defaults_;
  Posture refer_;  // of the model
  double unit_ = std::numbers::pi / 180;
  bool limits_ranges_ = true;  // a joint with a range is limited unless it says otherwise
  std::string sequence_ = "xyz";
  std::map<std::string, std::map<std::string, int>> names_ = {{"body", {{"world", kWorld}}}};  // of each kind
  std::set<int> actuated_;                                                                     // joints
};

}  // namespace

int Model::mover(int body) const {
  while (body != kWorld && bodies[static_cast<std::size_t>(body)].joints.empty()) {
    body = bodies[static_cast<std::size_t>(body)].parent;
  }
  return body;
}

Model read_model(const Document& document, const std::string& name) { return Reading(document, name).read(); }

}  // namespace assur::mjcf
