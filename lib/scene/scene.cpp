#include "assur/scene.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "decimal.hpp"
#include "scene/joints/joints.hpp"
#include "scene/names.hpp"
#include "scene/poses.hpp"
#include "scene/triple.hpp"
#include "scene/validation.hpp"

namespace assur {
namespace {

// Lengths farther than this from 1 are likely typing errors, and are reported.
constexpr double kNearlyUnit = 1e-6;

constexpr std::size_t kMostVectorsNamed = 6;

struct Normalised {
  std::string name, where;
  double length;
};

void normalise(const std::string& name, Triple& at, const Where& where, std::vector<Normalised>& all) {
  const double length = triple::norm(at);
  if (length == 1) return;
  if (std::abs(length - 1) > kNearlyUnit) all.push_back({name, where.text(), length});
  at = triple::scale(1 / length, at);
}

// Writes one note for all vectors.
void tell(const std::vector<Normalised>& all, std::vector<Diagnostic>& warnings) {
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

void refuse_if_any(std::vector<Diagnostic> findings) {
  if (!findings.empty()) throw Error(Error::Kind::input, std::move(findings));
}

}  // namespace

Scene Scene::with_outputs(std::vector<std::string> outputs) const {
  if (asks_for_pose(parts_->bodies, outputs)) {
    SceneBuilder builder(parts_->name, parts_->dimension);
    builder.parts_ = *parts_;
    builder.outputs_ = std::move(outputs);
    builder.time_ = time_;
    return builder.finish(true);
  }
  Scene scene = *this;
  scene.outputs_ = std::move(outputs);
  refuse_if_any(Validation(scene, {}).outputs());
  expand_all(scene, scene.outputs_);
  return scene;
}

Scene Scene::with_time(TimeGrid time) const {
  Scene scene = *this;
  scene.time_ = time;
  refuse_if_any(Validation(scene, {}).time());
  return scene;
}

Scene Scene::with_laws(const std::function<Law(const std::string& driver, const Law& before)>& law) const {
  auto parts = std::make_shared<Parts>(*parts_);
  for (Driver& driver : parts->drivers) {
    if (auto* pose = std::get_if<Pose>(&driver.kind)) {
      std::size_t part = 0;
      for (auto* laws : {&pose->translation, &pose->rotation}) {
        for (Law& own : *laws) own = law(driver.name + "." + pose_part(part++, parts->dimension), own);
      }
      continue;
    }
    std::visit(
        [&](auto& kind) {
          if constexpr (requires { kind.law; }) kind.law = law(driver.name, kind.law);
        },
        driver.kind);
  }
  Scene scene = *this;
  scene.parts_ = std::move(parts);
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

Scene SceneBuilder::finish(bool expanded) {
  const auto parts = std::make_shared<Scene::Parts>(std::move(parts_));
  expand_poses({parts->dimension, parts->points, parts->vectors, parts->bodies, parts->measures, outputs_,
                parts->without_frame});
  JointParts joint_parts{parts->dimension, parts->joints,      parts->points,   parts->vectors,
                         parts->bodies,    parts->constraints, parts->drivers,  parts->measures,
                         parts->limits,    outputs_,           parts->warnings, parts->without_frame};
  if (!expanded) {
    const auto is_known = [this](const std::string& where) {  // a part that was not read is refused once
      return std::ranges::any_of(found_, [&](const Diagnostic& d) { return d.where == where; });
    };
    std::vector<Diagnostic> more = expand_joints(joint_parts);
    std::erase_if(more, [&](const Diagnostic& d) { return is_known(d.where); });
    found_.insert(found_.end(), more.begin(), more.end());
  }
  parts->points.shrink_to_fit();
  parts->constraints.shrink_to_fit();
  Scene scene;
  scene.parts_ = parts;
  scene.outputs_ = std::move(outputs_);
  scene.time_ = time_;

  Validation validation(scene, found_);
  const std::vector<Diagnostic> more = validation.scene();
  std::vector<Diagnostic> findings;
  for (const Diagnostic& finding : found_) {
    if (!finding.what.empty()) findings.push_back(finding);
  }
  findings.insert(findings.end(), more.begin(), more.end());
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
  tell(normalised, parts->warnings);
  return scene;
}

}  // namespace assur
