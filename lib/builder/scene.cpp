#include "assur/scene.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_set>
#include <utility>

#include "builder/validation.hpp"
#include "decimal.hpp"
#include "joints/joints.hpp"
#include "numbers.hpp"
#include "scene/axes.hpp"
#include "scene/names.hpp"
#include "scene/poses.hpp"
#include "scene/triple.hpp"

namespace assur {
namespace {

// The length of a normalised vector may differ from 1 by 3 roundings; it is not changed again.
constexpr double kRounded = 4 * kEps;
// Lengths farther than this from 1 are likely typing errors, and are reported.
constexpr double kNearlyUnit = 1e-6;

constexpr std::size_t kMostVectorsNamed = 6;  // in one note

struct Normalised {
  std::string name, where;
  double length;
};

void normalise(const std::string& name, Triple& at, const Where& where, std::vector<Normalised>& all) {
  const Number length = triple::norm(at);
  if (abs(length - 1) <= kRounded) return;
  if (std::abs(length.value() - 1) > kNearlyUnit) all.push_back({name, where.text(), length.value()});
  at = triple::scale(1 / length, at);
}

// Writes one note for all vectors.
void note_normalised(const std::vector<Normalised>& all, std::vector<Diagnostic>& warnings) {
  if (all.empty()) return;
  if (all.size() == 1) {
    warnings.push_back({all[0].where, "the vector has length " + general(all[0].length, 6) + " and is normalised"});
    return;
  }
  std::string what = std::to_string(all.size()) + " vectors are normalised: ";
  for (std::size_t i = 0; i < std::min(all.size(), kMostVectorsNamed); ++i) {
    what += (i == 0 ? "" : ", ") + all[i].name + (i == 0 ? " has length " : " ") + general(all[i].length, 6);
  }
  if (all.size() > kMostVectorsNamed) what += ", and " + std::to_string(all.size() - kMostVectorsNamed) + " more";
  warnings.push_back({"/vectors", std::move(what)});
}

// "all" asks for everything, unless an item has that name; no outputs mean the same.
void expand_all(const Scene& scene, std::vector<std::string>& outputs) {
  if (outputs.size() != 1 || outputs.front() != "all") return;
  const auto is_all = [](const auto& item) { return item.name == "all"; };
  const auto among = [&](const auto& items) { return std::any_of(items.begin(), items.end(), is_all); };
  const bool is_name = among(scene.points()) || among(scene.vectors()) || among(scene.measures()) ||
                       std::any_of(scene.bodies().begin(), scene.bodies().end(),
                                   [&](const Body& b) { return among(b.points) || among(b.vectors); });
  if (!is_name) outputs.clear();
}

// The outputs that begin with no name of a measure or member, such as "J.angle" or "B.origin".
std::vector<std::string> not_there(const Scene& scene, const std::vector<std::string>& outputs) {
  std::unordered_set<std::string_view> names;
  for (const Measure& m : scene.measures()) names.insert(m.name);
  for (const Point& p : scene.points()) names.insert(p.name);  // the origin of a pose may be in the base of a body
  for (const Body& b : scene.bodies()) {
    for (const Member& m : b.points) names.insert(m.name);
  }
  std::vector<std::string> missing;
  for (const std::string& text : outputs) {
    const std::size_t dot = text.find('.'), end = dot == text.npos ? dot : text.find('.', dot + 1);
    if (names.count(std::string_view(text).substr(0, end)) == 0) missing.push_back(text);
  }
  return missing;
}

// Poses are several outputs, but places count the outputs as written.
void name_written_output(const std::vector<std::size_t>& written, std::string& where) {
  constexpr std::string_view kOutputs = "/outputs/";
  if (written.empty() || !where.starts_with(kOutputs)) return;
  const std::size_t end = std::min(where.find('/', kOutputs.size()), where.size());
  const std::size_t index = std::stoul(where.substr(kOutputs.size(), end - kOutputs.size()));
  where = (Where("/outputs") / written[index]).text() + where.substr(end);
}

// The laws of a driver; those of a pose in the order of pose_part().
std::vector<Law*> laws_of(Driver& driver) {
  std::vector<Law*> laws;
  if (auto* pose = std::get_if<Pose>(&driver.kind)) {
    for (auto* group : {&pose->translation, &pose->rotation}) {
      for (Law& law : *group) laws.push_back(&law);
    }
    return laws;
  }
  std::visit(
      [&](auto& kind) {
        if constexpr (requires { kind.law; }) laws.push_back(&kind.law);
      },
      driver.kind);
  return laws;
}

void refuse_if_any(std::vector<Diagnostic> findings) {
  if (!findings.empty()) throw Error(Error::Kind::input, std::move(findings));
}

}  // namespace

Scene Scene::with_outputs(std::vector<std::string> outputs) const {
  if (const auto missing = not_there(*this, outputs);
      asks_for_pose(parts_->bodies, missing) || asks_for_coordinate(parts_->joints, missing)) {
    SceneBuilder builder(parts_->name, parts_->dimension);
    builder.parts_ = written();
    builder.outputs_ = std::move(outputs);
    builder.time_ = time_;
    Scene scene = builder.finish();
    scene.source_ = source_;
    scene.has_other_outputs_ = true;
    scene.has_other_time_ = has_other_time_;
    return scene;
  }
  Scene scene = *this;
  scene.has_other_outputs_ = true;
  scene.outputs_ = std::move(outputs);
  refuse_if_any(Validation(scene, {}).outputs());
  expand_all(scene, scene.outputs_);
  scene.written_outputs_ = scene.outputs_;
  return scene;
}

Scene Scene::with_time(TimeGrid time) const {
  Scene scene = *this;
  scene.has_other_time_ = true;
  scene.time_ = time;
  refuse_if_any(Validation(scene, {}).time());
  return scene;
}

Scene Scene::with_laws(const std::function<Law(const std::string& driver, const Law& before)>& law) const {
  auto parts = std::make_shared<Parts>(*parts_);
  const auto written = parts->written ? std::make_shared<Parts>(*parts->written) : nullptr;
  for (std::size_t d = 0; d < parts->drivers.size(); ++d) {
    Driver& driver = parts->drivers[d];
    const std::vector<Law*> laws = laws_of(driver);
    const bool is_pose = std::holds_alternative<Pose>(driver.kind);
    for (std::size_t part = 0; part < laws.size(); ++part) {
      *laws[part] = law(is_pose ? driver.name + "." + pose_part(part, parts->dimension) : driver.name, *laws[part]);
      if (written) *laws_of(written->drivers[d])[part] = *laws[part];
    }
  }
  parts->written = written;
  Scene scene = *this;
  scene.parts_ = std::move(parts);
  scene.source_ = nullptr;
  refuse_if_any(Validation(scene, {}).time());
  return scene;
}

SceneBuilder::SceneBuilder(std::string name, int dimension) {
  parts_.name = std::move(name);
  parts_.dimension = dimension;
}

SceneBuilder& SceneBuilder::add(Point point) {
  parts_.points.push_back(std::move(point));
  return *this;
}
SceneBuilder& SceneBuilder::add(Vector vector) {
  parts_.vectors.push_back(std::move(vector));
  return *this;
}
SceneBuilder& SceneBuilder::add(Body body) {
  parts_.bodies.push_back(std::move(body));
  return *this;
}
SceneBuilder& SceneBuilder::add(Joint joint) {
  parts_.joints.push_back(std::move(joint));
  return *this;
}
SceneBuilder& SceneBuilder::add(Constraint constraint) {
  parts_.constraints.push_back(std::move(constraint));
  return *this;
}
SceneBuilder& SceneBuilder::add(Driver driver) {
  parts_.drivers.push_back(std::move(driver));
  return *this;
}
SceneBuilder& SceneBuilder::add(Measure measure) {
  parts_.measures.push_back(std::move(measure));
  return *this;
}
SceneBuilder& SceneBuilder::add(Limit limit) {
  parts_.limits.push_back(std::move(limit));
  return *this;
}
SceneBuilder& SceneBuilder::add(DeclaredGroup group) {
  parts_.groups.push_back(std::move(group));
  return *this;
}

SceneBuilder& SceneBuilder::table(std::filesystem::path file) {
  parts_.tables.push_back(std::move(file));
  return *this;
}
SceneBuilder& SceneBuilder::reserve(std::size_t points, std::size_t constraints) {
  parts_.points.reserve(points);
  parts_.constraints.reserve(constraints);
  return *this;
}
SceneBuilder& SceneBuilder::output(std::string name) {
  outputs_.push_back(std::move(name));
  return *this;
}
SceneBuilder& SceneBuilder::time(double start, double end, double step) {
  time_ = {start, end, step};
  // build() takes three zeros for an unset grid.
  if (step == 0) diagnose({"/time/step", "the step is 0 s; it must be > 0"});
  return *this;
}
SceneBuilder& SceneBuilder::diagnose(Diagnostic diagnostic) {
  found_.push_back(std::move(diagnostic));
  return *this;
}

Scene SceneBuilder::finish() {
  const auto parts = std::make_shared<Scene::Parts>(std::move(parts_));
  std::vector<std::string> written_outputs = outputs_;
  JointParts joint_parts{parts->dimension, parts->joints,      parts->points,   parts->vectors,
                         parts->bodies,    parts->constraints, parts->drivers,  parts->measures,
                         parts->limits,    outputs_,           parts->warnings, found_};
  const AxisParts axis_parts{parts->dimension, parts->vectors, parts->drivers, parts->measures};
  if (asks_for_pose(parts->bodies, outputs_) || has_joints(joint_parts) || has_written_axes(axis_parts)) {
    parts->written = std::make_shared<const Scene::Parts>(*parts);
  }
  const std::vector<Diagnostic> wrong_axes = expand_axes(axis_parts);
  found_.insert(found_.end(), wrong_axes.begin(), wrong_axes.end());
  const std::vector<std::size_t> written = expand_poses({parts->dimension, parts->bodies, parts->measures, outputs_});
  const std::vector<Diagnostic> refused = expand_joints(joint_parts);
  const std::size_t found_before = found_.size();
  found_.insert(found_.end(), refused.begin(), refused.end());
  parts->points.shrink_to_fit();
  parts->constraints.shrink_to_fit();
  Scene scene;
  scene.parts_ = parts;
  scene.outputs_ = std::move(outputs_);
  scene.time_ = time_;

  Validation validation(scene, found_);
  const std::vector<Diagnostic> more = validation.scene();
  found_.insert(found_.end(), more.begin(), more.end());
  std::vector<Diagnostic> findings;
  for (std::size_t i = 0; i < found_.size(); ++i) {
    if (found_[i].what.empty()) continue;
    findings.push_back(found_[i]);
    if (i >= found_before) name_written_output(written, findings.back().where);
  }
  refuse_if_any(std::move(findings));

  std::vector<Normalised> normalised;
  for (Vector& vector : parts->vectors) {
    normalise(vector.name, vector.at, Where("/vectors") / vector.name / "at", normalised);
  }
  const std::vector<Body> bodies = std::exchange(parts->bodies, {});
  for (const std::size_t b : validation.body_order()) {
    Body& body = parts->bodies.emplace_back(bodies[b]);
    for (auto* members : {&body.points, &body.vectors}) {
      for (Member& member : *members) {
        if (member.in_ground && body.name != "ground") member.local = validation.local(member.name);
        member.in_ground = false;
      }
    }
    for (Member& member : body.vectors) {
      normalise(member.name, member.local, Where("/bodies") / body.name / "vectors" / member.name, normalised);
    }
  }
  expand_all(scene, scene.outputs_);
  scene.written_outputs_ = scene.outputs_.empty() ? scene.outputs_ : std::move(written_outputs);
  note_normalised(normalised, parts->warnings);
  return scene;
}

}  // namespace assur
