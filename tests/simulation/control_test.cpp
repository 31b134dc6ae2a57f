// A control loop: commanded drivers, deadlines, failed steps that change nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>

#include "backends/allocations.hpp"
#include "motion/limited.hpp"
#include "properties/delta_robot.hpp"
#include "simulation/run.hpp"
#include "simulation/simulator_access.hpp"

namespace assur {
namespace {

using test::Result;

constexpr double kOmega = 6.283185307179586;

TEST(Control, TracksALawSetStepByStep) {
  const Scene scene = sample("four_bar:loops=3,step=0.005,steps=400");
  const Law law = Law::polynomial({0, 1, 0.5}) + Law::harmonics({{0.2, 1.5, 0.3}}, -0.2 * std::sin(0.3));
  for (const std::string strategy : {"groups/eigen", "irreducible/eigen+once", "global/eigen+predict=taylor:1"}) {
    SCOPED_TRACE(strategy);
    // The same mechanism with the law in the scene.
    SceneBuilder builder("four_bar", 2);
    for (const Point& p : scene.points()) builder.add(p);
    for (const Constraint& c : scene.constraints()) builder.add(c);
    builder.drive("motor", PointAngle{"A0", "B0", "", law}).time(0, 2, 0.005);
    Simulator by_law = test::simulator(builder.build(), strategy);
    Simulator by_hand = test::simulator(scene.with_outputs({"B1", "B3"}), strategy, {}, {"motor"});
    double worst[3] = {};
    for (int k = 1; k <= 400; ++k) {
      const double t = by_hand.time() + 0.005;
      const Motion m = law(t);
      by_hand.set("motor", m.value, m.rate, m.acceleration);
      ASSERT_TRUE(by_hand.step().ok()) << k;
      ASSERT_TRUE(by_law.step(t).ok()) << k;
      ASSERT_EQ(by_hand.time(), t);
      for (std::size_t c = 0; c < by_hand.columns().size(); ++c) {
        const std::string& column = by_hand.columns()[c];
        const int d = column[3] == 'v' ? 1 : column[3] == 'a' ? 2 : 0;
        const double reference = by_law.output(column);
        worst[d] = std::max(worst[d], std::abs(by_hand.outputs()[c] - reference) / std::max(1.0, std::abs(reference)));
      }
    }
    EXPECT_LE(worst[0], 1e-12);
    EXPECT_LE(worst[1], 1e-12);
    EXPECT_LE(worst[2], 1e-12);
  }
}

TEST(Control, SetsThePartsOfAPose) {
  const Scene scene = sample("stewart");
  Simulator by_law = test::simulator(scene, "groups/eigen");
  Simulator by_hand = test::simulator(scene, "groups/eigen", {}, {"pose"});
  for (const Driver& driver : scene.drivers()) {
    const auto& pose = std::get<Pose>(driver.kind);
    const char* const names[6] = {"pose.x", "pose.y", "pose.z", "pose.psi", "pose.theta", "pose.phi"};
    for (int k = 1; k <= 100; ++k) {
      const double t = by_hand.time() + 0.01;
      for (std::size_t i = 0; i < 6; ++i) {
        const Motion m = (i < 3 ? pose.translation[i] : pose.rotation[i - 3])(t);
        by_hand.set(names[i], m.value, m.rate, m.acceleration);
      }
      ASSERT_TRUE(by_hand.step().ok());
      ASSERT_TRUE(by_law.step(t).ok());
    }
  }
  for (const std::string& column : by_law.columns()) {
    EXPECT_NEAR(by_hand.output(column), by_law.output(column), 1e-12 * (1 + std::abs(by_law.output(column)))) << column;
  }
}

TEST(Control, UnknownDriverIsRefused) {
  Simulator s = test::simulator(sample("four_bar"), "auto", {}, {"motor"});
  try {
    s.set("moter", 1);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), Error::Kind::input);
    EXPECT_STREQ(e.what(), "'moter' is not a controlled driver; did you mean 'motor'? There are: motor");
  }
  Simulator platform = test::simulator(sample("stewart"), "groups/eigen", {}, {"pose"});
  try {
    platform.set("pose", 1);
    FAIL();
  } catch (const Error& e) {
    EXPECT_STREQ(
        e.what(),
        "'pose' is not a controlled driver; there are: pose.x, pose.y, pose.z, pose.psi, pose.theta, pose.phi");
  }
  Simulator uncontrolled = test::simulator(sample("four_bar"));
  EXPECT_THROW(uncontrolled.set("motor", 1), Error);
}

// Handles lead to the drivers and columns with these names, also those of another simulator of the same Prepared.
TEST(Control, HandlesStandForNames) {
  const Prepared prepared = prepare(sample("stewart"), {.strategy = "groups/eigen", .controlled = {"pose"}});
  Simulator by_name(prepared), by_handle(prepared), other(prepared);
  const DriverHandle x = by_handle.driver("pose.x"), psi = other.driver("pose.psi");
  const std::size_t column = by_handle.index("B3.vy");
  for (int k = 1; k < 20; ++k) {
    const double value = 0.001 * k;
    by_name.set("pose.x", value, 0.1);
    by_handle.set(x, value, 0.1);
    by_name.set("pose.psi", 2 * value, 0.2, 0.5);
    by_handle.set(psi, 2 * value, 0.2, 0.5);
    ASSERT_TRUE(by_name.step().ok());
    ASSERT_TRUE(by_handle.step().ok());
    ASSERT_TRUE(std::ranges::equal(by_name.outputs(), by_handle.outputs()));
    ASSERT_EQ(by_handle.outputs()[column], by_name.output("B3.vy"));
  }
  const std::int64_t before = test::allocations();
  by_handle.set(x, 0.02);
  EXPECT_EQ(test::allocations(), before);
  EXPECT_THROW(by_handle.set(DriverHandle(), 1), Error);
  EXPECT_THROW(Simulator(prepare(sample("stewart"))).set(x, 1), Error);
  Simulator with_others(prepare(sample("four_bar"), {.controlled = {"motor"}}));
  EXPECT_THROW(with_others.set(x, 1), Error);  // though both are the first ones
  EXPECT_THROW((void)by_handle.driver("pose.w"), Error);
  EXPECT_THROW((void)by_handle.index("B3.q"), Error);
}

// This mechanism cannot reach cos(angle) < 0.04.
Scene limited() {
  return test::limited_four_bar(Law::constant(0.5)).measure("angle", AbsoluteAngle{"A0", "B"}).time(0, 1, 0.01).build();
}

double coupler_error(const Simulator& s) {
  return std::abs(std::hypot(s.output("C.x") - s.output("B.x"), s.output("C.y") - s.output("B.y")) - 1);
}

TEST(Control, AnImpossibleCommandKeepsTheLastPosture) {
  for (const std::string strategy : {"groups/eigen", "global/eigen+predict=past:3", "irreducible/eigen+once"}) {
    SCOPED_TRACE(strategy);
    Simulator s = test::simulator(limited(), strategy, {}, {"motor"});
    for (int k = 1; k <= 10; ++k) {
      s.set("motor", 0.5 + 0.05 * k, 5);
      ASSERT_TRUE(s.step().ok()) << k;
    }
    const double before = s.time();
    s.set("motor", 2.5);
    const Status failed = s.step();
    EXPECT_EQ(failed.code, Code::fold);
    EXPECT_EQ(s.report().status.code, failed.code);
    // The simulator stops at a posture on the way, and the outputs belong to this posture.
    EXPECT_GE(s.time(), before);
    EXPECT_LT(s.time(), before + 0.01);
    EXPECT_EQ(s.report().reached, s.time());
    EXPECT_GE(s.output("angle"), 1.0 - 1e-12);
    EXPECT_LE(s.output("angle"), std::acos(0.04));
    EXPECT_NEAR(s.output("B.x"), std::cos(s.output("angle")), 8 * kEps);
    EXPECT_LE(coupler_error(s), 32 * kEps);
    EXPECT_EQ(s.time() > before, s.output("angle") > 1.0 + 1e-12);
    // The loop continues with a reachable command.
    const double now = s.time();
    s.set("motor", 1.2);
    ASSERT_TRUE(s.step().ok());
    EXPECT_EQ(s.time(), now + 0.01);
    EXPECT_NEAR(s.output("angle"), 1.2, 8 * kEps);
    EXPECT_LE(coupler_error(s), 32 * kEps);
    s.set("motor", 1.1);
    ASSERT_TRUE(s.step().ok());
    EXPECT_NEAR(s.output("angle"), 1.1, 8 * kEps);
    EXPECT_TRUE(s.report().status.ok());
  }
}

TEST(Control, ADriverRestsUntilItIsSetAgain) {
  Simulator s = test::simulator(sample("four_bar:step=0.01"), "auto", {}, {"motor"});
  s.set("motor", 0.1, 3, 2);
  ASSERT_TRUE(s.step().ok());
  EXPECT_NEAR(s.output("B0.vy"), 0.8 * 3 * std::cos(0.1), 32 * kEps);
  ASSERT_TRUE(s.step().ok());
  EXPECT_NEAR(s.output("B0.x"), 0.8 * std::cos(0.1), 4 * kEps);
  EXPECT_EQ(s.output("B0.vx"), 0);
  EXPECT_EQ(s.output("B1.vx"), 0);
  EXPECT_EQ(s.output("B1.ax"), 0);
}

TEST(Control, NonFiniteCommandsFailAndNameTheDriver) {
  const std::string strategy = "groups/eigen";
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    for (int part = 0; part < 3; ++part) {
      Simulator s = test::simulator(sample("four_bar:step=0.01"), strategy, {}, {"motor"});
      s.set("motor", 0.1, 3);
      ASSERT_TRUE(s.step().ok());
      const std::vector<double> before(s.outputs().begin(), s.outputs().end());
      const double now = s.time();
      for (int again = 0; again < 3; ++again) {
        s.set("motor", part == 0 ? bad : 0.2, part == 1 ? bad : 3, part == 2 ? bad : 0);
        EXPECT_EQ(s.step().code, Code::not_finite);
      }
      EXPECT_EQ(s.report().status.code, Code::not_finite);
      ASSERT_EQ(s.report().events.size(), 1u);  // one event for three failures
      const Event& e = s.report().events[0];
      EXPECT_EQ(e.group, "motor");
      EXPECT_EQ(e.kind, Code::not_finite);
      EXPECT_EQ(e.time, now);
      EXPECT_EQ(e.until, now + 0.01);
      EXPECT_FALSE(std::isfinite(e.figure));
      EXPECT_EQ(s.time(), now);
      EXPECT_EQ(before, std::vector<double>(s.outputs().begin(), s.outputs().end()));
      // The failed step has discarded the command, and the loop continues.
      s.set("motor", 0.15, 3);
      ASSERT_TRUE(s.step().ok());
      EXPECT_NEAR(s.output("B0.x"), 0.8 * std::cos(0.15), 4 * kEps);
    }
  }
}

TEST(Control, NamesTheNonFinitePartOfAPose) {
  Simulator s = test::simulator(sample("stewart"), "groups/eigen", {}, {"pose"});
  s.set("pose.z", 0.5);
  s.set("pose.theta", std::nan(""));
  EXPECT_EQ(s.step().code, Code::not_finite);
  ASSERT_EQ(s.report().events.size(), 1u);
  EXPECT_EQ(s.report().events[0].group, "pose.theta");
  // Commands of the failed step are forgotten, so that the laws still apply.
  ASSERT_TRUE(s.step().ok());
}

TEST(Control, TheLawAppliesUntilTheFirstSet) {
  Simulator s = test::simulator(sample("four_bar:step=0.01"), "auto", {}, {"motor"});
  for (int k = 1; k <= 7; ++k) ASSERT_TRUE(s.step().ok());
  EXPECT_NEAR(s.output("B0.x"), 0.8 * std::cos(kOmega * s.time()), 8 * kEps);
  // The command replaces the law during the motion, without a jump.
  s.set("motor", kOmega * (s.time() + 0.01), kOmega);
  ASSERT_TRUE(s.step().ok());
  EXPECT_NEAR(s.output("B0.x"), 0.8 * std::cos(kOmega * s.time()), 8 * kEps);
}

TEST(Control, AFailedFirstCommandReturnsToTheLaw) {
  const Scene scene = test::limited_four_bar(Law::polynomial({0.5, 1}))
                          .measure("angle", AbsoluteAngle{"A0", "B"})
                          .time(0, 1, 0.01)
                          .build();
  Simulator s = test::simulator(scene, "groups/eigen", {}, {"motor"});
  s.set("motor", 2.5);
  EXPECT_EQ(s.step().code, Code::fold);
  ASSERT_TRUE(s.step().ok());
  EXPECT_NEAR(s.output("angle"), 0.5 + s.time(), 8 * kEps);
}

TEST(Control, StepsWithoutATimeGridTakeASecond) {
  SceneBuilder b("crank", 2);
  b.fixed_point("A", {0, 0}).point("B", {1, 0}).drive("motor", PointAngle{"A", "B", "", Law::constant(0)});
  Simulator s = test::simulator(b.build(), "auto", {}, {"motor"});
  for (const double angle : {0.5, -2.0, 7.0}) {
    const double before = s.time();
    s.set("motor", angle);
    ASSERT_TRUE(s.step().ok());
    EXPECT_EQ(s.time(), before + 1);
    EXPECT_NEAR(s.output("B.x"), std::cos(angle), 4 * kEps);
    EXPECT_NEAR(s.output("B.y"), std::sin(angle), 4 * kEps);
  }
}

TEST(Control, SavedStatesHaveTheTargetsThatWait) {
  Simulator s = test::simulator(sample("four_bar:step=0.01"), "auto", {}, {"motor"});
  const SimulatorState without = s.save();
  s.set("motor", 0.1);
  const SimulatorState with = s.save();
  for (int again = 0; again < 2; ++again) {
    s.restore(with);
    ASSERT_TRUE(s.step().ok());
    EXPECT_NEAR(s.output("B0.x"), 0.8 * std::cos(0.1), 4 * kEps);
    s.set("motor", 0.3);  // dropped by restore()
    s.restore(without);
    ASSERT_TRUE(s.step().ok());
    EXPECT_NEAR(s.output("B0.x"), 0.8 * std::cos(kOmega * s.time()), 8 * kEps);
  }
}

TEST(Control, DeadlineKeepsTheState) {
  Simulator s = test::simulator(sample("stewart"), "groups/eigen", {.seconds = 1e-9});
  const std::vector<double> before(s.outputs().begin(), s.outputs().end());
  const Status late = s.step(0.01);
  EXPECT_EQ(late.code, Code::deadline);
  EXPECT_EQ(s.report().status.code, Code::deadline);
  EXPECT_EQ(s.time(), 0);
  EXPECT_EQ(s.report().counters.steps, 0);
  EXPECT_EQ(before, std::vector<double>(s.outputs().begin(), s.outputs().end()));
  s.reset();  // not a step, so the deadline does not apply
  EXPECT_TRUE(s.report().status.ok());

  Simulator in_time = test::simulator(sample("stewart"), "groups/eigen", {.seconds = 100});
  EXPECT_TRUE(in_time.step(0.01).ok());
  EXPECT_EQ(in_time.time(), 0.01);
}

// A clock that ticks whenever it is read, so that a deadline of N s allows N packs to begin.
std::atomic<std::int64_t> ticks = 0;
std::chrono::steady_clock::time_point ticking() {
  return std::chrono::steady_clock::time_point(std::chrono::seconds(++ticks));
}

// Near a limit a step takes many attempts, chooses other redundant equations, locates the limit, and tries again.
TEST(Control, AllWorkOfACallSharesItsDeadline) {
  const test::DeltaRobot robot;
  const Prepared prepared = prepare(robot.scene(), {.strategy = "irreducible/eigen", .controlled = {"pose"}});
  const double lowest = robot.lowest(0, 0);
  int late = 0, ended = 0;
  for (int limit = 1; limit < 6000; limit += 1 + limit / 6) {
    SCOPED_TRACE(limit);
    Simulator s(prepared, {.seconds = static_cast<double>(limit)}), twin(prepared);
    for (Simulator* of : {&s, &twin}) {
      for (double z = robot.home; z > lowest + 4e-3; z -= 2e-3) {
        of->set("pose.z", z, -0.2);
        ASSERT_TRUE(of->step().arrived());
      }
    }
    SimulatorAccess::use_clock(s, &ticking);
    ticks = 0;
    const std::int64_t before = s.report().counters.group_solutions;
    s.set("pose.z", lowest - 1e-3, -0.2);
    const std::int64_t allocated = test::allocations();
    const Status status = s.step();
    EXPECT_EQ(test::allocations(), allocated);
    EXPECT_LE(s.report().counters.group_solutions - before, limit + 1);
    EXPECT_TRUE(status.code == Code::deadline || status.code == Code::fold) << name(status.code);
    ++(status.code == Code::deadline ? late : ended);
    EXPECT_EQ(s.time(), twin.time());
    EXPECT_TRUE(std::ranges::equal(s.outputs(), twin.outputs()));
  }
  EXPECT_GT(late, 5);
  EXPECT_GT(ended, 1);
}

// Errors are measured at the first steps. A deadline that leaves no time for it postpones the measurement; if this goes
// on, the accuracy is unknown.
TEST(Control, EstimatesOfErrorsShareTheDeadline) {
  Simulator s = test::simulator(sample("four_bar:loops=8,step=0.001"), "groups/eigen", {.seconds = 12});
  SimulatorAccess::use_clock(s, &ticking);
  for (int k = 0; k < 15; ++k) ASSERT_TRUE(s.step().ok()) << k;
  const Status unknown = s.step();
  EXPECT_EQ(unknown.code, Code::inaccurate);
  EXPECT_EQ(unknown.figure, HUGE_VAL);
  SimulatorAccess::use_clock(s, &std::chrono::steady_clock::now);
  EXPECT_TRUE(s.step().ok());
}

// The times of an event belong to one try of a step: here the driver moves at constant speed.
TEST(Control, TheTimeOfALimitIsThatOfTheFirstTry) {
  Simulator s = test::simulator(limited(), "groups/eigen", {}, {"motor"});
  const double limit = std::acos(0.04);
  double angle = 0.5;
  Status status;
  while (status.arrived()) {
    angle += 0.013;
    s.set("motor", angle, 1.3);
    status = s.step();
  }
  ASSERT_EQ(status.code, Code::fold);
  ASSERT_EQ(s.report().events.size(), 1u);
  for (const double overshoot : {0.0, 0.3}) {  // another command fails at another time
    if (overshoot > 0) {
      s.set("motor", s.output("angle") + overshoot, 0);
      EXPECT_EQ(s.step().code, Code::fold);
      ASSERT_EQ(s.report().events.size(), 1u);
    }
    const Event& e = s.report().events.back();
    EXPECT_LE(e.until - e.time, 1e-11);
    EXPECT_GE(e.time, s.time());
    EXPECT_LE(e.until, s.time() + 0.01);
    if (overshoot == 0) {
      EXPECT_NEAR(s.output("angle") + 1.3 * (e.time - s.time()), limit, 1e-9);
    }
  }
}

TEST(Control, StatusesSayWhichDriverOrQuantity) {
  const Scene stops = test::limited_four_bar(Law::constant(0.5))
                          .measure("angle", AbsoluteAngle{"A0", "B"})
                          .measure("reach", MeasuredDistance{"A0", "C"})
                          .limit("reach", 0.1, 5)
                          .limit("angle", 0.3, 0.9)
                          .time(0, 1, 0.01)
                          .build();
  Simulator s = test::simulator(stops, "groups/eigen", {}, {"motor"});
  s.set("motor", 1.1);
  const Status stopped = s.step();
  EXPECT_EQ(stopped.code, Code::limit_reached);
  EXPECT_EQ(stopped.where, Place::limit(1));
  EXPECT_EQ(stopped.figure, 0.9);
  EXPECT_EQ(s.name_of(stopped.where), "angle");
  EXPECT_EQ(s.limits(), (std::vector<std::string>{"reach", "angle"}));
  s.set("motor", HUGE_VAL);
  EXPECT_EQ(s.name_of(s.step().where), "motor");

  Simulator platform = test::simulator(sample("stewart"), "groups/eigen", {}, {"pose"});
  platform.set("pose.theta", kNan);
  const Status bad = platform.step();
  EXPECT_EQ(bad.where, Place::target(4));
  EXPECT_EQ(platform.name_of(bad.where), "pose.theta");
  EXPECT_EQ(platform.name_of({}), "");

  SceneBuilder b("points", 2);
  b.point("P", {0, 0}).drive("x", DrivenCoordinate{"P.x", Law::polynomial({0, 1})});
  b.drive("y", DrivenCoordinate{"P.y", Law::function([](double t) { return Motion{t < 0.05 ? 0 : kNan, 0, 0}; })});
  Simulator law = test::simulator(b.time(0, 1, 0.01).build());
  Status status;
  while (status.ok()) status = law.step();
  EXPECT_EQ(status.code, Code::not_finite);
  EXPECT_EQ(status.where, Place::driver(1));
  EXPECT_EQ(law.name_of(status.where), "y");
}

TEST(Control, StopsWithinAStepWhenAsked) {
  // A crank that turns at 1e9 rad/s divides a row of 0.01 s into millions of parts.
  const Scene scene = sample("four_bar:omega=1e9").with_time({0, 0.01, 0.01});
  int asked = 0;
  bool stops = true;
  Simulator s = test::simulator(scene, "irreducible/lanes", {.stop = [&] { return ++asked > 100 && stops; }});
  const Status status = s.step(0.01);
  EXPECT_EQ(status.code, Code::interrupted);
  EXPECT_EQ(s.report().status.code, Code::interrupted);
  EXPECT_EQ(asked, 101);
  EXPECT_GT(s.time(), 0);
  EXPECT_LT(s.time(), 0.01);
  stops = false;
  const double on = s.time() * 1.01;
  EXPECT_TRUE(s.step(on).ok());  // goes on
  EXPECT_EQ(s.time(), on);

  asked = 0;
  Simulator usual = test::simulator(sample("four_bar"), "irreducible/lanes", {.stop = [&] { return ++asked > 0; }});
  EXPECT_TRUE(usual.step(0.001).ok());  // not divided, so not asked
  EXPECT_EQ(asked, 0);
}

TEST(Control, IterationsAreExactBeyondTheFirstLevel) {
  const Scene scene = sample("four_bar:loops=4,step=0.001");
  for (const int n : {1, 2, 5}) {
    Simulator s = test::simulator(scene, "groups/eigen", {.iterations = n});
    const std::int64_t of_start = s.report().counters.newton_iterations;
    for (int k = 1; k <= 20; ++k) ASSERT_TRUE(s.step(0.001 * k).ok());
    // Loops 2, 3 and 4 take n iterations each; loop 1 takes as many as it needs.
    const std::int64_t rest = s.report().counters.newton_iterations - of_start - 20 * 3 * n;
    EXPECT_GE(rest, 0) << n;
    EXPECT_LE(rest, 2 * 20) << n;
    EXPECT_EQ(s.report().counters.rejected, 0);
    EXPECT_LE(s.report().error.position, 1e-14);
  }
}

}  // namespace
}  // namespace assur
