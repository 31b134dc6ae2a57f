// Members of an ensemble equal single simulators, independently of their neighbours in the lanes.
#include <gtest/gtest.h>

#include <functional>

#include "plan/preparation.hpp"
#include "runs/ensembles.hpp"
#include "runs/tile.hpp"

namespace assur::test {
namespace {

TEST(Ensemble, MembersEqualSingleSimulators) {
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

TEST(Ensemble, RunsStewartPlatforms) {
  const std::string sparse = "groups/" + test::sparse() + ":4+once+predict=hermite:5";
  for (const std::string& strategy : {std::string("irreducible/lanes:8"), sparse,
                                      std::string("global/eigen:2+reuse=run"), std::string("groups/eigen:16+float")}) {
    Ensemble e = ensemble(11, stewart, strategy);
    const EnsembleTrajectory all = e.run();
    ASSERT_EQ(e.report().status.code, Code::ok) << strategy;
    for (const std::size_t i : {0u, 8u, 10u}) expect_member(e, all, i, stewart(i), strategy, 10);
  }
}

// Idle lanes in the last tile repeat its first lane.
TEST(Ensemble, IdenticalMembersAreBitwiseEqual) {
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

TEST(Ensemble, ResultsAreBitwiseEqualForAllThreads) {
  for (const SceneOf& scene : {SceneOf(four_bar), SceneOf(partly_limited)}) {
    for (const std::string solver : {"groups/eigen:4", "groups/lanes:2", "irreducible/lanes:8+once"}) {
      Ensemble one = ensemble(11, scene, solver);
      const EnsembleTrajectory all = one.run();
      for (const std::string split : {" 2x1", " 3x1"}) {
        SCOPED_TRACE(solver + split);
        Ensemble more = ensemble(11, scene, solver + split);
        expect_same_bits(all, more.run());
        expect_same_bits(all, more.run());  // a second run, with used workspaces
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

TEST(Ensemble, AMemberAtItsLimitDoesNotStopTheOthers) {
  for (const std::string strategy :
       {"groups/eigen:4", "irreducible/lanes:8", "global/eigen:16", "groups/eigen:2 2x1"}) {
    Ensemble e = ensemble(11, partly_limited, strategy);
    const EnsembleTrajectory all = e.run();
    int limited = 0;
    for (std::size_t i = 0; i < 11; ++i) {
      if (i == 3) continue;
      limited += e.outcomes()[i].status.code == Code::fold ? 1 : 0;
      expect_member(e, all, i, partly_limited(i), strategy);
      EXPECT_EQ(e.outcomes()[i].alone, !e.outcomes()[i].status.ok()) << strategy << " " << i;
    }
    EXPECT_EQ(limited, 5);
    const Ensemble::Outcome& cannot = e.outcomes()[3];
    EXPECT_NE(cannot.cannot.find("coupler"), std::string::npos) << cannot.cannot;
    EXPECT_FALSE(cannot.status.ok());
    EXPECT_EQ(all.rows(3), 0u);
    EXPECT_TRUE(std::isnan(all(3, 0, 0)));
    EXPECT_EQ(e.report().status.code, Code::not_assembled);  // the status of the first member that is not ok
    EXPECT_EQ(e.report().status.where, Place::member(3));
  }
}

// So the others need not try the step alone.
TEST(Ensemble, ATileNamesTheLaneThatCannotFollow) {
  for (const std::string strategy : {"groups/eigen:4", "irreducible/lanes:4", "groups/eigen:4+reuse=run"}) {
    for (std::size_t limited = 0; limited < 4; ++limited) {
      const SceneOf scene = [&](std::size_t i) { return partly_limited(i == limited ? 10 : 0); };
      const Prepared first = prepared(scene, strategy)(0);
      std::vector<Variant> lanes;
      for (std::size_t i = 0; i < 4; ++i) {
        const Prepared of = prepared(scene, strategy)(i);
        const Preparation& p = preparation(of);
        lanes.push_back({p.structure->system, p.structure->start, p.time.start, {}});
      }
      Tile tile(preparation(first), {});
      const Variant* const variants[] = {&lanes[0], &lanes[1], &lanes[2], &lanes[3]};
      Status status = tile.start(variants);
      for (std::int64_t k = 1; k <= first.time().steps() && status.ok(); ++k) {
        const double t = first.time().time(k);
        status = tile.step(std::vector<double>{t, t, t, t});
      }
      EXPECT_FALSE(status.ok());
      EXPECT_EQ(status.where, Place::lane(static_cast<std::int32_t>(limited))) << strategy << " " << name(status.code);
    }
  }
}

TEST(Ensemble, TheFirstMemberMayFail) {
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

// ---- different members

// The laws are polynomials, waves, tables (one of which ends), functions, and the same law twice.
TEST(Ensemble, MembersMayHaveOtherLaws) {
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

// One crank keeps turning; the table of its neighbour ends in the third turn. A restarted member continues its count of
// turns.
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
      // A few roundings of numbers up to 60.
      ASSERT_NEAR(all(i, k, column), rate * all.times()[k], 8 * 64 * kEps) << i << " " << k;
    }
  }
  expect_member(e, all, 1, scene(1), "groups/eigen:4");
}

// In three members the end of the coupler runs on a rail instead of a rocker; in one it has no joint at all.
TEST(Ensemble, MembersOfAnotherStructureShareLanes) {
  const SceneOf scene = [](std::size_t i) {
    if (i == 4) return in_translation();
    return i % 2 == 1 ? on_a_rail() : with_law(Law::polynomial({0, 3})).with_outputs({"B", "C"});
  };
  for (const std::string strategy : {"groups/eigen:4", "groups/eigen:2", "irreducible/eigen:2 2x1"}) {
    Ensemble e = ensemble(6, scene, strategy);
    std::int64_t heard = 0;
    const EnsembleTrajectory all = e.run([&](std::int64_t done, std::int64_t of) {
      EXPECT_EQ(of, 6 * 101);
      EXPECT_GE(done, heard);
      heard = done;
      return false;
    });
    EXPECT_EQ(heard, 6 * 101);
    for (std::size_t i = 0; i < 6; ++i) {
      expect_member(e, all, i, scene(i), strategy);
      EXPECT_EQ(e.outcomes()[i].alone, i == 4);
    }
    ASSERT_EQ(e.report().fallbacks.size(), 1u);
    EXPECT_EQ(e.report().fallbacks[0].rfind("1 of 6 members continued alone", 0), 0u);
    EXPECT_EQ(e.report().counters.steps, 600);
    EXPECT_EQ(e.report().counters.stored_values, static_cast<std::int64_t>(6 * 101 * all.columns().size()));
  }
}

// Members with the same equations but other columns do not fit into the rows of the first.
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

// Only the actuator of member 2 shrinks to zero.
TEST(Ensemble, AVanishingActuatorStopsOnlyItsMember) {
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

}  // namespace
}  // namespace assur::test
