// Members of an ensemble are what a simulator of each gives, whatever their neighbours in the lanes do.
#include "assur/ensemble.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <numbers>
#include <sstream>

#include "assur/machine.hpp"
#include "backends/allocations.hpp"
#include "simulation/conditions.hpp"
#include "simulation/fan.hpp"
#include "simulation/limited.hpp"

namespace assur {
namespace {

using test::kEps;

using SceneOf = std::function<Scene(std::size_t)>;

std::function<Prepared(std::size_t)> prepared(const SceneOf& scene, const std::string& strategy) {
  return [=](std::size_t i) { return prepare(scene(i), {strategy, {}, ThreadBudget{4}}); };
}

Ensemble ensemble(std::size_t members, const SceneOf& scene, const std::string& strategy = "groups/eigen:4") {
  return {members, prepared(scene, strategy)};
}

// Rows, status and events of one member against a simulator of its own.
void expect_member(const Ensemble& e, const EnsembleTrajectory& all, std::size_t i, const Scene& scene,
                   const std::string& strategy, std::size_t every = 1) {
  SCOPED_TRACE("member " + std::to_string(i) + " of " + scene.name() + ", " + strategy);
  Simulator lone = test::simulator(scene, strategy.substr(0, strategy.find(' ')));
  const Trajectory t = lone.run(all.times());
  const Ensemble::Outcome& outcome = e.outcomes()[i];
  EXPECT_EQ(outcome.cannot, "");
  EXPECT_EQ(outcome.status.code, lone.report().status.code);
  ASSERT_EQ(all.rows(i), t.rows());
  EXPECT_EQ(all.columns(), t.columns());
  const std::vector<double> conditions = test::conditions(scene, all.times(), every);
  ASSERT_GE(conditions.size(), t.rows());
  const double residual = test::residual_of(e.report(), lone.report());
  const test::Sizes sizes = test::sizes(t);
  for (std::size_t k = 0; k < t.rows(); ++k) {
    test::expect_same_row(all.row(i, k), t, k, sizes, conditions[k], residual);
    if (testing::Test::HasFailure()) return;
  }
  for (std::size_t k = t.rows(); k < all.times().size(); ++k) EXPECT_TRUE(std::isnan(all(i, k, 0)));
  ASSERT_EQ(outcome.events.size(), lone.report().events.size());
  for (std::size_t n = 0; n < outcome.events.size(); ++n) {
    const Event &mine = outcome.events[n], &theirs = lone.report().events[n];
    EXPECT_EQ(mine.kind, theirs.kind);
    EXPECT_EQ(mine.group, theirs.group);
    EXPECT_LE(mine.time, theirs.until);  // brackets of the same thing
    EXPECT_GE(mine.until, theirs.time);
  }
  EXPECT_LE(outcome.reached, lone.report().reached + scene.time().step);
  EXPECT_GE(outcome.reached, t.times().back());
}

std::string file(const std::string& name) { return std::string(ASSUR_SOURCE_DIR) + "/scenes/" + name + ".json"; }

double share(std::size_t i, std::size_t of) { return static_cast<double>(i) / static_cast<double>(of); }

Scene slider_crank(std::size_t i) {
  return read_scene(file("slider_crank"), {{"crank_length", 0.05 + 0.1 * share(i, 11)},
                                           {"offset", 0.1 * share(i, 11) - 0.05},
                                           {"step", 0.02},
                                           {"steps", 60}});
}
Scene four_bar(std::size_t i) {
  return read_scene(file("four_bar"), {{"crank_length", 0.5 + 0.3 * share(i, 11)},
                                       {"rocker_length", 1.3 + 0.1 * share(i * 5 % 11, 11)},
                                       {"step", 0.02},
                                       {"steps", 60}});
}
Scene stewart(std::size_t i) { return sample("stewart", {{"omega", 0.5 + share(i, 11)}, {"steps", 30}}); }
Scene chain(std::size_t i) {
  return sample("four_bar:3", {{"omega", 1 + 0.2 * static_cast<double>(i)}, {"steps", 60}});
}

TEST(Ensemble, MembersAreWhatASimulatorOfEachGives) {
  for (const int lanes : {1, 2, 4, 8, 16}) {
    for (const std::string backend : {"eigen", "lanes"}) {
      const std::string strategy = "groups/" + backend + ":" + std::to_string(lanes);
      for (const SceneOf& scene : {SceneOf(slider_crank), SceneOf(four_bar), SceneOf(chain)}) {
        Ensemble e = ensemble(11, scene, strategy);
        const EnsembleTrajectory all = e.run();
        ASSERT_EQ(e.report().status.code, Code::ok) << scene(0).name() << " " << strategy;
        for (const std::size_t i : {0u, 4u, 10u}) expect_member(e, all, i, scene(i), strategy);
        EXPECT_EQ(e.report().counters.steps, 11 * 60);
        EXPECT_TRUE(e.report().fallbacks.empty()) << e.report().fallbacks[0];
      }
    }
  }
}

TEST(Ensemble, OfStewartPlatforms) {
  const std::string sparse = "groups/" + test::sparse() + ":4+once+predict=hermite:5";
  for (const std::string& strategy : {std::string("irreducible/lanes:8"), sparse,
                                      std::string("global/eigen:2+reuse=run"), std::string("groups/eigen:16+float")}) {
    Ensemble e = ensemble(11, stewart, strategy);
    const EnsembleTrajectory all = e.run();
    ASSERT_EQ(e.report().status.code, Code::ok) << strategy;
    for (const std::size_t i : {0u, 8u, 10u}) expect_member(e, all, i, stewart(i), strategy, 10);
  }
}

void expect_same_bits(const EnsembleTrajectory& a, const EnsembleTrajectory& b) {
  ASSERT_EQ(a.values().size(), b.values().size());
  for (std::size_t i = 0; i < a.values().size(); ++i) {
    const double x = a.values()[i], y = b.values()[i];
    ASSERT_TRUE(x == y || (std::isnan(x) && std::isnan(y))) << i;
  }
}

// Idle lanes in the last tile repeat its first lane.
TEST(Ensemble, IdenticalMembersAreIdenticalBitForBit) {
  for (const std::string strategy : {"groups/eigen:1", "groups/eigen:4", "irreducible/lanes:8", "global/lanes:16"}) {
    const EnsembleTrajectory all = ensemble(
                                       11, [](std::size_t) { return four_bar(3); }, strategy)
                                       .run();
    const std::size_t size = all.values().size() / 11;
    for (std::size_t i = 1; i < 11; ++i) {
      ASSERT_EQ(all.rows(i), 61u);
      for (std::size_t k = 0; k < size; ++k) ASSERT_EQ(all.values()[i * size + k], all.values()[k]) << strategy;
    }
  }
}

// Of 11 members the last ones meet their limits on the way; member 3 has a coupler that does not reach the rocker.
Scene partly_limited(std::size_t i) {
  const Law law = Law::polynomial({0.5, 0.4 + 0.05 * static_cast<double>(i)});
  if (i != 3) return test::limited_four_bar(law).time(0, 1.5, 0.01).build();
  SceneBuilder b("impossible", 2);
  b.fixed_point("A0", {0, 0, 0}).fixed_point("A1", {2, 0, 0});
  b.point("B", {std::cos(0.5), std::sin(0.5), 0}).point("C", {1.7, 1.1, 0});
  b.constrain("crank", Distance{"A0", "B", 1.0}).constrain("coupler", Distance{"B", "C", 0.01});
  b.constrain("rocker", Distance{"A1", "C", 1.2}).drive("motor", PointAngle{"A0", "B", "", law});
  return b.time(0, 1.5, 0.01).build();
}

TEST(Ensemble, ThreadsChangeNoBit) {
  for (const SceneOf& scene : {SceneOf(four_bar), SceneOf(partly_limited)}) {
    for (const std::string solver : {"groups/eigen:4", "groups/lanes:2", "irreducible/lanes:8+once"}) {
      Ensemble one = ensemble(11, scene, solver);
      const EnsembleTrajectory all = one.run();
      for (const std::string split : {" 2x1", " 3x1"}) {
        SCOPED_TRACE(solver + split);
        Ensemble more = ensemble(11, scene, solver + split);
        expect_same_bits(all, more.run());
        expect_same_bits(all, more.run());  // once more, with workspaces that were used
        for (std::size_t i = 0; i < 11; ++i) {
          EXPECT_EQ(one.outcomes()[i].status.code, more.outcomes()[i].status.code);
          EXPECT_EQ(one.outcomes()[i].reached, more.outcomes()[i].reached);
        }
        EXPECT_EQ(one.report().counters.newton_iterations, more.report().counters.newton_iterations);
        EXPECT_EQ(one.report().counters.steps, more.report().counters.steps);
        EXPECT_EQ(one.report().fallbacks, more.report().fallbacks);
      }
    }
  }
}

TEST(Ensemble, AMemberAtItsLimitDoesNotHoldUpTheOthers) {
  for (const std::string strategy :
       {"groups/eigen:4", "irreducible/lanes:8", "global/eigen:16", "groups/eigen:2 2x1"}) {
    Ensemble e = ensemble(11, partly_limited, strategy);
    const EnsembleTrajectory all = e.run();
    int limited = 0;
    for (std::size_t i = 0; i < 11; ++i) {
      if (i == 3) continue;
      limited += e.outcomes()[i].status.code == Code::limit_reached ? 1 : 0;
      expect_member(e, all, i, partly_limited(i), strategy);
      EXPECT_EQ(e.outcomes()[i].alone, !e.outcomes()[i].status.ok()) << strategy << " " << i;
    }
    EXPECT_EQ(limited, 5);
    const Ensemble::Outcome& cannot = e.outcomes()[3];
    EXPECT_NE(cannot.cannot.find("coupler"), std::string::npos) << cannot.cannot;
    EXPECT_FALSE(cannot.status.ok());
    EXPECT_EQ(all.rows(3), 0u);
    EXPECT_TRUE(std::isnan(all(3, 0, 0)));
    EXPECT_EQ(e.report().status.code, Code::not_converged);  // of the first member that is not ok
    EXPECT_EQ(e.report().status.where, 3);
  }
}

TEST(Ensemble, TheFirstMemberMayBeTheOneThatCannot) {
  Ensemble e = ensemble(
      5, [](std::size_t i) { return partly_limited(i + 3); }, "groups/eigen:2");
  const EnsembleTrajectory all = e.run();
  EXPECT_NE(e.outcomes()[0].cannot, "");
  for (std::size_t i = 1; i < 5; ++i) expect_member(e, all, i, partly_limited(i + 3), "groups/eigen:2");
}

// A parallelogram passes its change point at t = 0.25; its neighbours have none.
TEST(Ensemble, AMemberPassesAChangePoint) {
  const SceneOf scene = [](std::size_t i) {
    return sample("almost_parallelogram",
                  {{"delta", i == 2 ? 0 : 0.1 * static_cast<double>(i + 1)}, {"step", 0.0071}, {"steps", 100}});
  };
  Ensemble e = ensemble(4, scene);
  const EnsembleTrajectory all = e.run();
  for (std::size_t i = 0; i < 4; ++i) expect_member(e, all, i, scene(i), "groups/eigen:4");
  EXPECT_TRUE(e.outcomes()[2].alone);
  EXPECT_GT(e.outcomes()[2].alone_from, 0.2);
  EXPECT_EQ(e.outcomes()[2].events.size(), 1u);
}

// ---- members that are different

Scene with_law(Law law, double end = 1) {
  SceneBuilder b("driven", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("D", {2, 0, 0});
  b.point("B", {0.8, 0, 0}).point("C", {1.6, 1.2, 0});
  b.constrain("crank", Distance{"A", "B", 0.8}).constrain("coupler", Distance{"B", "C", 1.8});
  b.constrain("rocker", Distance{"D", "C", 1.3});
  b.drive("motor", PointAngle{"A", "B", "", std::move(law)});
  b.measure("crank_angle", AbsoluteAngle{"A", "B"}).measure("rocker_angle", AbsoluteAngle{"D", "C"});
  return b.time(0, end, 0.01).build();
}

Law turning(double rate) {
  return Law::function([=](double t) -> Motion { return {rate * t, rate, 0}; });
}

// Polynomials, waves, tables (one of which ends), functions, and the same law twice.
TEST(Ensemble, MembersWithOtherLaws) {
  const std::vector<double> times = test::grid_of(with_law({}));
  const SceneOf scene = [](std::size_t i) {
    const std::vector<double> knots = {0, 0.2, 0.4, 0.7, 1}, angles = {0, 0.3, 1, 2, 2.5};
    switch (i) {
      case 0:
        return with_law(Law::polynomial({0, 3}));
      case 1:
        return with_law(Law::harmonics({{0.5, 2, 0.3}}, 0.2));
      case 2:
        return with_law(Law::table(knots, angles));
      case 3:
        return with_law(Law::table({0, 0.2, 0.4, 0.535}, {0, 0.3, 1, 2}), 0.5);
      case 4:
        return with_law(turning(5));
      default:
        return with_law(Law::polynomial({0, 3}) + Law::harmonics({{0.1, 3, 0}}));
    }
  };
  for (const std::string strategy : {"groups/eigen:8", "groups/lanes:4", "groups/eigen:2 3x1"}) {
    Ensemble e = ensemble(7, scene, strategy);
    const EnsembleTrajectory all = e.run(times);
    for (std::size_t i = 0; i < 7; ++i) expect_member(e, all, i, scene(i), strategy);
    EXPECT_EQ(e.outcomes()[3].status.code, Code::out_of_range);
    EXPECT_EQ(all.rows(3), 54u);
  }
}

// A crank that turns on, next to one whose table ends in the third turn: whoever starts anew counts the turns on.
TEST(Ensemble, AnglesAreUnwrappedOverManyTurns) {
  const auto ending = [] {
    std::vector<double> t, a;
    for (int k = 0; k <= 20; ++k) {
      t.push_back(0.123 * k);
      a.push_back(0.123 * k * 7);
    }
    return Law::table(t, a);
  };
  const SceneOf scene = [&](std::size_t i) {
    return with_law(i == 1 ? ending() : Law::polynomial({0, 6.5 + 0.5 * static_cast<double>(i)}), 2);
  };
  Ensemble e = ensemble(3, scene);
  const EnsembleTrajectory all = e.run(test::grid_of(with_law({}, 8)));
  EXPECT_EQ(e.outcomes()[1].status.code, Code::out_of_range);
  EXPECT_LT(all.rows(1), 250u);
  const auto column = static_cast<std::size_t>(std::find(all.columns().begin(), all.columns().end(), "crank_angle") -
                                               all.columns().begin());
  for (const std::size_t i : {0u, 2u}) {
    const double rate = 6.5 + 0.5 * static_cast<double>(i);
    ASSERT_EQ(all.rows(i), 801u);
    for (std::size_t k = 0; k < 801; ++k) {
      // A few roundings of a number of up to 60.
      ASSERT_NEAR(all(i, k, column), rate * all.times()[k], 8 * 64 * kEps) << i << " " << k;
    }
  }
  expect_member(e, all, 1, scene(1), "groups/eigen:4");
}

// The coupler's end runs on a rail instead of hanging on a rocker.
Scene on_a_rail() {
  SceneBuilder b("rail", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("D", {2, 0, 0}).fixed_vector("rail", {1, 0, 0});
  b.point("B", {0.8, 0, 0}).point("C", {2.6, 0, 0});
  b.constrain("crank", Distance{"A", "B", 0.8}).constrain("coupler", Distance{"B", "C", 1.8});
  b.constrain("slide", OnLine{"C", "D", "rail"});
  b.drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, 3})});
  return b.time(0, 1, 0.01).build().with_outputs({"B", "C"});
}

TEST(Ensemble, AMemberOfAnotherStructureRunsAlone) {
  const SceneOf scene = [](std::size_t i) {
    return i == 1 || i == 3 ? on_a_rail() : with_law(Law::polynomial({0, 3})).with_outputs({"B", "C"});
  };
  for (const std::string strategy : {"groups/eigen:4", "irreducible/eigen:2 2x1"}) {
    Ensemble e = ensemble(5, scene, strategy);
    std::int64_t heard = 0;
    const EnsembleTrajectory all = e.run([&](std::int64_t done, std::int64_t of) {
      EXPECT_EQ(of, 5 * 101);
      EXPECT_GE(done, heard);
      heard = done;
      return true;
    });
    EXPECT_EQ(heard, 5 * 101);
    for (std::size_t i = 0; i < 5; ++i) {
      expect_member(e, all, i, scene(i), strategy);
      EXPECT_EQ(e.outcomes()[i].alone, i == 1 || i == 3);
    }
    ASSERT_EQ(e.report().fallbacks.size(), 1u);
    EXPECT_EQ(e.report().fallbacks[0].rfind("2 of 5 members went on alone", 0), 0u);
    EXPECT_EQ(e.report().counters.steps, 500);
    EXPECT_EQ(e.report().counters.stored_values, static_cast<std::int64_t>(5 * 101 * all.columns().size()));
  }
}

// Same equations, but more columns: they would not fit into the rows.
TEST(Ensemble, AMemberWithOtherOutputsCannotTakePart) {
  const SceneOf scene = [](std::size_t i) {
    const Scene all = with_law(Law::polynomial({0, 3}));
    return i == 1 ? all : i == 2 ? all.with_outputs({"C", "B"}) : all.with_outputs({"B", "C"});
  };
  Ensemble e = ensemble(4, scene);
  const EnsembleTrajectory all = e.run();
  for (const std::size_t i : {1u, 2u}) {
    EXPECT_NE(e.outcomes()[i].cannot.find("outputs"), std::string::npos);
    EXPECT_EQ(all.rows(i), 0u);
    for (std::size_t k = 0; k < 101; ++k) EXPECT_TRUE(std::isnan(all(i, k, 0)));
  }
  for (const std::size_t i : {0u, 3u}) expect_member(e, all, i, scene(i), "groups/eigen:4");
}

// A driven distance in one, a driven coordinate in the other: the same unknowns, another kind of input.
TEST(Ensemble, AnActuatorThatVanishesIsItsMembersOutcome) {
  const SceneOf scene = [](std::size_t i) {
    SceneBuilder b("jack", 2);
    b.fixed_point("A", {0, 0, 0}).fixed_point("D", {1, 0, 0}).point("P", {0.5, 0.6, 0});
    b.constrain("rod", Distance{"D", "P", 1.0});
    const double speed = i == 2 ? 1.0 : 0.1 * static_cast<double>(i);
    b.drive("jack", DrivenDistance{"A", "P", Law::polynomial({0.7, -speed})});
    return b.time(0, 0.9, 0.01).build();
  };
  Ensemble e = ensemble(4, scene);
  const EnsembleTrajectory all = e.run();
  for (const std::size_t i : {0u, 1u, 3u}) expect_member(e, all, i, scene(i), "groups/eigen:4");
  EXPECT_EQ(e.outcomes()[2].status.code, test::run(scene(2), "groups/eigen").report().status.code);
  EXPECT_FALSE(e.outcomes()[2].status.ok());
}

// A crank that begins at its dead centre has no velocities there.
TEST(Ensemble, AMemberThatStartsAtASingularityCannotBeStarted) {
  const SceneOf scene = [](std::size_t i) {
    SceneBuilder b("stretched", 2);
    b.fixed_point("A", {0, 0, 0}).fixed_point("D", {3, 0, 0}).point("C", {1, i == 1 ? 0 : 0.5, 0});
    b.constrain("left", Distance{"A", "C", i == 1 ? std::optional(1.0) : std::nullopt});
    b.drive("right", DrivenDistance{"D", "C", Law::polynomial({i == 1 ? 2 : std::hypot(2, 0.5), 0.01})});
    return b.time(0, 0.1, 0.01).build();
  };
  EXPECT_THROW((void)test::simulator(scene(1), "groups/eigen"), Error);
  for (const std::string strategy : {"groups/eigen:4", "groups/eigen:1"}) {
    Ensemble e = ensemble(3, scene, strategy);
    const EnsembleTrajectory all = e.run();
    EXPECT_EQ(e.outcomes()[1].status.code, Code::singular);
    EXPECT_NE(e.outcomes()[1].cannot.find("singular"), std::string::npos) << e.outcomes()[1].cannot;
    EXPECT_EQ(all.rows(1), 0u);
    for (const std::size_t i : {0u, 2u}) expect_member(e, all, i, scene(i), strategy);
  }
}

// ---- redundant equations, callbacks

// Three parallel rods on a coupler; one is redundant and watched.
Scene three_rods(std::size_t i) {
  const double start = 0.5 + 0.1 * static_cast<double>(i), spread = 0.4 + 0.02 * static_cast<double>(i);
  const Triple crank = {std::cos(start), std::sin(start), 0};
  SceneBuilder b("three_rods", 2);
  b.fixed_point("A0", {0, 0, 0}).fixed_point("A1", {2, 0, 0}).fixed_point("A2", {spread, 0, 0});
  b.point("B0", crank).point("B1", {crank[0] + 2, crank[1], 0});
  b.add(Body{"coupler", "", {}, {"B0", "B1"}, {{"M", {spread, 0, 0}}}, {}});
  b.constrain("coupler_length", Distance{"B0", "B1", 2.0}).constrain("rocker", Distance{"A1", "B1", 1.0});
  b.constrain("third", Distance{"A2", "M", 1.0});
  b.drive("motor", PointAngle{"A0", "B0", "", Law::polynomial({start, 1})});
  return b.time(0, 1, 0.01).build();
}

// Redundant at the start and to first order; the third rod hangs on a point that leaves the circle, sooner or later.
Scene leaving(std::size_t i) {
  SceneBuilder b("leaving", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("C", {1, 0, 0}).point("S", {0.5, 0, 0});
  b.point("B", {1, 1, 0}).constrain("height", FixedCoordinate{"B.y", 1});
  b.constrain("rod", Distance{"S", "B", std::hypot(0.5, 1)}).constrain("stop", Distance{"C", "B", 1.0});
  b.drive("slide", DrivenCoordinate{"S.x", Law::polynomial({0.5, 0, 0, 0, i == 2 ? 1e-3 : 0})});
  b.drive("lift", DrivenCoordinate{"S.y", Law::constant(0)});
  return b.time(0, 1, 0.1).build();
}

TEST(Ensemble, RedundantEquationsAreWatched) {
  for (const std::string strategy : {"groups/eigen:4", "global/eigen:2"}) {
    Ensemble e = ensemble(5, three_rods, strategy);
    const EnsembleTrajectory all = e.run();
    EXPECT_EQ(e.report().status.code, Code::ok);
    for (std::size_t i = 0; i < 5; ++i) {
      expect_member(e, all, i, three_rods(i), strategy);
      // Which of the rods is watched depends on the start posture: members with another one run alone.
      const auto watched = [](std::size_t m) { return prepare(three_rods(m), {"groups/eigen", {}}).structure->checks; };
      EXPECT_EQ(e.outcomes()[i].alone, watched(i) != watched(0));
    }
    Ensemble apart = ensemble(4, leaving, strategy);
    const EnsembleTrajectory rows = apart.run();
    EXPECT_EQ(apart.outcomes()[2].status.code, Code::inconsistent);
    EXPECT_EQ(rows.rows(2), test::run(leaving(2), "groups/eigen").trajectory.rows());
    for (const std::size_t i : {0u, 1u, 3u}) EXPECT_EQ(rows.rows(i), 11u);
  }
}

Scene with_callback(double rocker, Callback callback) {
  SceneBuilder b("called", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("D", {2, 0, 0});
  b.point("B", {0.8, 0, 0}).point("C", {1.6, rocker - 0.1, 0});
  b.constrain("crank", Distance{"A", "B", 0.8}).constrain("coupler", Distance{"B", "C", 1.8});
  b.constrain("rocker", std::move(callback)).drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, 3})});
  return b.time(0, 1, 0.01).build();
}

// The lengths are in the functions, where nobody can compare them: each member has to ask its own.
TEST(Ensemble, CallbacksAreThoseOfTheMember) {
  const SceneOf scene = [](std::size_t i) {
    const double rocker = 1.2 + 0.05 * static_cast<double>(i);
    return with_callback(rocker, test::distance_by_callback("D", "C", rocker));
  };
  Ensemble e = ensemble(3, scene);
  const EnsembleTrajectory all = e.run();
  for (std::size_t i = 0; i < 3; ++i) expect_member(e, all, i, scene(i), "groups/eigen:4");

  const Prepared one = prepare(scene(0), {"groups/eigen:4", {}});
  Ensemble copies(3, [&](std::size_t) { return one; });
  const EnsembleTrajectory same = copies.run();
  for (std::size_t i = 0; i < 3; ++i) {
    expect_member(copies, same, i, scene(0), "groups/eigen:4");
    EXPECT_FALSE(copies.outcomes()[i].alone);
  }
}

// ---- what is thrown, refused, stopped

struct Broken : std::runtime_error {
  Broken() : std::runtime_error("broken") {}
};

// The law of member 5; over even steps, and where a long one sends everybody on alone.
TEST(Ensemble, WhatALawThrowsReachesTheCaller) {
  const std::vector<double> even = {0, 0.1, 0.2, 0.3, 0.4, 0.5}, uneven = {0, 0.01, 0.25, 0.26, 0.4, 0.5};
  for (const std::string strategy : {"groups/eigen:1", "groups/eigen:4", "groups/eigen:2 3x1"}) {
    for (const bool an_error : {false, true}) {
      const SceneOf scene = [=](std::size_t i) {
        if (i != 5) return with_law(Law::polynomial({0, 9}));
        return with_law(Law::function([=](double t) -> Motion {
          if (t > 0.3 && an_error) throw Error(Error::Kind::input, "no sensor");
          if (t > 0.3) throw Broken();
          return {9 * t, 9, 0};
        }));
      };
      for (const auto& times : {even, uneven}) {
        Ensemble e = ensemble(9, scene, strategy);
        if (an_error) {
          EXPECT_THROW((void)e.run(times), Error) << strategy;
        } else {
          EXPECT_THROW((void)e.run(times), Broken) << strategy;
        }
      }
    }
  }
  Ensemble alone = ensemble(5, [](std::size_t) { return with_law(turning(9)); });
  EXPECT_TRUE(alone.run(uneven).rows(4) == 6 && alone.outcomes()[4].alone);
}

// A member of its own, too, and a lane that goes on alone.
TEST(Ensemble, WhatACallbackThrowsReachesTheCaller) {
  auto armed = std::make_shared<std::atomic<bool>>(false);
  const SceneOf scene = [=](std::size_t) {
    Callback c = test::distance_by_callback("D", "C", 1.3);
    c.residual = [armed, f = c.residual](std::span<const double> x, std::span<double> phi) {
      if (*armed && x[2] > 1.62) throw Broken();
      f(x, phi);
    };
    return with_callback(1.3, c);
  };
  for (const bool copies : {false, true}) {
    *armed = false;
    const Prepared one = prepare(scene(0), {"groups/eigen:2 2x1", {}, ThreadBudget{2}});
    Ensemble e(5, [&](std::size_t i) { return copies ? one : prepare(scene(i), {"groups/eigen:2", {}}); });
    EXPECT_TRUE(e.run().rows(4) == 101);
    *armed = true;
    EXPECT_THROW((void)e.run(), Broken);
    *armed = false;
    EXPECT_TRUE(e.run().rows(4) == 101);  // and it can be run again
  }
}

std::string refusal(const std::function<void()>& what) {
  try {
    what();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), Error::Kind::input);
    return e.what();
  }
  return "";
}

TEST(Ensemble, WhatMakesNoSenseIsRefused) {
  EXPECT_EQ(refusal([] { (void)ensemble(0, four_bar); }), "an ensemble needs at least one member");
  EXPECT_NE(refusal([] { (void)Ensemble(1, prepared(four_bar, "groups/eigen"), {0, 0, 0}); }), "");
  EXPECT_NE(refusal([] {
              (void)Ensemble(1, prepared(four_bar, "groups/eigen"), {0, 12, 1});
            }).find("deadline"),
            std::string::npos);
  Ensemble e = ensemble(2, four_bar);
  EXPECT_NE(refusal([&] { (void)e.run(std::vector<double>{}); }), "");
  EXPECT_NE(refusal([&] { (void)e.run(std::vector<double>{0.1, 0.2}); }), "");
  EXPECT_NE(refusal([&] { (void)e.run(std::vector<double>{0, 0.2, 0.1}); }).find("ascend"), std::string::npos);
  EXPECT_NE(refusal([&] { (void)e.run(std::vector<double>{0, NAN}); }).find("finite"), std::string::npos);
  // If no member can be prepared, the first one's reason is told.
  EXPECT_THROW((void)ensemble(3, [](std::size_t) { return partly_limited(3); }), Error);
  EXPECT_THROW((void)ensemble(3, [](std::size_t) -> Scene { throw Broken(); }), Broken);
  EXPECT_THROW((void)ensemble(3, four_bar, "groups/nobody"), Error);
}

TEST(Ensemble, OwnTimesOfAnyLengthAndTwiceTheSame) {
  Ensemble e = ensemble(5, four_bar);
  const std::vector<double> times = {0, 0.01, 0.01, 0.03, 0.04, 0.04, 0.06};
  const EnsembleTrajectory all = e.run(times);
  for (std::size_t i = 0; i < 5; ++i) {
    expect_member(e, all, i, four_bar(i), "groups/eigen:4");
    EXPECT_FALSE(e.outcomes()[i].alone);
  }
  const std::vector<double> start = {0};
  EXPECT_EQ(e.run(start).rows(4), 1u);
  EXPECT_EQ(e.report().status.code, Code::ok);
}

TEST(Ensemble, OneMemberAndFewerThanLanes) {
  for (const std::size_t members : {1u, 2u, 3u, 5u, 9u}) {
    Ensemble e = ensemble(members, four_bar, "groups/lanes:8 2x1");
    const EnsembleTrajectory all = e.run();
    EXPECT_EQ(all.members(), members);
    for (std::size_t i = 0; i < members; ++i) expect_member(e, all, i, four_bar(i), "groups/lanes:8 2x1");
    EXPECT_EQ(e.report().counters.steps, static_cast<std::int64_t>(60 * members));
  }
}

// The paper's tEnd2: one correction each, converged or not.
TEST(Ensemble, AFixedNumberOfIterationsIsThatOfASimulator) {
  const SceneOf scene = [](std::size_t i) {
    return sample("four_bar:2", {{"omega", 1.0 + share(i, 5)}, {"steps", 40}});
  };
  for (const std::string strategy : {"groups/eigen:1+predict=taylor:1", "groups/lanes:4+predict=taylor:1"}) {
    Ensemble e(5, prepared(scene, strategy), {1});
    const EnsembleTrajectory all = e.run();
    for (std::size_t i = 0; i < 5; ++i) {
      Simulator lone(prepare(scene(i), {strategy, {}}), {1});
      const Trajectory t = lone.run();
      ASSERT_EQ(all.rows(i), t.rows());
      EXPECT_GT(lone.report().error.position, 8 * kEps);  // it matters that it is one
      const std::vector<double> conditions = test::conditions(scene(i), t.times());
      for (std::size_t k = 0; k < t.rows(); ++k) {
        test::expect_same_row(all.row(i, k), t, k, test::sizes(t), conditions[k], 8 * kEps);
      }
    }
  }
}

TEST(Ensemble, ThreadsArePinnedAsAsked) {
  const std::vector<std::int32_t> cores = this_machine().cores;
  if (cores.size() < 2) GTEST_SKIP() << "one core";
  StepLimits pinned;
  pinned.pin_to = {cores[0], cores[1]};
  expect_same_bits(Ensemble(11, prepared(four_bar, "groups/eigen:2 2x1"), pinned).run(),
                   ensemble(11, four_bar, "groups/eigen:2 2x1").run());
  pinned.pin_to.pop_back();
  EXPECT_NE(refusal([&] { (void)Ensemble(11, prepared(four_bar, "groups/eigen:2 2x1"), pinned); }).find("pinned"),
            std::string::npos);
}

// Twice as many steps take not one allocation more. With several threads it depends on who takes which tile.
TEST(Ensemble, StepsTakeNoMemory) {
  for (const std::string strategy : {"groups/eigen:4", "irreducible/lanes:8+once", "groups/lanes:2"}) {
    Ensemble e = ensemble(16, chain, strategy);
    const std::vector<double> grid = test::grid_of(chain(0));
    const auto taken = [&](std::size_t rows) {
      const std::int64_t before = test::allocations();
      (void)e.run(std::span(grid).first(rows));
      return test::allocations() - before;
    };
    (void)taken(61);
    EXPECT_EQ(taken(61), taken(31)) << strategy;
  }
}

TEST(Ensemble, AnObserverHearsOfEveryRowAndStops) {
  for (const std::string strategy : {"groups/eigen:2", "groups/eigen:4 2x1"}) {
    SCOPED_TRACE(strategy);
    Ensemble e = ensemble(7, four_bar, strategy);
    const EnsembleTrajectory all = e.run();
    std::int64_t heard = 0;
    (void)e.run([&](std::int64_t done, std::int64_t of) {
      EXPECT_EQ(of, 7 * 61);
      EXPECT_GT(done, heard);
      heard = done;
      return true;
    });
    EXPECT_EQ(heard, 7 * 61);

    const EnsembleTrajectory some = e.run([](std::int64_t done, std::int64_t) { return done < 100; });
    EXPECT_EQ(e.report().status.code, Code::interrupted);
    std::size_t rows = 0;
    for (std::size_t i = 0; i < 7; ++i) {
      const Ensemble::Outcome& o = e.outcomes()[i];
      EXPECT_EQ(o.status.code, some.rows(i) < 61 ? Code::interrupted : Code::ok) << i;
      for (std::size_t k = 0; k < some.rows(i); ++k) {
        for (std::size_t c = 0; c < all.columns().size(); ++c) ASSERT_EQ(some(i, k, c), all(i, k, c));
      }
      for (std::size_t k = some.rows(i); k < 61; ++k) EXPECT_TRUE(std::isnan(some(i, k, 0)));
      rows += some.rows(i);
    }
    EXPECT_GE(rows, 100u);
    EXPECT_LT(rows, 7u * 61);
    // One thread stops at once, the other one after the step that it is at.
    EXPECT_LE(rows, strategy == "groups/eigen:2" ? 101u : 7u * 61 - 1);
  }
}

TEST(Ensemble, AnObserverStopsMembersOfAnotherStructure) {
  const SceneOf scene = [](std::size_t i) {
    return i > 0 ? on_a_rail() : with_law(Law::polynomial({0, 3})).with_outputs({"B", "C"});
  };
  Ensemble e = ensemble(3, scene);
  const EnsembleTrajectory all = e.run([](std::int64_t done, std::int64_t) { return done < 150; });
  EXPECT_EQ(all.rows(0), 101u);
  EXPECT_EQ(all.rows(1), 49u);
  EXPECT_EQ(all.rows(2), 0u);
  EXPECT_TRUE(e.outcomes()[0].status.ok());
  EXPECT_EQ(e.outcomes()[1].status.code, Code::interrupted);
  EXPECT_EQ(e.outcomes()[2].status.code, Code::interrupted);
}

TEST(Ensemble, CsvHasTheRowsThatAreThere) {
  Ensemble e = ensemble(3, [](std::size_t i) { return i == 1 ? partly_limited(3) : partly_limited(10); });
  const EnsembleTrajectory all = e.run();
  std::ostringstream out;
  write_csv(out, all);
  const std::string text = out.str();
  EXPECT_EQ(text.rfind("member,t,", 0), 0u);
  EXPECT_EQ(static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')), 1 + all.rows(0) + all.rows(2));
  EXPECT_EQ(text.find("nan"), std::string::npos);
  EXPECT_EQ(text.find("\n2,"), std::string::npos);
}

}  // namespace
}  // namespace assur
