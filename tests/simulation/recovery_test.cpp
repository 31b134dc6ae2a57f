// A simulator remains usable after a failed command.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "backends/allocations.hpp"
#include "files/shipped_files.hpp"
#include "motion/limited.hpp"
#include "properties/delta_robot.hpp"
#include "properties/random_count.hpp"
#include "properties/small_random_scenes.hpp"
#include "simulation/run.hpp"

namespace assur {
namespace {

// The platform is lowered until two or three arms are stretched, and lifted again. The chosen set of redundant
// equations becomes singular in stretched postures, and another set is chosen.
TEST(Recovery, ADeltaRobotReturnsFromItsLimit) {
  const test::DeltaRobot robot;
  for (const std::string strategy : {"irreducible/eigen", "global/eigen", "irreducible/lanes"}) {
    for (const double x : {0.0, 0.05, 0.1}) {
      for (const double down : {0.001, 0.002, 0.005}) {
        SCOPED_TRACE(strategy + " x " + std::to_string(x) + " by " + std::to_string(down));
        Simulator s = test::simulator(robot.scene(), strategy, {}, {"pose"});
        double z = robot.home;
        Status status;
        for (int k = 0; k < 1000 && status.ok(); ++k) {
          z -= down;
          s.set("pose.x", x);
          s.set("pose.z", z);
          status = s.step();
        }
        EXPECT_EQ(status.code, Code::fold);
        const double lowest = std::max({robot.lowest(0, x), robot.lowest(1, x), robot.lowest(2, x)});
        EXPECT_LT(z, lowest);
        EXPECT_GE(z, lowest - down);
        for (int k = 1; k <= 50; ++k) {
          s.set("pose.x", x);
          s.set("pose.z", z + k * down);
          const Status back = s.step();
          ASSERT_TRUE(back.arrived()) << k << " " << name(back.code) << " " << back.figure;
          EXPECT_NEAR(s.output("O.z"), z + k * down, 2 * kEps);
          const double away = z + k * down - lowest, sigma = std::sqrt(away);  // about the sine between arm and rods
          for (int arm = 0; arm < 3; ++arm) {
            const std::string elbow = "B" + std::to_string(arm);
            const Triple at = robot.elbow(arm, x, z + k * down);
            EXPECT_NEAR(s.output(elbow + ".x"), at[0], 64 * kEps / sigma);
            EXPECT_NEAR(s.output(elbow + ".y"), at[1], 64 * kEps / sigma);
            EXPECT_NEAR(s.output(elbow + ".z"), at[2], 64 * kEps / sigma);
          }
        }
      }
    }
  }
}

// A driver that can be set, with its start value.
struct Lever {
  std::string name;
  double value;
};
std::vector<Lever> levers(const Scene& scene) {
  const double t = scene.time().start;
  std::vector<Lever> all;
  for (const Driver& d : scene.drivers()) {
    const auto add_one = [&](const Law& law) { all.push_back({d.name, law(t).value}); };
    if (const auto* pose = std::get_if<Pose>(&d.kind)) {
      const std::vector<std::string> space = {"x", "y", "z", "psi", "theta", "phi"}, plane = {"x", "y", "angle"};
      const auto& parts = scene.dimension() == 3 ? space : plane;
      std::size_t k = 0;
      for (const Law& law : pose->translation) all.push_back({d.name + "." + parts[k++], law(t).value});
      for (const Law& law : pose->rotation) all.push_back({d.name + "." + parts[k++], law(t).value});
    }
    if (const auto* angle = std::get_if<PointAngle>(&d.kind)) add_one(angle->law);
    if (const auto* angle = std::get_if<RelativeAngle>(&d.kind)) add_one(angle->law);
    if (const auto* distance = std::get_if<DrivenDistance>(&d.kind)) add_one(distance->law);
    if (const auto* coordinate = std::get_if<DrivenCoordinate>(&d.kind)) add_one(coordinate->law);
  }
  return all;
}

std::vector<std::string> all_drivers(const Scene& scene) {
  std::vector<std::string> names;
  for (const Driver& d : scene.drivers()) names.push_back(d.name);
  return names;
}

std::vector<double> row_of(const Simulator& s) { return {s.outputs().begin(), s.outputs().end()}; }

std::vector<Scene> shipped() {
  std::vector<Scene> all;
  for (const auto& file : test::shipped_files()) all.push_back(read_scene(file));
  for (const std::string text :
       {"n_four_bar:2", "whitworth", "bricard", "parallelograms:2", "rings:legs=2,n=12,terminal=12"}) {
    all.push_back(sample(text));
  }
  all.push_back(test::DeltaRobot{}.scene());
  all.push_back(test::limited_four_bar(Law::constant(0.5)).time(0, 1, 0.01).build());
  return all;
}

// Moves each mechanism across its limits. One simulator gets all commands, the other one only the commands that
// succeeded. Both agree bitwise, so failed commands leave no trace. Last bits may differ if the solver of one of them
// has chosen another pivot order.
TEST(Recovery, FailedCommandsLeaveNoTrace) {
  test::Draw draw(16);
  const std::vector<Scene> scenes = shipped();
  const int steps = test::random_count(400);
  int failed = 0, done = 0;
  for (int round = 0; done < steps; ++round) {
    for (const Scene& scene : scenes) {
      const std::string strategy = round % 2 == 0 ? "irreducible/eigen" : "irreducible/lanes";
      SCOPED_TRACE(scene.name() + " " + strategy + " round " + std::to_string(round));
      const Prepared prepared = prepare(scene, {.strategy = strategy, .controlled = all_drivers(scene)});
      Simulator every(prepared), successful(prepared);
      std::vector<Lever> at = levers(scene);
      const double size = std::pow(10, draw.real(-3, -0.5));
      std::vector<double> heading(at.size());
      // Gough's machine has one group of many unknowns, whose failed steps take a second each.
      const int most = scene.name() == "gough" ? 8 : 40, commands = std::min(test::random_count(most), most);
      for (int k = 0; k < commands; ++k, ++done) {
        if (k % 10 == 0) {
          for (double& h : heading) h = draw.maybe() ? draw.real(-size, size) : 0;
        }
        const double jump = draw.below(20) == 0 ? 30 : 1, rate = draw.below(3) == 0 ? 1 / scene.time().step : 0;
        const SimulatorState before = successful.save();
        for (std::size_t i = 0; i < at.size(); ++i) {
          for (Simulator* s : {&every, &successful}) {
            s->set(at[i].name, at[i].value + jump * heading[i], rate * jump * heading[i]);
          }
        }
        const Status status = every.step(), without = successful.step();
        ASSERT_EQ(status.code, without.code) << k;
        if (!status.arrived()) {
          ++failed;
          successful = Simulator(prepared);  // a new simulator, which never got the failed command
          successful.restore(before);
          for (double& h : heading) h = -h;
        } else {
          for (std::size_t i = 0; i < at.size(); ++i) at[i].value += jump * heading[i];
        }
        ASSERT_EQ(every.time(), successful.time()) << k;
        const std::vector<double> row = row_of(every), other = row_of(successful);
        if (every.report().effort.renewed + successful.report().effort.renewed == 0) {
          ASSERT_EQ(row, other) << k;
          continue;
        }
        for (std::size_t i = 0; i < row.size() && status.ok(); ++i) {
          ASSERT_NEAR(row[i], other[i], kDoubtfulError * std::max(1.0, std::abs(row[i]))) << k;
        }
        successful.restore(every.save());
      }
    }
  }
  EXPECT_GT(failed, done / 100);
}

// A restored simulator continues bitwise, with past postures, kept factors or a required accuracy.
TEST(Recovery, SavedStatesContinueIdentically) {
  struct Case {
    Scene scene;
    std::string strategy;
    double accuracy;
  };
  const Scene turning = sample("four_bar:loops=2,step=0.01,steps=400"), delta = test::DeltaRobot{}.scene();
  for (const Case& c : {Case{turning, "irreducible/lanes", 0}, Case{turning, "groups/eigen+predict=past:3", 1e-8},
                        Case{turning, "global/" + test::sparse() + "+reuse=run", 0},
                        Case{turning, "irreducible/eigen", 1e-6}, Case{sample("stewart"), "irreducible/lanes", 1e-6}}) {
    SCOPED_TRACE(c.scene.name() + " " + c.strategy);
    const Prepared prepared = prepare(c.scene, {.strategy = c.strategy, .accuracy = c.accuracy});
    Simulator s(prepared), other(prepared);
    for (int k = 0; k < 123; ++k) ASSERT_TRUE(s.step().arrived());
    SimulatorState state;
    EXPECT_TRUE(state.empty());
    s.save(state);
    EXPECT_EQ(state.time(), s.time());
    const SimulatorState copy = state;
    const std::vector<double> here = row_of(s);
    std::vector<std::vector<double>> rows;
    for (int k = 0; k < 150; ++k) {
      ASSERT_TRUE(s.step().arrived());
      rows.push_back(row_of(s));
    }
    for (int again = 0; again < 3; ++again) {
      Simulator& at = again == 2 ? other : s;
      at.restore(again == 0 ? state : copy);
      EXPECT_EQ(at.time(), state.time());
      EXPECT_EQ(row_of(at), here);
      for (const std::vector<double>& row : rows) {
        ASSERT_TRUE(at.step().arrived());
        ASSERT_EQ(row_of(at), row);
      }
    }
  }
}

TEST(Recovery, SavesReselectedEquations) {
  const test::DeltaRobot robot;
  const Prepared prepared = prepare(robot.scene(), {.strategy = "irreducible/eigen", .controlled = {"pose"}});
  Simulator s(prepared);
  const SimulatorState start = s.save();
  const double x = 0.05, lowest = std::max(robot.lowest(1, x), robot.lowest(0, x));
  const auto move = [&](Simulator& of, double z) {
    of.set("pose.x", x);
    of.set("pose.z", z);
    return of.step();
  };
  ASSERT_TRUE(move(s, robot.home).arrived());
  const SimulatorState home = s.save();
  for (double z = robot.home; z > lowest + 1e-3; z -= 0.004) ASSERT_TRUE(move(s, z).arrived());
  const SimulatorState low = s.save();
  const std::vector<double> row = row_of(s);
  EXPECT_EQ(move(s, lowest - 1e-3).code, Code::fold);
  EXPECT_EQ(row_of(s), row);
  Simulator other(prepared);
  for (Simulator* of : {&s, &other}) {
    of->restore(home);
    ASSERT_TRUE(move(*of, robot.home - 0.01).arrived());
    of->restore(low);
    EXPECT_EQ(row_of(*of), row);
    ASSERT_TRUE(move(*of, lowest + 5e-3).arrived());
    EXPECT_NEAR(of->output("O.z"), lowest + 5e-3, 2 * kEps);
    for (int arm = 0; arm < 3; ++arm) {
      EXPECT_NEAR(of->output("B" + std::to_string(arm) + ".z"), robot.elbow(arm, x, lowest + 5e-3)[2], 1e-14 / 0.07);
    }
  }
  s.restore(start);
  EXPECT_EQ(s.time(), 0);
}

// A failed step to a given time keeps the last good posture on the way, which is close to the limit here.
TEST(Recovery, RetreatsToAReachablePosture) {
  const Scene scene = test::limited_four_bar(Law::polynomial({0.5, 1})).time(0, 2, 0.01).build();
  for (const std::string strategy : {"irreducible/lanes", "global/eigen", "groups/eigen+predict=past:3"}) {
    SCOPED_TRACE(strategy);
    Simulator s = test::simulator(scene, strategy), as_far(s.prepared());
    s.retreat();
    EXPECT_EQ(s.time(), 0);
    Status status;
    for (int k = 1; status.arrived(); ++k) status = s.step(0.01 * k);
    ASSERT_EQ(status.code, Code::fold);
    const double limit = std::acos(0.04) - 0.5, there = s.time();
    EXPECT_NEAR(there, limit, 1e-6);
    s.retreat();
    const double back = s.time();
    EXPECT_LT(back, there - 0.005);
    EXPECT_GT(back, there - 0.2);
    // The posture equals the posture of a simulator that stopped at the same time.
    for (int k = 1; as_far.time() < back; ++k) ASSERT_TRUE(as_far.step(0.01 * k).arrived());
    EXPECT_EQ(as_far.time(), back);
    EXPECT_EQ(row_of(s), row_of(as_far));
    EXPECT_EQ(as_far.report().counters.rejected, 0);
    ASSERT_TRUE(s.step(back - 0.01).arrived());
    ASSERT_TRUE(as_far.step(back - 0.01).arrived());
    EXPECT_EQ(row_of(s), row_of(as_far));
  }
}

// A driver moves towards the limit too fast to stop in time.
TEST(Recovery, OvershootingDriversStopAtOnce) {
  Simulator s = test::simulator(test::limited_four_bar(Law::constant(0.5)).time(0, 1, 0.01).build(), "groups/eigen", {},
                                {"motor"});
  const double limit = std::acos(0.04);
  for (int k = 1; 0.5 + 0.05 * k < limit; ++k) {
    s.set("motor", 0.5 + 0.05 * k, 5);
    ASSERT_TRUE(s.step().arrived());
  }
  const std::vector<double> row = row_of(s);
  s.set("motor", limit + 0.05, 5);
  EXPECT_EQ(s.step().code, Code::fold);
  EXPECT_EQ(row_of(s), row);
  const std::size_t events = s.report().events.size();
  s.set("motor", limit - 0.04);
  ASSERT_TRUE(s.step().arrived());
  EXPECT_NEAR(s.output("B.x"), std::cos(limit - 0.04), 4 * kEps);
  EXPECT_EQ(s.report().events.size(), events);
}

// The law moves a driver until its first command. Here the law leads towards the limit and the first command away from
// it.
TEST(Recovery, TheFirstCommandMayReverseTheLaw) {
  const double limit = std::acos(0.04), start = limit - 0.01;
  Simulator s = test::simulator(test::limited_four_bar(Law::polynomial({start, 3})).time(0, 1, 0.1).build(),
                                "groups/eigen", {}, {"motor"});
  s.set("motor", start - 0.1);
  EXPECT_TRUE(s.step().arrived());
  EXPECT_NEAR(s.output("B.x"), std::cos(start - 0.1), 4 * kEps);
  EXPECT_TRUE(s.report().events.empty());
}

TEST(Recovery, RefusesStatesOfOtherScenes) {
  Simulator s = test::simulator(sample("four_bar")), other = test::simulator(sample("four_bar"));
  EXPECT_THROW(s.restore(SimulatorState()), Error);
  const SimulatorState state = other.save();
  EXPECT_THROW(s.restore(state), Error);
}

TEST(Recovery, AllocatesNothing) {
  Simulator s = test::simulator(test::limited_four_bar(Law::constant(0.5)).time(0, 1, 0.01).build(),
                                "irreducible/lanes", {}, {"motor"});
  SimulatorState state = s.save();
  std::int64_t before = 0;
  for (int k = 1; k <= 40; ++k) {
    if (k == 5) before = test::allocations();
    s.set("motor", 0.5 + 0.005 * k);
    ASSERT_TRUE(s.step().arrived());
    s.save(state);
    if (k % 2 == 0) s.restore(state);
  }
  EXPECT_EQ(test::allocations() - before, 0);
}

// A divided step keeps its start for retreat(), in memory that saved states must not share.
TEST(Recovery, DividedStepsAllocateNothingAfterSavingAndRestoring) {
  const double targets[] = {0.5, 0.51, -0.5, -0.51};  // rad; every second step is divided
  for (const std::string strategy : {"irreducible/lanes", "groups/eigen"}) {
    Simulator s =
        test::simulator(test::limited_four_bar(Law::constant(0.5)).time(0, 1, 0.01).build(), strategy, {}, {"motor"});
    SimulatorState state = s.save();
    std::int64_t before = 0;
    for (int k = 0; k < 120; ++k) {  // moves, saves and restores repeat after 60 steps; pivots are chosen before that
      if (k == 60) before = test::allocations();
      s.set("motor", targets[k % 4]);
      ASSERT_TRUE(s.step().arrived());
      if (k % 3 == 0) s.save(state);
      if (k % 5 == 0) s.restore(state);
    }
    EXPECT_EQ(test::allocations() - before, 0) << strategy;
    EXPECT_GT(s.report().counters.substeps, 120) << strategy;
  }
}

// A simulator that returns to the state of another one shares no memory with it.
TEST(Recovery, DividedStepsAllocateNothingAfterRestoringAnotherSimulator) {
  const Prepared prepared = prepare(test::limited_four_bar(Law::constant(0.5)).time(0, 1, 0.01).build(),
                                    {.strategy = "groups/eigen", .controlled = {"motor"}});
  Simulator a(prepared), b(prepared);
  const auto turn = [](Simulator& s, double angle) {
    s.set("motor", angle);
    EXPECT_TRUE(s.step().arrived());
  };
  turn(a, 0.49);
  ASSERT_EQ(a.report().counters.substeps, 0);
  turn(a, -0.6);
  ASSERT_GT(a.report().counters.substeps, 0);
  const SimulatorState divided = a.save();
  for (Simulator* s : {&a, &b}) {
    s->restore(divided);
    const std::int64_t before = test::allocations();
    for (const double angle : {-0.59, 0.5, 0.49, -0.6}) turn(*s, angle);
    EXPECT_EQ(test::allocations() - before, 0);
    s->restore(divided);
    s->retreat();
    EXPECT_NEAR(s->output("B.x"), std::cos(0.49), 4 * kEps);
  }
}

// The law throws in a later part of a long step, which is divided.
TEST(Recovery, RetreatsAfterAnException) {
  struct Broken {};
  const Simulator* moving = nullptr;
  const Law law = Law::function([&](double t) {
    if (moving != nullptr && moving->time() > 0.1) throw Broken();
    return Motion{0.5 + t, 1, 0};
  });
  Simulator s = test::simulator(test::limited_four_bar(law).time(0, 0.5, 0.01).build(), "groups/eigen");
  for (int k = 1; k <= 3; ++k) ASSERT_TRUE(s.step().arrived());
  const std::vector<double> row = row_of(s);
  const double begin = s.time();
  moving = &s;
  EXPECT_THROW((void)s.step(1), Broken);
  EXPECT_GT(s.time(), begin);
  s.retreat();
  EXPECT_EQ(s.time(), begin);
  EXPECT_EQ(row_of(s), row);
}

// A step that moves nothing leaves the posture as it was reached.
TEST(Recovery, RetreatsFromAStepThatMovedNothing) {
  Simulator s = test::simulator(test::limited_four_bar(Law::constant(0.5)).time(0, 1, 0.01).build(), "groups/eigen", {},
                                {"motor"});
  for (int k = 1; k <= 5; ++k) {
    s.set("motor", 0.5 + 0.01 * k);
    ASSERT_TRUE(s.step().arrived());
  }
  EXPECT_EQ(s.step(kNan).code, Code::not_finite);
  s.set("motor", kNan);
  EXPECT_EQ(s.step().code, Code::not_finite);
  const std::vector<double> row = row_of(s);
  s.retreat();
  EXPECT_EQ(row_of(s), row);
}

}  // namespace
}  // namespace assur
