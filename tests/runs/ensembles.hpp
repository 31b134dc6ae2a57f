// Members of ensembles and their expected results.
#pragma once

#include <gtest/gtest.h>

#include <functional>

#include "assur/ensemble.hpp"
#include "errors/conditions.hpp"
#include "motion/fan.hpp"
#include "motion/limited.hpp"
#include "source_dir.hpp"

namespace assur::test {

using SceneOf = std::function<Scene(std::size_t)>;

inline std::function<Prepared(std::size_t)> prepared(const SceneOf& scene, const std::string& strategy) {
  return [=](std::size_t i) { return prepare(scene(i), {strategy, {}, ThreadBudget{4}}); };
}

inline Ensemble ensemble(std::size_t members, const SceneOf& scene, const std::string& strategy = "groups/eigen:4") {
  return {members, prepared(scene, strategy)};
}

// Compares rows, status and events of one member with a single simulator.
inline void expect_member(const Ensemble& e, const EnsembleTrajectory& all, std::size_t i, const Scene& scene,
                          const std::string& strategy, std::size_t every = 1) {
  SCOPED_TRACE("member " + std::to_string(i) + " of " + scene.name() + ", " + strategy);
  Simulator lone = simulator(scene, strategy.substr(0, strategy.find(' ')));
  const Trajectory t = lone.run(all.times());
  const Ensemble::Outcome& outcome = e.outcomes()[i];
  EXPECT_EQ(outcome.cannot, "");
  EXPECT_EQ(outcome.status.code, lone.report().status.code);
  ASSERT_EQ(all.rows(i), t.rows());
  EXPECT_EQ(all.columns(), t.columns());
  const std::vector<double> conditions = test::conditions(scene, all.times(), every);
  ASSERT_GE(conditions.size(), t.rows());
  const double residual = residual_of(e.report(), lone.report());
  const Sizes sizes = test::sizes(t);
  for (std::size_t k = 0; k < t.rows(); ++k) {
    expect_same_row(all.row(i, k), t, k, sizes, conditions[k], residual);
    if (testing::Test::HasFailure()) return;
  }
  for (std::size_t k = t.rows(); k < all.times().size(); ++k) EXPECT_TRUE(std::isnan(all(i, k, 0)));
  ASSERT_EQ(outcome.events.size(), lone.report().events.size());
  for (std::size_t n = 0; n < outcome.events.size(); ++n) {
    const Event &mine = outcome.events[n], &theirs = lone.report().events[n];
    EXPECT_EQ(mine.kind, theirs.kind);
    EXPECT_EQ(mine.group, theirs.group);
    EXPECT_LE(mine.time, theirs.until);  // the brackets of both events overlap
    EXPECT_GE(mine.until, theirs.time);
  }
  EXPECT_LE(outcome.reached, lone.report().reached + scene.time().step);
  EXPECT_GE(outcome.reached, t.times().back());
}

inline std::string file(const std::string& name) { return std::string(ASSUR_SOURCE_DIR) + "/scenes/" + name + ".json"; }

inline double share(std::size_t i, std::size_t of) { return static_cast<double>(i) / static_cast<double>(of); }

inline Scene slider_crank(std::size_t i) {
  return read_scene(file("slider_crank"), {{"crank_length", 0.05 + 0.1 * share(i, 11)},
                                           {"offset", 0.1 * share(i, 11) - 0.05},
                                           {"step", 0.02},
                                           {"steps", 60}});
}
inline Scene four_bar(std::size_t i) {
  return read_scene(file("four_bar"), {{"crank_length", 0.5 + 0.3 * share(i, 11)},
                                       {"rocker_length", 1.3 + 0.1 * share(i * 5 % 11, 11)},
                                       {"step", 0.02},
                                       {"steps", 60}});
}
inline Scene stewart(std::size_t i) { return sample("stewart", {{"omega", 0.5 + share(i, 11)}, {"steps", 30}}); }
inline Scene chain(std::size_t i) {
  return sample("four_bar:3", {{"omega", 1 + 0.2 * static_cast<double>(i)}, {"steps", 60}});
}

inline void expect_same_bits(const EnsembleTrajectory& a, const EnsembleTrajectory& b) {
  ASSERT_EQ(a.values().size(), b.values().size());
  for (std::size_t i = 0; i < a.values().size(); ++i) {
    const double x = a.values()[i], y = b.values()[i];
    ASSERT_TRUE(x == y || (std::isnan(x) && std::isnan(y))) << i;
  }
}

// The last of 11 members meet their limits during the run; the coupler of member 3 does not reach the rocker.
inline Scene partly_limited(std::size_t i) {
  const Law law = Law::polynomial({0.5, 0.4 + 0.05 * static_cast<double>(i)});
  if (i != 3) return limited_four_bar(law).time(0, 1.5, 0.01).build();
  SceneBuilder b("impossible", 2);
  b.fixed_point("A0", {0, 0, 0}).fixed_point("A1", {2, 0, 0});
  b.point("B", {std::cos(0.5), std::sin(0.5), 0}).point("C", {1.7, 1.1, 0});
  b.constrain("crank", Distance{"A0", "B", 1.0}).constrain("coupler", Distance{"B", "C", 0.01});
  b.constrain("rocker", Distance{"A1", "C", 1.2}).drive("motor", PointAngle{"A0", "B", "", law});
  return b.time(0, 1.5, 0.01).build();
}

inline Scene with_law(Law law, double end = 1) {
  SceneBuilder b("driven", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("D", {2, 0, 0});
  b.point("B", {0.8, 0, 0}).point("C", {1.6, 1.2, 0});
  b.constrain("crank", Distance{"A", "B", 0.8}).constrain("coupler", Distance{"B", "C", 1.8});
  b.constrain("rocker", Distance{"D", "C", 1.3});
  b.drive("motor", PointAngle{"A", "B", "", std::move(law)});
  b.measure("crank_angle", AbsoluteAngle{"A", "B"}).measure("rocker_angle", AbsoluteAngle{"D", "C"});
  return b.time(0, end, 0.01).build();
}

inline Law turning(double rate) {
  return Law::function([=](double t) -> Motion { return {rate * t, rate, 0}; });
}

inline Scene with_callback(double rocker, Callback callback) {
  SceneBuilder b("called", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("D", {2, 0, 0});
  b.point("B", {0.8, 0, 0}).point("C", {1.6, rocker - 0.1, 0});
  b.constrain("crank", Distance{"A", "B", 0.8}).constrain("coupler", Distance{"B", "C", 1.8});
  b.constrain("rocker", std::move(callback)).drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, 3})});
  return b.time(0, 1, 0.01).build();
}

inline Scene on_a_rail() {
  SceneBuilder b("rail", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("D", {2, 0, 0}).fixed_vector("rail", {1, 0, 0});
  b.point("B", {0.8, 0, 0}).point("C", {2.6, 0, 0});
  b.constrain("crank", Distance{"A", "B", 0.8}).constrain("coupler", Distance{"B", "C", 1.8});
  b.constrain("slide", OnLine{"C", "D", "rail"});
  b.drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, 3})});
  return b.time(0, 1, 0.01).build().with_outputs({"B", "C"});
}

// The coupler keeps its direction.
inline Scene in_translation() {
  SceneBuilder b("translation", 2);
  b.fixed_point("A", {0, 0, 0}).point("B", {0.8, 0, 0}).point("C", {2.6, 0, 0});
  b.constrain("crank", Distance{"A", "B", 0.8}).constrain("coupler", Linear{{{"C", 1}, {"B", -1}}, {1.8, 0, 0}});
  b.drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, 3})});
  return b.time(0, 1, 0.01).build().with_outputs({"B", "C"});
}

}  // namespace assur::test
