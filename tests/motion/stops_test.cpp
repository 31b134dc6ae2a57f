// Limits of joints and measures: where they end or flag a motion, against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "assur/ensemble.hpp"
#include "assur/motion_range.hpp"
#include "assur/saved_plan.hpp"
#include "backends/allocations.hpp"
#include "motion/limit_watch.hpp"
#include "numbers.hpp"
#include "samples/samples.hpp"
#include "simulation/run.hpp"

namespace assur {
namespace {

constexpr double kRounding = 1e-12;
constexpr auto kFlag = Limit::Reaction::flag;

// Crank 0.5 about the origin, rod 1.5, piston on the x-axis: x = c cos a + sqrt(l^2 - c^2 sin^2 a).
constexpr double kCrank = 0.5, kRod = 1.5;
double piston(double angle) {
  const double y = kCrank * std::sin(angle);
  return kCrank * std::cos(angle) + std::sqrt(kRod * kRod - y * y);
}
// The crank's angle in (0, pi) at which the piston is at x, by the law of cosines.
double angle_at(double x) { return std::acos((kCrank * kCrank + x * x - kRod * kRod) / (2 * kCrank * x)); }

SceneBuilder pump(double from = 0, double speed = 1) {
  SceneBuilder builder("pump", 2);
  for (const char* name : {"crank", "rod", "piston"}) builder.add(Body{.name = name});
  builder.joint("O", Revolute{"ground", "crank", Triple{0, 0}});
  builder.joint("B", Revolute{"crank", "rod", Triple{kCrank, 0}});
  builder.joint("C", Revolute{"rod", "piston", Triple{kCrank + kRod, 0}});
  builder.joint("S", Prismatic{"ground", "piston", Triple{1, 0}});
  builder.drive("motor", DrivenCoordinate{"O.angle", Law::polynomial({from, speed})});
  builder.output("C").time(0, 10, 0.05);
  return builder;
}

void expect_event(const Event& e, Code kind, const std::string& quantity, double time, double width = kRounding) {
  EXPECT_EQ(e.kind, kind);
  EXPECT_EQ(e.group, quantity);
  EXPECT_NEAR(e.time, time, width);
  EXPECT_NEAR(e.until, time, width);
}

TEST(Stops, EndAMotionWhereTheClosedFormReachesTheBound) {
  for (const char* strategy : {"auto", "global/eigen", "groups/eigen+once+predict=hermite:5", "irreducible/eigen",
                               "groups/lanes:4+predict=past:3", "groups/eigen 2x1"}) {
    SCOPED_TRACE(strategy);
    const Scene scene = pump().limit("S.displacement", -0.8, HUGE_VAL).build();  // no output names it
    const test::Result r = test::run(scene, strategy);
    const double end = angle_at(kCrank + kRod - 0.8);
    EXPECT_EQ(r.report().status.code, Code::limit_reached);
    EXPECT_EQ(r.report().status.figure, -0.8);
    ASSERT_EQ(r.report().events.size(), 1u);
    const Event& e = r.report().events[0];
    expect_event(e, Code::limit_reached, "S.displacement", end);
    EXPECT_LE(e.until - e.time, 16 * kEps * end);
    EXPECT_EQ(e.unit, "m");
    EXPECT_NE(e.detail.find("smallest allowed value is -0.8 m"), std::string::npos) << e.detail;
    ASSERT_EQ(r.trajectory.rows(), static_cast<std::size_t>(std::floor(end / 0.05)) + 1);
    EXPECT_EQ(r.report().reached, e.time);
    EXPECT_NEAR(r.simulator.output("C.x"), kCrank + kRod - 0.8, 1e-14);
    EXPECT_EQ(r.trajectory.columns(), test::run(pump().build()).trajectory.columns());
  }
}

// Two dyads in a row, whose levels are solved together.
TEST(Stops, AreTheSameIfLevelsAreSolvedTogether) {
  SceneBuilder builder("dyads", 2);
  builder.fixed_point("A", {0, 0}).fixed_point("D", {2, 0}).fixed_point("G", {4, 0});
  builder.point("B", {0, 0.5}).point("C", {2, 1}).point("F", {4, 1});
  builder.constrain("coupler", Distance{"B", "C"}).constrain("rocker", Distance{"D", "C"});
  builder.constrain("link", Distance{"C", "F"}).constrain("lever", Distance{"G", "F"});
  builder.drive("motor", PointAngle{"A", "B", "", Law::polynomial({kTurn / 4, 1})});
  builder.measure("height", MeasuredCoordinate{"F.y"}).measure("lean", AbsoluteAngle{"G", "F"});
  builder.limit("height", 0.99, 2, kFlag).limit("lean", -1, 1.9).output("F").time(0, 3, 0.02);
  const Scene scene = builder.build();
  const Report one = test::run(scene, "groups/eigen").report();
  const Report together = test::run(scene, "irreducible/lanes:4+together").report();
  EXPECT_EQ(one.status.code, Code::limit_reached);
  EXPECT_EQ(together.status.code, Code::limit_reached);
  ASSERT_GE(one.events.size(), 2u);
  ASSERT_EQ(together.events.size(), one.events.size());
  for (std::size_t i = 0; i < one.events.size(); ++i) {
    expect_event(together.events[i], one.events[i].kind, one.events[i].group, one.events[i].time);
  }
}

// The limit changes no bit of the rows before it, and nothing without limits.
TEST(Stops, LeaveTheMotionAsItIs) {
  const test::Result free = test::run(pump().output("S.displacement").build());
  const test::Result held = test::run(pump().output("S.displacement").limit("S.displacement", -0.8, 0.5).build());
  ASSERT_GT(free.trajectory.rows(), held.trajectory.rows());
  for (std::size_t k = 0; k < held.trajectory.rows(); ++k) {
    for (std::size_t c = 0; c < held.trajectory.columns().size(); ++c) {
      EXPECT_NEAR(held.trajectory(k, c), free.trajectory(k, c), 4e-15);
    }
  }
}

TEST(Stops, FlagEveryPassage) {
  const Scene scene = pump().limit("S.displacement", -0.8, HUGE_VAL, kFlag).build();
  const test::Result r = test::run(scene);
  EXPECT_TRUE(r.report().status.ok());
  EXPECT_EQ(r.trajectory.rows(), 201u);
  const double leaves = angle_at(kCrank + kRod - 0.8);
  ASSERT_EQ(r.report().events.size(), 3u);
  expect_event(r.report().events[0], Code::limit_exceeded, "S.displacement", leaves);
  expect_event(r.report().events[1], Code::within_limits, "S.displacement", kTurn - leaves);
  expect_event(r.report().events[2], Code::limit_exceeded, "S.displacement", kTurn + leaves);
  for (const Event& e : r.report().events) EXPECT_LE(e.until - e.time, 16 * kEps * 10);
}

TEST(Stops, HoldForMeasuresAndTheirSums) {
  const auto with = [](const std::string& quantity, double min, double max) {
    SceneBuilder builder = pump();
    builder.measure("reach", MeasuredDistance{"O", "C"});
    builder.measure("lean", AngleBetween{Direction("O", "C"), Direction("B", "C"), ""});
    builder.measure("turned", MeasuredCoordinate{"O.angle"});
    builder.measure("sum", Combination{{{"lean", 2}, {"turned", 1}}, 0.5});
    return test::run(builder.limit(quantity, min, max).build()).report();
  };
  const auto ends = [&](const Report& report, const std::string& quantity, double time) {
    ASSERT_EQ(report.status.code, Code::limit_reached);
    expect_event(report.events.back(), Code::limit_reached, quantity, time);
  };
  ends(with("reach", 1.2, 9), "reach", angle_at(1.2));
  // B is above the x-axis, so that BC points down: lean = -asin(c sin a / l).
  ends(with("lean", -0.2, 9), "lean", std::asin(kRod * std::sin(0.2) / kCrank));
  ends(with("turned", -1, 7.5), "turned", 7.5);  // more than a whole turn
  const double target = 2.0;                     // of 0.5 + a - 2 asin(c sin a / l)
  double low = 0, high = 3.1;
  const auto sum = [](double a) { return 0.5 + a - 2 * std::asin(kCrank * std::sin(a) / kRod); };
  for (int k = 0; k < 100; ++k) (sum((low + high) / 2) < target ? low : high) = (low + high) / 2;
  ends(with("sum", -9, target), "sum", low);
}

// The driver of a joint begins beyond half a turn; its law tells the whole turns.
TEST(Stops, CountTurnsFromTheLawOfTheDriver) {
  const test::Result r = test::run(pump(5).limit("O.angle", -6, 6).build());
  ASSERT_EQ(r.report().status.code, Code::limit_reached);
  expect_event(r.report().events[0], Code::limit_reached, "O.angle", 1);
  const test::Result back = test::run(pump(5, -1).limit("O.angle", -4, 6).build());
  ASSERT_EQ(back.report().status.code, Code::limit_reached);
  expect_event(back.report().events[0], Code::limit_reached, "O.angle", 9);
}

// An angle that no law gives begins within its limit if whole turns bring it there.
TEST(Stops, BeginWithinTheLimitByWholeTurns) {
  SceneBuilder builder = pump(0.5);
  builder.measure("direction", AbsoluteAngle{"O", "B"});
  const test::Result r = test::run(builder.limit("direction", 6, 8).build());
  ASSERT_EQ(r.report().status.code, Code::limit_reached);
  expect_event(r.report().events[0], Code::limit_reached, "direction", 8 - kTurn - 0.5);
}

// With one bound, or with bounds more than a turn apart, any number of turns might be meant.
TEST(Stops, AddNoTurnsIfTheirNumberIsAmbiguous) {
  for (const double most : {HUGE_VAL, 7.2}) {
    SceneBuilder builder = pump(0.5);
    builder.measure("direction", AbsoluteAngle{"O", "B"}).limit("direction", 0.8, most);
    EXPECT_THROW((void)test::run(builder.build()), Error) << most;
    SceneBuilder flagged = pump(0.5);
    flagged.measure("direction", AbsoluteAngle{"O", "B"}).limit("direction", 0.8, most, kFlag);
    const test::Result r = test::run(flagged.build());
    ASSERT_GE(r.report().events.size(), 1u) << most;
    EXPECT_EQ(r.report().events[0].kind, Code::limit_exceeded) << most;
    EXPECT_EQ(r.report().events[0].time, 0) << most;
  }
}

// x = a sin(w t) on a slider: peaks of a are touched between the steps.
Scene slider(double amplitude, double phase, double bound, Limit::Reaction reaction, double step = 0.01) {
  SceneBuilder builder("slider", 2);
  builder.add(Body{.name = "cart"}).joint("S", Prismatic{"ground", "cart", Triple{1, 0}});
  builder.drive("motor", DrivenCoordinate{"S.displacement", Law::harmonics({{amplitude, 1, phase}})});
  builder.measure("way", MeasuredCoordinate{"S.displacement"}).output("way");
  return builder.limit("way", -HUGE_VAL, bound, reaction).time(0, 0.5, step).build();
}

// A peak that lies between two steps and exceeds the bound by a billionth, or misses it by a billionth.
TEST(Stops, FindExcursionsWithinOneStep) {
  for (const double phase : {0.013, 0.0314, 0.3}) {
    SCOPED_TRACE(phase);
    const double peak = (std::numbers::pi / 2 - phase) / kTurn;  // s
    for (const double above : {1e-2, 1e-5, 1e-9}) {
      const double half = std::acos(1 / (1 + above)) / kTurn;
      const Report flagged = test::run(slider(1 + above, phase, 1, kFlag)).report();
      ASSERT_EQ(flagged.events.size(), 2u) << above;
      const double width = 2e-14 / std::sqrt(2 * above);  // rounding over the slope at the bound
      expect_event(flagged.events[0], Code::limit_exceeded, "way", peak - half, width + kRounding);
      expect_event(flagged.events[1], Code::within_limits, "way", peak + half, width + kRounding);
      const test::Result ended = test::run(slider(1 + above, phase, 1, Limit::Reaction::end));
      ASSERT_EQ(ended.report().status.code, Code::limit_reached);
      expect_event(ended.report().events[0], Code::limit_reached, "way", peak - half, width + kRounding);
      EXPECT_LE(ended.simulator.output("way"), 1 + 1e-13);
      EXPECT_TRUE(test::run(slider(1 - above, phase, 1, Limit::Reaction::end)).report().status.ok()) << above;
    }
  }
}

TEST(Stops, LetAMotionRestAtItsLimit) {
  EXPECT_TRUE(test::run(slider(1, 0, 1, Limit::Reaction::end)).report().status.ok());
  const Scene scene = pump().limit("O.angle", 0, 10).build();
  const test::Result r = test::run(scene);
  EXPECT_TRUE(r.report().status.ok());
  EXPECT_EQ(r.trajectory.rows(), 201u);
}

TEST(Stops, RefuseAStartOutside) {
  try {
    (void)test::simulator(pump(0.5).limit("O.angle", -1, 0.25).build());
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::numerical);
    EXPECT_STREQ(error.what(),
                 "the start posture violates a limit: O.angle is 0.5 rad, above its largest allowed value 0.25 rad; "
                 "start elsewhere, or give the limit the reaction \"flag\"");
  }
  const test::Result r = test::run(pump(0.5, -1).limit("O.angle", -1, 0.25, kFlag).build());
  ASSERT_EQ(r.report().events.size(), 3u);
  expect_event(r.report().events[0], Code::limit_exceeded, "O.angle", 0);
  expect_event(r.report().events[1], Code::within_limits, "O.angle", 0.25);
  expect_event(r.report().events[2], Code::limit_exceeded, "O.angle", 1.5);
}

TEST(Stops, EndTheRangeOfADriver) {
  const Scene scene = pump().limit("S.displacement", -0.8, HUGE_VAL).build();
  const MotionRange range = motion_range(scene);
  const double end = angle_at(kCrank + kRod - 0.8);
  for (const auto& [side, value] : {std::pair{range.low, -end}, {range.high, end}}) {
    EXPECT_EQ(side.code, Code::limit_reached);
    EXPECT_EQ(side.group, "S.displacement");
    EXPECT_NEAR(side.reached, value, kRounding);
    EXPECT_NEAR(side.beyond, value, kRounding);
  }
}

TEST(Stops, ArePassedByARangeIfTheyFlag) {
  SceneBuilder builder = pump();
  builder.measure("soft", MeasuredCoordinate{"O.angle"});
  const MotionRange range = motion_range(builder.limit("soft", -0.5, 0.75, kFlag).limit("O.angle", -1, 2).build());
  EXPECT_NEAR(range.low.reached, -1, kRounding);
  EXPECT_NEAR(range.high.reached, 2, kRounding);
  ASSERT_EQ(range.passed.size(), 2u);
  EXPECT_EQ(range.passed[0].quantity, "soft");
  EXPECT_NEAR(range.passed[0].at, -0.5, kRounding);
  EXPECT_NEAR(range.passed[1].at, 0.75, kRounding);
  EXPECT_TRUE(range.passed[0].leaves && range.passed[1].leaves);
}

TEST(Stops, StopAControlledDriverUntilItTurnsBack) {
  const Scene scene = pump().limit("O.angle", -0.5, 0.5).time(0, 1, 0.01).build();
  Simulator s(prepare(scene, {.controlled = {"motor"}}));
  s.set("motor", 0.45, 0);
  ASSERT_TRUE(s.step().ok());
  s.set("motor", 0.7, 0);
  EXPECT_EQ(s.step().code, Code::limit_reached);
  EXPECT_DOUBLE_EQ(s.time(), 0.01);  // as it was before the step
  s.set("motor", 0.7, 0);
  EXPECT_EQ(s.step(0.02).code, Code::limit_reached);  // stays at the limit
  EXPECT_LT(s.time(), 0.02);
  EXPECT_NEAR(std::atan2(s.output("C.y"), s.output("C.x")), 0, 1e-15);
  EXPECT_NEAR(s.output("C.x"), piston(0.5), 1e-14);
  s.set("motor", 0.3, 0);
  ASSERT_TRUE(s.step().ok());
  EXPECT_NEAR(s.output("C.x"), piston(0.3), 1e-14);
  // Events of steps that were undone are forgotten, those of the motion are kept.
  EXPECT_EQ(s.report().events.back().kind, Code::limit_reached);
}

TEST(Stops, ContinueASavedState) {
  const Scene scene = pump().limit("O.angle", -1, 7).build();
  Simulator s(prepare(scene));
  ASSERT_TRUE(s.step(6.5).ok());
  const SimulatorState state = s.save();
  EXPECT_EQ(s.step(8).code, Code::limit_reached);
  EXPECT_NEAR(s.time(), 7, kRounding);
  s.restore(state);
  EXPECT_EQ(s.step(9).code, Code::limit_reached);
  EXPECT_NEAR(s.time(), 7, kRounding);
}

// Each turn has two events. A run keeps them all; single steps drop the older half of 1,000.
TEST(Stops, SingleStepsKeepTheLatestEvents) {
  constexpr int kTurns = 1100;
  const Scene scene = pump().limit("S.displacement", -0.5, 3, kFlag).time(0, kTurns * kTurn, kTurn / 8).build();
  Simulator all(prepare(scene)), loop(all.prepared()), row_by_row(all.prepared());
  EXPECT_EQ(all.run().rows(), 8 * kTurns + 1);
  EXPECT_EQ(all.report().events.size(), 2 * kTurns);
  EXPECT_EQ(all.report().dropped_events, 0);
  std::int64_t allocated = 0;
  for (int k = 1; k <= 8 * kTurns; ++k) {
    const std::int64_t before = test::allocations();
    ASSERT_TRUE(loop.step().ok());
    allocated += test::allocations() - before;
    ASSERT_TRUE(row_by_row.step(scene.time().time(k)).ok());
    ASSERT_LE(loop.report().events.size(), 1001u);
  }
  EXPECT_EQ(allocated, 0);
  for (const Simulator* const s : {&loop, &row_by_row}) {
    const std::vector<Event>& kept = s->report().events;
    EXPECT_EQ(s->report().dropped_events, 1500);
    ASSERT_EQ(kept.size(), 2 * kTurns - 1500);
    expect_event(kept.back(), Code::within_limits, "S.displacement", all.report().events.back().time, 1e-9);
    expect_event(kept.front(), Code::limit_exceeded, "S.displacement", all.report().events[1500].time, 1e-9);
  }
  loop.reset();
  EXPECT_EQ(loop.report().dropped_events, 0);
}

TEST(Stops, AreKeptBySavedPlans) {
  std::stringstream file;
  save_plan(file,
            prepare(pump().limit("S.displacement", -0.8, 3).limit("O.angle", -1, 1, kFlag).build(), {"groups/eigen"}));
  Simulator s(load_plan(file));
  (void)s.run();
  EXPECT_EQ(s.report().status.code, Code::limit_reached);
  ASSERT_EQ(s.report().events.size(), 2u);
  expect_event(s.report().events[0], Code::limit_exceeded, "O.angle", 1);
  expect_event(s.report().events[1], Code::limit_reached, "S.displacement", angle_at(kCrank + kRod - 0.8));
}

// Members have their own bounds. Those that end do so alone; those that are flagged stay in lanes.
TEST(Stops, EndMembersOfAnEnsembleOneByOne) {
  const std::vector<double> bounds = {-0.3, -0.5, -0.7, -0.9, -1.1, 0.1};
  for (const int threads : {1, 2}) {
    Ensemble ensemble(bounds.size(), [&](std::size_t i) {
      return prepare(pump().limit("S.displacement", bounds[i], HUGE_VAL).limit("O.angle", -1, 0.75, kFlag).build(),
                     {.strategy = "groups/lanes:4", .budget = ThreadBudget{threads}, .mode = Mode::throughput});
    });
    const EnsembleTrajectory motion = ensemble.run();
    for (std::size_t i = 0; i < bounds.size(); ++i) {
      SCOPED_TRACE(bounds[i]);
      const Ensemble::Outcome& outcome = ensemble.outcomes()[i];
      if (bounds[i] > 0) {
        EXPECT_NE(outcome.cannot.find("the start posture violates a limit: S.displacement is 0 m"), std::string::npos)
            << outcome.cannot;
        continue;
      }
      if (bounds[i] < -1) {
        EXPECT_TRUE(outcome.status.ok());
        EXPECT_FALSE(outcome.alone);
        EXPECT_EQ(motion.rows(i), 201u);
      } else {
        const double end = angle_at(kCrank + kRod + bounds[i]);
        EXPECT_EQ(outcome.status.code, Code::limit_reached);
        EXPECT_EQ(motion.rows(i), static_cast<std::size_t>(std::floor(end / 0.05)) + 1);
        expect_event(outcome.events.back(), Code::limit_reached, "S.displacement", end);
      }
      const bool is_flagged = bounds[i] < -1 || angle_at(kCrank + kRod + bounds[i]) > 0.75;
      EXPECT_EQ(outcome.events.front().kind == Code::limit_exceeded, is_flagged);
      if (is_flagged) expect_event(outcome.events.front(), Code::limit_exceeded, "O.angle", 0.75);
    }
  }
}

TEST(Stops, AreFollowedStepByStepInsteadOfInChunks) {
  const Scene scene = pump().limit("S.displacement", -0.8, HUGE_VAL).build();
  const test::Result r = test::run(scene, "groups/lanes:4+chunks=4");
  EXPECT_EQ(r.report().status.code, Code::limit_reached);
  ASSERT_FALSE(r.report().fallbacks.empty());
  EXPECT_EQ(r.report().fallbacks.front(), "no chunks: limits are followed from step to step");
}

// Two soft bounds within two hard ones, passed within one long step: in the order of time, up to the end.
TEST(Stops, TellEventsInTheirOrder) {
  SceneBuilder builder = pump();
  builder.measure("soft", MeasuredCoordinate{"O.angle"}).measure("softer", MeasuredCoordinate{"O.angle"});
  builder.limit("O.angle", -1, 0.9).limit("soft", -1, 0.8, kFlag).limit("softer", -1, 0.7, kFlag).time(0, 2, 1);
  const Report report = test::run(builder.build()).report();
  ASSERT_EQ(report.events.size(), 3u);
  expect_event(report.events[0], Code::limit_exceeded, "softer", 0.7);
  expect_event(report.events[1], Code::limit_exceeded, "soft", 0.8);
  expect_event(report.events[2], Code::limit_reached, "O.angle", 0.9);
}

TEST(Stops, FollowBackwardMotions) {
  Simulator s(prepare(pump().limit("O.angle", -1, 1).build()));
  EXPECT_EQ(s.step(-3).code, Code::limit_reached);
  EXPECT_NEAR(s.time(), -1, kRounding);
  EXPECT_TRUE(s.step(0.5).ok());
}

// The extrema of a polynomial against a fine grid.
TEST(Quintic, FindsItsExtrema) {
  const auto value = [](double s) { return std::sin(9 * s + 0.3) * std::exp(-s); };
  const auto slope = [&](double s) { return (9 * std::cos(9 * s + 0.3) - std::sin(9 * s + 0.3)) * std::exp(-s); };
  const auto bend = [&](double s) { return (-80 * std::sin(9 * s + 0.3) - 18 * std::cos(9 * s + 0.3)) * std::exp(-s); };
  for (const double width : {0.1, 0.4, 0.9}) {
    const auto jet = [&](double s) { return Jet<double>{value(s), width * slope(s), width * width * bend(s)}; };
    const Quintic q(jet(0.05), jet(0.05 + width));
    const auto extrema = q.extrema();
    std::size_t turns = 0;
    constexpr int kGrid = 100000;
    for (int k = 1; k < kGrid; ++k) {
      const double before = q.at((k - 1.0) / kGrid), here = q.at(1.0 * k / kGrid), after = q.at((k + 1.0) / kGrid);
      if ((here - before) * (after - here) >= 0) continue;
      ASSERT_LT(turns, extrema.count);
      EXPECT_NEAR(extrema.at[turns], 1.0 * k / kGrid, 1.0 / kGrid);
      ++turns;
    }
    EXPECT_EQ(turns, extrema.count);
  }
}

}  // namespace
}  // namespace assur
