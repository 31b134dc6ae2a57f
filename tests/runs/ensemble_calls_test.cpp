// Members of an ensemble: redundant equations, callbacks, exceptions, refusals, and observers that stop them.
#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <functional>
#include <sstream>

#include "assur/machine.hpp"
#include "backends/allocations.hpp"
#include "plan/preparation.hpp"
#include "refusal.hpp"
#include "runs/ensembles.hpp"

namespace assur::test {
namespace {

// ---- redundant equations, callbacks

// Three parallel rods on a coupler; one rod is redundant and checked.
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

// One equation is redundant at the start and to first order. In member 2, S leaves its place later and contradicts it.
Scene leaving(std::size_t i) {
  SceneBuilder b("leaving", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("C", {1, 0, 0}).point("S", {0.5, 0, 0});
  b.point("B", {1, 1, 0}).constrain("height", FixedCoordinate{"B.y", 1});
  b.constrain("rod", Distance{"S", "B", std::hypot(0.5, 1)}).constrain("stop", Distance{"C", "B", 1.0});
  b.drive("slide", DrivenCoordinate{"S.x", Law::polynomial({0.5, 0, 0, 0, i == 2 ? 1e-3 : 0})});
  b.drive("lift", DrivenCoordinate{"S.y", Law::constant(0)});
  return b.time(0, 1, 0.1).build();
}

TEST(Ensemble, ChecksRedundantEquations) {
  for (const std::string strategy : {"groups/eigen:4", "global/eigen:2"}) {
    Ensemble e = ensemble(5, three_rods, strategy);
    const EnsembleTrajectory all = e.run();
    EXPECT_EQ(e.report().status.code, Code::ok);
    for (std::size_t i = 0; i < 5; ++i) {
      expect_member(e, all, i, three_rods(i), strategy);
      // The checked rod depends on the start posture; members with another one run alone.
      const auto watched = [](std::size_t m) {
        return preparation(prepare(three_rods(m), {"groups/eigen", {}})).structure->checks;
      };
      EXPECT_EQ(e.outcomes()[i].alone, watched(i) != watched(0));
    }
    Ensemble apart = ensemble(4, leaving, strategy);
    const EnsembleTrajectory rows = apart.run();
    EXPECT_EQ(apart.outcomes()[2].status.code, Code::inconsistent);
    EXPECT_EQ(rows.rows(2), test::run(leaving(2), "groups/eigen").trajectory.rows());
    for (const std::size_t i : {0u, 1u, 3u}) EXPECT_EQ(rows.rows(i), 11u);
  }
}

// The lengths are inside the functions, so that every member has to call its own functions.
TEST(Ensemble, UsesTheCallbacksOfEachMember) {
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

// ---- exceptions, refusals, stops

struct Broken : std::runtime_error {
  Broken() : std::runtime_error("broken") {}
};

// The law of member 5 throws, on a grid of equal steps and in a long step for which all members continue alone.
TEST(Ensemble, PropagatesExceptionsOfLaws) {
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

// The members share one preparation, or have one each.
TEST(Ensemble, PropagatesExceptionsOfCallbacks) {
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
    EXPECT_TRUE(e.run().rows(4) == 101);  // the ensemble can run again
  }
}

TEST(Ensemble, RefusesInvalidArguments) {
  EXPECT_EQ(refusal([] { (void)ensemble(0, four_bar); }), "an ensemble needs at least one member");
  EXPECT_NE(refusal([] { (void)Ensemble(1, prepared(four_bar, "groups/eigen"), {0, 0, 0}); }), "");
  EXPECT_NE(refusal([] {
              (void)Ensemble(1, prepared(four_bar, "groups/eigen"), {0, 12, 1});
            }).find("StepSettings::seconds"),
            std::string::npos);
  Ensemble e = ensemble(2, four_bar);
  EXPECT_NE(refusal([&] { (void)e.run(std::vector<double>{}); }), "");
  EXPECT_NE(refusal([&] { (void)e.run(std::vector<double>{0.1, 0.2}); }), "");
  EXPECT_NE(refusal([&] { (void)e.run(std::vector<double>{0, 0.2, 0.1}); }).find("ascend"), std::string::npos);
  EXPECT_NE(refusal([&] { (void)e.run(std::vector<double>{0, NAN}); }).find("finite"), std::string::npos);
  // If no member can be prepared, the error is that of the first.
  EXPECT_THROW((void)ensemble(3, [](std::size_t) { return partly_limited(3); }), Error);
  EXPECT_THROW((void)ensemble(3, [](std::size_t) -> Scene { throw Broken(); }), Broken);
  EXPECT_THROW((void)ensemble(3, four_bar, "groups/nobody"), Error);
}

TEST(Ensemble, RunsTwiceOverGivenTimes) {
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

TEST(Ensemble, RunsFewerMembersThanLanes) {
  for (const std::size_t members : {1u, 2u, 3u, 5u, 9u}) {
    Ensemble e = ensemble(members, four_bar, "groups/lanes:8 2x1");
    const EnsembleTrajectory all = e.run();
    EXPECT_EQ(all.members(), members);
    for (std::size_t i = 0; i < members; ++i) expect_member(e, all, i, four_bar(i), "groups/lanes:8 2x1");
    EXPECT_EQ(e.report().counters.steps, static_cast<std::int64_t>(60 * members));
  }
}

// tEnd2 of the paper: one correction in each step, converged or not.
TEST(Ensemble, FixedIterationsEqualThoseOfASimulator) {
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
      EXPECT_GT(lone.report().error.position, 8 * kEps);  // one iteration is too few to converge
      const std::vector<double> conditions = test::conditions(scene(i), t.times());
      for (std::size_t k = 0; k < t.rows(); ++k) {
        test::expect_same_row(all.row(i, k), t, k, test::sizes(t), conditions[k], 8 * kEps);
      }
    }
  }
}

TEST(Ensemble, PinsItsThreads) {
  const std::vector<std::int32_t> cores = this_machine().cores;
  if (cores.size() < 2) GTEST_SKIP() << "one core";
  StepSettings pinned;
  pinned.pin_to = {cores[0], cores[1]};
  expect_same_bits(Ensemble(11, prepared(four_bar, "groups/eigen:2 2x1"), pinned).run(),
                   ensemble(11, four_bar, "groups/eigen:2 2x1").run());
  pinned.pin_to.pop_back();
  EXPECT_NE(refusal([&] { (void)Ensemble(11, prepared(four_bar, "groups/eigen:2 2x1"), pinned); }).find("pinned"),
            std::string::npos);
}

// Twice as many steps need no more allocations. Strategies with several threads are left out, because their allocations
// depend on the assignment of tiles.
TEST(Ensemble, StepsAllocateNothing) {
  for (const std::string strategy : {"groups/eigen:4", "irreducible/lanes:8+once", "groups/lanes:2"}) {
    Ensemble e = ensemble(16, chain, strategy);
    const std::vector<double> grid = test::grid_of(chain(0));
    const auto taken = [&](std::size_t rows) {
      const std::int64_t before = test::allocations();
      (void)e.run(std::span(grid).first(rows));
      return test::allocations() - before;
    };
    for (int k = 0; k < 20; ++k) (void)taken(61);  // until all code is made that is worth it
    EXPECT_EQ(taken(61), taken(31)) << strategy;
  }
}

TEST(Ensemble, AnObserverIsCalledForEveryRowAndStops) {
  for (const std::string strategy : {"groups/eigen:2", "groups/eigen:4 2x1"}) {
    SCOPED_TRACE(strategy);
    Ensemble e = ensemble(7, four_bar, strategy);
    const EnsembleTrajectory all = e.run();
    std::int64_t heard = 0;
    (void)e.run([&](std::int64_t done, std::int64_t of) {
      EXPECT_EQ(of, 7 * 61);
      EXPECT_GT(done, heard);
      heard = done;
      return false;
    });
    EXPECT_EQ(heard, 7 * 61);

    const EnsembleTrajectory some = e.run([](std::int64_t done, std::int64_t) { return done >= 100; });
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
    // One thread stops at once, the other one after its current step.
    EXPECT_LE(rows, strategy == "groups/eigen:2" ? 101u : 7u * 61 - 1);
  }
}

TEST(Ensemble, AnObserverStopsMembersOfAnotherStructure) {
  const SceneOf scene = [](std::size_t i) {
    if (i == 3) return in_translation();
    return i > 0 ? on_a_rail() : with_law(Law::polynomial({0, 3})).with_outputs({"B", "C"});
  };
  Ensemble e = ensemble(4, scene);
  // Stops the member alone in its structure, the two that share one, and the first.
  for (const auto& [most, rows] : std::vector<std::pair<std::int64_t, std::vector<std::size_t>>>{
           {350, {101, 101, 101, 47}}, {150, {101, 25, 25, 0}}, {50, {50, 0, 0, 0}}}) {
    const EnsembleTrajectory all = e.run([most = most](std::int64_t done, std::int64_t) { return done >= most; });
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_EQ(all.rows(i), rows[i]) << most << " " << i;
      EXPECT_EQ(e.outcomes()[i].status.code, rows[i] == 101 ? Code::ok : Code::interrupted) << most << " " << i;
      EXPECT_EQ(e.outcomes()[i].reached, all.times()[rows[i] > 0 ? rows[i] - 1 : 0]) << most << " " << i;
    }
  }
}

// Members that share no structure are pieces of one queue with the tiles of the others.
TEST(Ensemble, MembersOfManyStructuresOnTwoThreads) {
  const SceneOf scene = [](std::size_t i) {
    if (i == 3) return in_translation();
    if (i % 3 == 1) {  // another start time
      return with_law(Law::polynomial({0, 2}))
          .with_outputs({"B", "C"})
          .with_time({0.01 * static_cast<double>(i), 1, 0.01});
    }
    return i % 3 == 2 ? with_law(Law::polynomial({0, 3})).with_outputs({"B", "C"}) : on_a_rail();
  };
  Ensemble one = ensemble(23, scene), two = ensemble(23, scene, "groups/eigen:4 2x1");
  const EnsembleTrajectory a = one.run(), b = two.run();
  ASSERT_EQ(a.values().size(), b.values().size());
  EXPECT_EQ(std::memcmp(a.values().data(), b.values().data(), a.values().size_bytes()), 0);
  for (std::size_t i = 0; i < 23; ++i) {
    EXPECT_EQ(one.outcomes()[i].status.code, two.outcomes()[i].status.code) << i;
    EXPECT_EQ(one.outcomes()[i].alone, two.outcomes()[i].alone) << i;
    EXPECT_EQ(one.outcomes()[i].cannot, "") << i;
  }
  EXPECT_EQ(one.report().fallbacks, two.report().fallbacks);
  EXPECT_EQ(std::count_if(one.outcomes().begin(), one.outcomes().end(), [](const auto& o) { return o.alone; }), 9);
}

TEST(Ensemble, CsvHasAllFinishedRows) {
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
}  // namespace assur::test
