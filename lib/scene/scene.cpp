#include "assur/scene.hpp"

#include <cmath>
#include <utility>

#include "scene/names.hpp"
#include "scene/triple.hpp"
#include "scene/validation.hpp"

namespace assur {
namespace {

// Lengths this far from 1 are typing errors rather than rounding: they are told.
constexpr double kNearlyUnit = 1e-6;

void normalise(Triple& at, const Where& where, std::vector<Diagnostic>& warnings) {
  const double length = triple::norm(at);
  if (length == 1) return;
  if (std::abs(length - 1) > kNearlyUnit) {
    warnings.push_back({where.text(), "the vector has length " + shortest(length) + " and is normalised"});
  }
  at = triple::scale(1 / length, at);
}

void refuse_if_any(std::vector<Diagnostic> findings) {
  if (!findings.empty()) throw Error(Error::Kind::input, std::move(findings));
}

}  // namespace

Scene Scene::with_outputs(std::vector<std::string> outputs) const {
  Scene scene = *this;
  scene.outputs_ = std::move(outputs);
  refuse_if_any(Validation(scene, {}).outputs());
  return scene;
}

Scene Scene::with_time(TimeGrid time) const {
  Scene scene = *this;
  scene.time_ = time;
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
SceneBuilder& SceneBuilder::add(DeclaredGroup group) {
  parts_.groups.push_back(std::move(group));
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
  // build() takes three zeros for a grid that was never given.
  if (step == 0) diagnose({"/time/step", "the step is 0 s; it must be > 0"});
  return *this;
}
SceneBuilder& SceneBuilder::diagnose(Diagnostic diagnostic) {
  found_.push_back(std::move(diagnostic));
  return *this;
}

Scene SceneBuilder::finish() {
  const auto parts = std::make_shared<Scene::Parts>(std::move(parts_));
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

  for (Vector& vector : parts->vectors) normalise(vector.at, Where("/vectors") / vector.name / "at", parts->warnings);
  const std::vector<Body> bodies = std::exchange(parts->bodies, {});
  for (const std::size_t b : validation.body_order()) {
    Body& body = parts->bodies.emplace_back(bodies[b]);
    for (Member& member : body.vectors) {
      normalise(member.local, Where("/bodies") / body.name / "vectors" / member.name, parts->warnings);
    }
  }
  return scene;
}

}  // namespace assur
