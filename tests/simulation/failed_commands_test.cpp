// Nothing of a command that failed survives: neither a target, nor a rate, nor a trace in the numbers of later steps.
// It allocates no memory.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "assur/saved_plan.hpp"
#include "backends/allocations.hpp"
#include "motion/limited.hpp"
#include "properties/delta_robot.hpp"
#include "properties/random_count.hpp"
#include "properties/small_random_scenes.hpp"
#include "simulation/run.hpp"

namespace assur {
namespace {

using test::Draw;

std::vector<double> row_of(const Simulator& s) { return {s.outputs().begin(), s.outputs().end()}; }

// True for a value, false for a rate or an acceleration.
bool is_value(const std::string& column) {
  const std::string part = column.substr(column.rfind('.') + 1);
  return part.size() == 1 || part == "value" || column.find('.') == std::string::npos;
}

// What the next steps depend on, as far as it can be seen.
void expect_same_state(Simulator& a, Simulator& b) {
  EXPECT_EQ(a.time(), b.time());
  EXPECT_EQ(row_of(a), row_of(b));
  EXPECT_EQ(a.jacobian().values, b.jacobian().values);
}

// A platform on three legs whose lengths are driven; the third leg pulls from above.
Scene three_legs(double period = 0) {
  SceneBuilder b("three_legs", 2);
  b.fixed_point("A", {0, 0}).fixed_point("B", {3, 1.1}).fixed_point("C", {1.5, 3});
  b.point("P", {1, 1.2}).point("Q", {2, 1.1}).point("R", {1.5, 1.9});
  b.constrain("PQ", Distance{"P", "Q", std::nullopt}).constrain("QR", Distance{"Q", "R", std::nullopt});
  b.constrain("RP", Distance{"R", "P", std::nullopt});
  const auto leg = [&](double x, double y, double amplitude) {
    return period > 0 ? Law::harmonics({{amplitude, 1 / period, 0}}, std::hypot(x, y))
                      : Law::constant(std::hypot(x, y));
  };
  b.drive("a", DrivenDistance{"A", "P", leg(1, 1.2, 0.05)});
  b.drive("b", DrivenDistance{"B", "Q", leg(1, 0, -0.04)});
  b.drive("c", DrivenDistance{"C", "R", leg(0, 1.1, 0.06)});
  b.measure("turn", AbsoluteAngle{"P", "Q"});
  return b.time(0, 1, 0.01).build();
}

Scene slow_four_bar() {
  return test::limited_four_bar(Law::constant(0.5)).measure("angle", AbsoluteAngle{"A0", "B"}).time(0, 1, 0.01).build();
}

Prepared loaded(const Prepared& prepared) {
  std::stringstream file;
  save_plan(file, prepared);
  return load_plan(file);
}

// A mechanism with drivers at rest, and a target of one driver that is out of reach.
struct Case {
  Scene scene;
  std::string driver;  // as in the scene
  std::string set;     // as in set()
  double near, far;
};
std::vector<Case> cases() {
  return {{slow_four_bar(), "motor", "motor", 0.55, 2.5},
          {three_legs(), "a", "a", std::hypot(1, 1.2) + 0.01, 9},
          {three_legs(), "b", "b", 0.99, -1},  // a length that vanishes on the way
          {test::DeltaRobot{}.scene(), "pose", "pose.z", -0.62, -2},
          {sample("stewart"), "pose", "pose.z", 0.56, 3}};
}

TEST(FailedCommands, LeaveNoTargetBehind) {
  for (const Case& c : cases()) {
    const Prepared prepared = prepare(c.scene, {.strategy = "irreducible/eigen", .controlled = {c.driver}});
    for (const Prepared& plan : {prepared, loaded(prepared)}) {
      for (const bool first : {true, false}) {
        for (const bool to_time : {true, false}) {
          SCOPED_TRACE(c.scene.name() + " " + c.set + (plan.scene() != nullptr ? "" : ", loaded") +
                       (first ? ", first" : "") + (to_time ? ", step(t)" : ""));
          Simulator s(plan), twin(plan);
          const double h = c.scene.time().step;
          if (!first) {
            for (Simulator* of : {&s, &twin}) {
              of->set(c.set, c.near);
              ASSERT_TRUE(of->step().arrived());
            }
          }
          s.set(c.set, c.far);
          ASSERT_FALSE((to_time ? s.step(s.time() + h) : s.step()).arrived());
          if (!to_time) {
            expect_same_state(s, twin);
            ASSERT_TRUE(s.step().arrived());
            ASSERT_TRUE(twin.step().arrived());
            expect_same_state(s, twin);
            ASSERT_TRUE(s.step(s.time() + h).arrived());
            ASSERT_TRUE(twin.step(twin.time() + h).arrived());
            expect_same_state(s, twin);
          } else if (c.scene.name() != "stewart") {  // whose other drivers follow laws
            const std::vector<double> there = row_of(s);
            const double until = s.time() + h;
            ASSERT_TRUE(s.step(until).arrived());
            for (std::size_t i = 0; i < there.size(); ++i) {
              const std::string& column = s.columns()[i];
              if (!is_value(column)) continue;
              EXPECT_NEAR(s.outputs()[i], there[i], 1e-7) << column;  // close to a fold
            }
          }
        }
      }
    }
  }
}

// Nor does the first command of a simulator.
TEST(FailedCommands, AllocateNothing) {
  std::vector<Case> all = cases();
  const Scene stops = test::limited_four_bar(Law::constant(0.5))
                          .measure("angle", AbsoluteAngle{"A0", "B"})
                          .limit("angle", 0.3, 0.9)
                          .time(0, 1, 0.01)
                          .build();
  all.push_back({stops, "motor", "motor", 0.55, 1.1});
  for (const std::string strategy :
       {"auto", "groups/lanes:8", "irreducible/eigen", "global/eigen+predict=past:3", "irreducible/eigen 2x1"}) {
    for (const Case& c : all) {
      const Prepared prepared =
          prepare(c.scene, {.strategy = strategy, .controlled = {c.driver}, .budget = ThreadBudget{2}});
      for (const Prepared& plan : {prepared, loaded(prepared)}) {
        for (const bool near_first : {false, true}) {
          for (const bool to_time : {true, false}) {
            SCOPED_TRACE(c.scene.name() + " " + c.set + " " + strategy + (plan.scene() != nullptr ? "" : ", loaded") +
                         (near_first ? "" : ", first") + (to_time ? ", step(t)" : ""));
            Simulator s(plan);
            const double h = c.scene.time().step;
            for (int k = near_first ? 0 : 1; k < 5; ++k) {
              const double rate = k == 3 ? (c.far - c.near) / h : 0;  // such a step is tried again from rest
              s.set(c.set, k == 0 ? c.near : c.far, rate);
              const std::int64_t before = test::allocations();
              const Status status = to_time ? s.step(s.time() + h) : s.step();
              EXPECT_EQ(test::allocations() - before, 0) << k << " " << name(status.code);
              EXPECT_EQ(status.arrived(), k == 0) << k;
            }
            EXPECT_FALSE(s.report().events.empty());
          }
        }
      }
    }
  }
}

// A time that is not finite fails like any other command.
TEST(FailedCommands, IncludeStepsToNoTime) {
  for (const double bad : {kNan, HUGE_VAL, -HUGE_VAL}) {
    Simulator s = test::simulator(slow_four_bar(), "groups/eigen", {}, {"motor"});
    s.set("motor", 0.6);
    EXPECT_EQ(s.step(bad).code, Code::not_finite);
    ASSERT_TRUE(s.step(0.02).ok());
    EXPECT_NEAR(s.output("angle"), 0.5, 4 * kEps);
  }
}

// After step(t) has failed, all drivers rest, also if it failed before it moved anything: a driver that was not stopped
// would swing beyond its value, and back.
TEST(FailedCommands, StopMovingDrivers) {
  const Scene scene = test::limited_four_bar(Law::constant(0.5))
                          .measure("angle", AbsoluteAngle{"A0", "B"})
                          .limit("angle", -3, 0.601, Limit::Reaction::flag)
                          .time(0, 1, 0.01)
                          .build();
  for (const double bad : {kNan, 2.5}) {
    Simulator s = test::simulator(scene, "groups/eigen", {}, {"motor"});
    s.set("motor", 0.6, 5);
    ASSERT_TRUE(s.step().ok());
    s.set("motor", bad, 5);
    ASSERT_FALSE(s.step(s.time() + 0.01).arrived());
    const double there = s.output("angle");
    const std::size_t events = s.report().events.size();
    for (int k = 0; k < 2; ++k) {
      ASSERT_TRUE(s.step().ok());
      EXPECT_NEAR(s.output("angle"), there, 1e-12);
      EXPECT_EQ(s.output("angle.rate"), 0);
    }
    EXPECT_EQ(s.report().events.size(), events);
  }
}

// ---- exceptions and other ends within a step

// The function `calls` counts how often functions of the program are called, and throws at one of the calls.
struct Failing {
  struct Thrown {};
  int calls = 0, at = -1;

  void call() {
    if (calls++ == at) throw Thrown();
  }
};

// The four-bar with a rocker of the program, and a slow point whose law is a function of the program.
Scene with_functions(Failing* failing) {
  SceneBuilder b("functions", 2);
  b.fixed_point("A", {0, 0}).fixed_point("D", {2, 0}).point("B", {0.8, 0}).point("C", {1.6, 1.2}).point("E", {1, 2});
  b.constrain("coupler", Distance{"B", "C", 1.8});
  Callback rocker{{"C.x", "C.y"}, 1, {}, {}, {}};
  rocker.residual = [failing](auto p, auto phi) {
    failing->call();
    phi[0] = (p[0] - 2) * (p[0] - 2) + p[1] * p[1] - 1.69;
  };
  rocker.jacobian = [failing](auto p, auto j) {
    failing->call();
    j[0] = 2 * (p[0] - 2);
    j[1] = 2 * p[1];
  };
  rocker.curvature = [failing](auto, auto v, auto c) {
    failing->call();
    c[0] = 2 * (v[0] * v[0] + v[1] * v[1]);
  };
  b.constrain("rocker", rocker);
  const auto law = [failing](double from, double rate) {
    return Law::function([=](double t) {
      failing->call();
      return Motion{from + rate * t, rate, 0};
    });
  };
  b.drive("motor", PointAngle{"A", "B", "", law(0, 0.5)});
  b.drive("x", DrivenCoordinate{"E.x", law(1, 0.1)}).drive("y", DrivenCoordinate{"E.y", law(2, 0)});
  return b.time(0, 1, 0.01).build();
}

// Throws at each call of a step in turn: while the step begins, within its parts, and while its errors are estimated.
TEST(FailedCommands, MayEndByAnExceptionAnywhere) {
  Failing failing;
  const Prepared prepared =
      prepare(with_functions(&failing), {.strategy = "irreducible/eigen", .controlled = {"motor", "x"}});
  for (const double target : {0.02, 2.0}) {  // the second one divides the step
    for (const int steps : {0, 3, 16}) {     // functions are checked and errors estimated at some steps
      for (const bool was_set : {false, true}) {
        for (const bool to_time : {false, true}) {
          SCOPED_TRACE(std::to_string(target) + " after " + std::to_string(steps) + (was_set ? " set" : "") +
                       (to_time ? " step(t)" : ""));
          if (steps == 0 && was_set) continue;
          failing = {};
          Simulator s(prepared), twin(prepared);
          for (Simulator* of : {&s, &twin}) {
            if (was_set) of->set("motor", 0.01, 0.7);
            for (int k = 0; k < steps; ++k) ASSERT_TRUE(of->step().arrived());
          }
          const SimulatorState before = s.save();
          (void)twin.save();
          int thrown = 0, last = 0;
          for (int call = 0; call == 0 || failing.calls >= call; call += call < 60 ? 1 : 1 + call / 16) {
            s.restore(before);
            const double was = s.output("E.x");
            failing = {0, call};
            s.set("motor", target, 1);
            s.set("x", 1.5, 0.2);
            try {
              ASSERT_TRUE((to_time ? s.step(s.time() + 0.01) : s.step()).arrived());
              continue;  // no call is left, or a check of functions takes the exception for a point without a value
            } catch (const Failing::Thrown&) {
              ++thrown;
              last = call;
            }
            failing.at = -1;
            if (to_time) {
              const double angle = std::atan2(s.output("B.y"), s.output("B.x")), x = s.output("E.x");
              const bool begun = s.output("E.x") != was || s.time() != before.time();
              ASSERT_TRUE(s.step(s.time() + 1e-3).arrived());
              const double now = std::atan2(s.output("B.y"), s.output("B.x"));
              if (begun) {
                ASSERT_NEAR(now, angle, 1e-14) << call;
                ASSERT_NEAR(s.output("E.x"), x, 1e-14) << call;
              } else {  // drivers that have never been set follow their laws, others rest
                ASSERT_LE(std::abs(now - angle), 0.5001e-3) << call;
                ASSERT_LE(std::abs(s.output("E.x") - x), 0.1001e-3) << call;
              }
            } else {
              expect_same_state(s, twin);
              if (testing::Test::HasFailure()) FAIL() << "call " << call;
            }
          }
          EXPECT_GT(thrown, 10);
          if (!to_time) {  // the next step equals that of the twin
            s.restore(before);
            failing = {0, last};
            s.set("motor", target, 1);
            s.set("x", 1.5, 0.2);
            EXPECT_THROW((void)s.step(), Failing::Thrown);
            failing = {};
            for (Simulator* of : {&s, &twin}) ASSERT_TRUE(of->step().arrived());
            expect_same_state(s, twin);
          }
        }
      }
    }
  }
}

// The law throws while a change point is passed, at each call in turn.
TEST(FailedCommands, MayEndByAnExceptionAtAChangePoint) {
  Failing failing;
  SceneBuilder b("parallelogram", 2);
  b.fixed_point("A", {0, 0}).fixed_point("D", {2, 0}).point("B", {std::cos(0.5), std::sin(0.5)});
  b.point("C", {2 + std::cos(0.5), std::sin(0.5)});
  b.constrain("coupler", Distance{"B", "C", 2}).constrain("rocker", Distance{"D", "C", 1});
  b.drive("motor", PointAngle{"A", "B", "", Law::function([&](double t) {
                                failing.call();
                                return Motion{0.5 - t, -1, 0};
                              })});
  Simulator s = test::simulator(b.time(0, 0.9, 0.45).build(), "groups/eigen");
  ASSERT_TRUE(s.step().arrived());
  const SimulatorState before = s.save();
  int thrown = 0, calls = 0;
  for (int call = 0;; call += 7) {
    s.restore(before);
    failing = {0, call};
    try {
      ASSERT_TRUE(s.step().arrived());
      calls = failing.calls;
      break;
    } catch (const Failing::Thrown&) {
      ++thrown;
    }
    failing = {};
    ASSERT_EQ(s.time(), before.time());
    ASSERT_TRUE(s.step().arrived()) << call;
    ASSERT_NEAR(s.output("C.x"), 2 + std::cos(0.4), 1e-9) << call;
  }
  EXPECT_EQ(s.report().events.back().kind, Code::change_point_passed);
  EXPECT_GT(thrown, 20);
  EXPECT_GT(calls, 20);
}

TEST(FailedCommands, MayBeLateOrInterrupted) {
  for (const bool late : {true, false}) {
    for (const bool to_time : {true, false}) {
      SCOPED_TRACE(std::string(late ? "deadline" : "interrupted") + (to_time ? ", step(t)" : ""));
      bool stops = false;
      StepSettings settings;
      if (late) settings.seconds = 1e-9;
      if (!late) settings.stop = [&] { return stops; };
      const Prepared prepared = prepare(slow_four_bar(), {.strategy = "groups/eigen", .controlled = {"motor"}});
      Simulator s(prepared, settings), twin(prepared);
      stops = true;
      s.set("motor", -3, 1);
      EXPECT_EQ((to_time ? s.step(0.01) : s.step()).code, late ? Code::deadline : Code::interrupted);
      stops = false;
      if (!to_time) expect_same_state(s, twin);
      const double there = s.output("angle");
      s.set("motor", there, 0);
      Simulator on(prepared);
      on.restore(s.save());
      on.set("motor", there, 0);
      ASSERT_TRUE(on.step().arrived());  // the target set last, not the rejected one
      EXPECT_NEAR(on.output("angle"), there, 1e-14);
    }
  }
}

// ---- random commands across the border

struct Robot {
  Prepared prepared;
  std::vector<std::string> drivers;
  std::vector<double> home;  // values of the drivers at the start
  double size;               // of usual moves
};

Robot robot(const Scene& scene, std::vector<std::string> controlled, std::vector<double> home, double size,
            const std::string& strategy, bool saved) {
  Prepared prepared = prepare(scene, {.strategy = strategy, .controlled = std::move(controlled)});
  if (saved) prepared = loaded(prepared);
  Robot out{prepared, Simulator(prepared).drivers(), std::move(home), size};
  return out;
}

std::vector<Robot> robots(const std::string& strategy, bool saved) {
  const test::DeltaRobot delta;
  const Scene legs = three_legs();
  const std::vector<double> lengths = {std::hypot(1, 1.2), 1, 1.1};
  const Scene stops = test::limited_four_bar(Law::constant(0.5))
                          .measure("angle", AbsoluteAngle{"A0", "B"})
                          .limit("angle", 0.3, 0.9)
                          .time(0, 1, 0.01)
                          .build();
  return {robot(slow_four_bar(), {"motor"}, {0.5}, 0.05, strategy, saved),
          robot(stops, {"motor"}, {0.5}, 0.05, strategy, saved),
          robot(legs, {"a", "b", "c"}, lengths, 0.02, strategy, saved),
          robot(three_legs(0.7), {"b"}, {lengths[1]}, 0.02, strategy, saved),  // the other legs follow laws
          robot(delta.scene(), {"pose"}, {0, 0, delta.home, 0, 0, 0}, 0.01, strategy, saved)};
}

struct Command {
  std::vector<std::pair<std::size_t, Motion>> targets;
  double until = kNan;  // NaN: step()
};

Status give(Simulator& s, const Robot& robot, const Command& command) {
  for (const auto& [driver, m] : command.targets) {
    s.set(robot.drivers[driver], m.value, m.rate, m.acceleration);
  }
  return std::isnan(command.until) ? s.step() : s.step(command.until);
}

// Sends random commands to a simulator, and to its twin those that succeed.
struct Search {
  Draw draw;
  int failed = 0, failed_on_the_way = 0, arrived = 0, compared = 0, renewed = 0, wound = 0;

  Command command(const Robot& robot, const std::vector<double>& at, double now, double step) {
    Command c;
    const std::size_t kind = draw.below(20);
    const bool is_bad = kind == 0;                                             // a number that is not finite
    const double jump = kind < 3 ? 30 : kind < 5 ? 300 : kind < 7 ? 1e-6 : 1;  // far, out of reach, tiny
    const bool turns = robot.drivers.size() == 6;                              // of a pose: small
    for (std::size_t i = 0; i < at.size(); ++i) {
      if (draw.below(4) == 0 || (turns && i >= 3 && draw.below(8) != 0)) continue;
      Motion m{at[i] + jump * draw.real(-1, 1) * robot.size, 0, 0};
      if (draw.below(3) == 0) m.rate = draw.real(-1, 1) * robot.size / step;
      if (draw.below(8) == 0) m.acceleration = draw.real(-1, 1) * robot.size / (step * step);
      if (is_bad && draw.maybe()) (draw.maybe() ? m.value : draw.maybe() ? m.rate : m.acceleration) = kNan;
      c.targets.emplace_back(i, m);
    }
    const std::size_t mode = draw.below(10);
    if (mode < 3) c.until = now + step * (mode == 0 ? draw.real(0.1, 3) : 1);
    if (mode == 3) c.until = now - step * draw.real(0.1, 1);
    if (draw.below(40) == 0) c.until = HUGE_VAL;
    return c;
  }

  void run(const Robot& robot, int cycles, bool solver_has_no_memory) {
    Simulator s(robot.prepared), twin(robot.prepared);
    std::vector<double> at = robot.home;
    const double step = robot.prepared.time().step;
    SimulatorState state = s.save();
    std::int64_t before = 0;
    const auto same_pivots = [&] {
      const std::int64_t now = s.report().effort.renewed + twin.report().effort.renewed;
      return std::exchange(before, now) == now;
    };
    for (int k = 0; k < cycles; ++k) {
      const Command c = command(robot, at, s.time(), step);
      const std::int64_t allocated = test::allocations();
      const Status status = give(s, robot, c);
      const std::int64_t more = test::allocations() - allocated;
      if (solver_has_no_memory) {  // `lanes` may choose pivots
        ASSERT_EQ(more, 0) << k << " " << name(status.code);
      }
      if (status.arrived()) {
        ++arrived;
        const Status of_twin = give(twin, robot, c);
        ASSERT_EQ(of_twin.code, status.code) << k;
        for (const auto& [driver, m] : c.targets) at[driver] = m.value;
      } else if (std::isnan(c.until)) {
        ++failed;
      } else {
        ++failed_on_the_way;
        // The next target is reached at the same time, if it can be reached from there.
        Command home;
        home.until = twin.time() + step;
        if (home.until == s.time()) home.until += step;
        for (std::size_t i = 0; i < at.size(); ++i) home.targets.emplace_back(i, Motion{robot.home[i], 0, 0});
        twin.save(state);
        const bool both = give(s, robot, home).arrived() && give(twin, robot, home).arrived();
        if (!both) {
          twin.restore(state);
          s.restore(state);
        } else {
          ++compared;
          at = robot.home;
          // The last bits of a posture are those of the equations; rates grow with the condition of the Jacobian.
          double fastest = 1;
          for (const double x : twin.outputs()) fastest = std::max(fastest, std::abs(x));
          for (std::size_t i = 0; i < s.outputs().size(); ++i) {
            const double value = twin.outputs()[i];
            const double most = is_value(s.columns()[i]) ? 1e-12 * std::max(1.0, std::abs(value)) : 1e-9 * fastest;
            // The other way may wind an arm round its axis, as in 1 of 10,000 ways home; small steps say the same.
            const bool is_angle = s.columns()[i].find('.') == std::string::npos;
            const double turns = is_angle ? std::round((s.outputs()[i] - value) / (2 * std::numbers::pi)) : 0;
            wound += turns != 0 ? 1 : 0;
            ASSERT_NEAR(s.outputs()[i] - turns * 2 * std::numbers::pi, value, most) << k << " " << s.columns()[i];
          }
          s.save(state);
          s.restore(state);
          twin.restore(state);
        }
      }
      ASSERT_EQ(s.time(), twin.time()) << k;
      if (same_pivots()) {
        ASSERT_EQ(row_of(s), row_of(twin)) << k << " " << name(status.code);
        if (k % 8 == 0 && solver_has_no_memory) {  // `lanes` keeps the pivots of its first matrix
          ASSERT_EQ(s.jacobian().values, twin.jacobian().values) << k;
        }
        continue;
      }
      ++renewed;  // last bits may differ from now on
      s.save(state);
      for (Simulator* of : {&s, &twin}) {
        *of = Simulator(robot.prepared);
        of->restore(state);
      }
      before = 0;
    }
  }
};

TEST(FailedCommands, LeaveTheBitsOfATwin) {
  const int cycles = test::random_count(200);
  Search search{Draw(50)};
  for (const bool saved : {false, true}) {
    for (const std::string strategy : {"irreducible/eigen", "irreducible/lanes", "global/eigen+predict=past:3"}) {
      for (const Robot& r : robots(strategy, saved)) {
        SCOPED_TRACE(r.prepared.name() + " " + strategy + (saved ? ", loaded" : ""));
        search.run(r, cycles, strategy.find("eigen") != std::string::npos);
        if (HasFatalFailure()) return;
      }
    }
  }
  RecordProperty("arrived", search.arrived);
  RecordProperty("failed", search.failed);
  RecordProperty("failed_on_the_way", search.failed_on_the_way);
  RecordProperty("compared", search.compared);
  RecordProperty("renewed", search.renewed);
  RecordProperty("wound", search.wound);
  EXPECT_GT(search.failed, 2 * cycles);
  EXPECT_GT(search.arrived, 10 * cycles);
  EXPECT_GT(search.compared, cycles);
  EXPECT_LE(search.wound, search.compared / 1000);
}

}  // namespace
}  // namespace assur
