// Estimates against the reference where laws have large phases, offsets, coefficients and times, and where mechanisms
// are far from the origin.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "assur/ensemble.hpp"
#include "assur/saved_plan.hpp"
#include "properties/near_singular.hpp"
#include "properties/random_count.hpp"
#include "simulation/run.hpp"

namespace assur {
namespace {

struct Named {
  std::string name;
  Law law;
  double start = 0;
};

// Laws whose arguments, values or terms have the size 10^k, and which move by about 1 within a second.
std::vector<Named> laws_of_size(int k) {
  const double size = 1.2345678 * std::pow(10, k), whole = std::round(size);
  const auto table = [&](double since, double offset) {
    std::vector<double> time, value;
    for (int i = 0; i < 10; ++i) {
      time.push_back(since - 0.1 + 0.15 * i);
      value.push_back(offset + 0.2 * i * i);
    }
    return Law::table(std::move(time), std::move(value));
  };
  std::vector<double> turn;
  std::vector<double> turn_times;
  for (int i = 0; i <= 12; ++i) {
    turn_times.push_back(0.1 * i);
    turn.push_back(i == 12 ? 0 : 0.3 * std::sin(kTurn * i / 12));
  }
  std::vector<Named> all = {
      {"c0", Law::polynomial({size, 1})},
      {"sum", Law::constant(size) + Law::polynomial({0.37, 1})},
      {"function", Law::constant(size) + Law::function([](double t) {
                     return Motion{0.37 + t, 1, 0};
                   })},
      {"phase", Law::harmonics({{0.3, 1, size}})},
      {"offset", Law::harmonics({{0.3, 1, 0.3}}, size)},
      {"values of a table", table(0, size)},
      {"late harmonic", Law::harmonics({{0.3, 1, 0.3}}), whole},
      {"late turn", Law::polynomial({0, 1}), whole},
      {"late table", table(whole, 0), whole},
      {"late period", Law::table(turn_times, turn, true), whole},
  };
  if (k <= 4) all.push_back({"square", Law::polynomial({0.5 * whole * whole, -whole, 0.5}), whole});
  if (k <= 3) {
    all.push_back(
        {"cube", Law::polynomial({-0.3 * whole * whole * whole, 0.9 * whole * whole, -0.9 * whole, 0.3}), whole});
  }
  return all;
}

SceneBuilder four_bar(double x = 0, double y = 0) {
  SceneBuilder b("four_bar", 2);
  b.fixed_point("A", {x, y}).fixed_point("D", {x + 2, y}).point("B", {x + 0.5, y}).point("C", {x + 1.6, y + 1.2});
  b.constrain("coupler", Distance{"B", "C", 1.8}).constrain("rocker", Distance{"D", "C", 1.3});
  return b;
}
Scene crank(const Law& law, double start) {
  return four_bar().drive("motor", PointAngle{"A", "B", "", law}).time(start, start + 1, 0.1).build();
}

// The end of a spatial rod hangs on a body whose heading follows the law.
Scene platform(const Law& law, double start) {
  SceneBuilder b("platform", 3);
  b.fixed_point("H", {0.4, 0.6, 0}).fixed_point("I", {0.6, 1, 0.3}).point("O", {0, 0, 0.6}).point("Q", {0.5, 0.5, 0.1});
  b.vector("u", {1, 0, 0}).vector("v", {0, 1, 0}).vector("w", {0, 0, 1});
  b.add(Body{.name = "plate", .origin = "O", .frame = {"u", "v", "w"}, .points = {{"P", {0.3, 0.1, 0.05}}}});
  b.constrain("a", Distance{"P", "Q", 0.8})
      .constrain("b", Distance{"H", "Q", 0.5})
      .constrain("c", Distance{"I", "Q", 0.9});
  b.drive("pose", Pose{"plate",
                       {Law::constant(0.1), Law::constant(0), Law::constant(0.6)},
                       {law, Law::harmonics({{0.3, 0.5, 0}}), Law::constant(0.2)}});
  return b.output("P").output("Q").time(start, start + 1, 0.1).build();
}

// The coordinate of a joint counts whole turns.
Scene joint(const Law& law, double start) {
  SceneBuilder b("joint", 2);
  b.fixed_point("D", {2, 0}).point("C", {1.6, 1.2});
  b.add(Body{.name = "crank", .points = {{"B", {0.5, 0, 0}, true}}});
  b.add(Joint{"pivot", Revolute{"ground", "crank", Triple{0, 0, 0}}});
  b.constrain("coupler", Distance{"B", "C", 1.8}).constrain("rocker", Distance{"D", "C", 1.3});
  b.drive("motor", DrivenCoordinate{"pivot.angle", law}).output("C").output("pivot.angle");
  return b.time(start, start + 1, 0.1).build();
}

// A slider that starts at the value of the law, and a dyad that it moves.
Scene slider(const Law& law, double start) {
  const double x = law(start).value;
  SceneBuilder b("slider", 2);
  b.fixed_point("A", {0, 0, 0}).point("S", {x, 0, 0}).fixed_point("F", {x + 0.5, 1, 0}).point("T", {x + 0.9, 0.2, 0});
  b.fixed_vector("rail", {1, 0, 0}).constrain("slide", OnLine{"S", "A", "rail"});
  b.constrain("r", Distance{"S", "T", 1.0}).constrain("q", Distance{"F", "T", 0.9});
  b.drive("motor", DrivenCoordinate{"slide.lambda", law}).output("T");
  return b.time(start, start + 0.25, 0.05).build();
}

struct Compared {
  int runs = 0, figures = 0, low = 0, high = 0;
  std::string worst;

  // Compares each figure: errors of a few roundings say nothing about the estimate.
  void compare(const std::string& name, const Scene& scene) {
    const Prepared p = prepare(scene);
    Simulator s(p);
    const Trajectory rows = s.run();
    if (!s.report().status.arrived()) return;
    ++runs;
    const ForwardError truth = forward_error(p, rows);
    const ErrorFigures& guess = s.report().error;
    const double all = std::max({truth.position, truth.velocity, truth.acceleration});
    EXPECT_EQ(s.report().status.ok(), s.report().events.empty()) << name;
    EXPECT_FALSE(s.report().status.ok() && all > kDoubtfulError) << name << ": " << all;
    EXPECT_FALSE(!s.report().status.ok() && all < kDoubtfulError / 1000) << name << ": " << all;
    for (const auto& [is, estimate] :
         {std::pair(truth.position, guess.estimated_position), std::pair(truth.velocity, guess.estimated_velocity),
          std::pair(truth.acceleration, guess.estimated_acceleration)}) {
      if (!estimate) continue;
      ++figures;
      if (is > 4 * kEps && is > *estimate) ++low, worst += name + ' ';
      if (*estimate > 1000 * std::max(is, kEps)) ++high, worst += '(' + name + ") ";
    }
  }
};

TEST(LawRounding, EstimatesCoverLargeNumbersOfLaws) {
  Compared c;
  for (int k = 0; k <= 9; ++k) {
    for (const Named& n : laws_of_size(k)) {
      const std::string name = n.name + " 1e" + std::to_string(k);
      c.compare("crank, " + name, crank(n.law, n.start));
      c.compare("platform, " + name, platform(n.law, n.start));
      if (k <= 3) c.compare("joint, " + name, joint(n.law, n.start));
      if (k <= 6 && n.name != "late turn") c.compare("slider, " + name, slider(n.law, n.start));
    }
  }
  EXPECT_GE(c.runs, 200);
  EXPECT_LE(c.low, c.figures / 100) << c.worst;
  EXPECT_LE(c.high, c.figures / 50) << c.worst;
}

// A sum of one to three parts with numbers of any size.
Law random_law(test::Draw& draw, double since) {
  const auto size = [&] { return std::pow(10, draw.real(-1, 9)) * draw.real(-1, 1); };
  const auto part = [&]() -> Law {
    switch (draw.below(5)) {
      case 0:
        return Law::polynomial({size(), draw.real(-1, 1)});
      case 1: {
        const double a = draw.real(-1, 1);  // a (t - since)^2
        return Law::polynomial({a * since * since, -2 * a * since, a});
      }
      case 2:
        return Law::harmonics({{draw.real(-1, 1), draw.real(0, 2), size()}, {0.1, 3, draw.real(-3, 3)}}, size());
      case 3: {
        const double offset = size();
        std::vector<double> time, value;
        for (int i = 0; i < 8; ++i) {
          time.push_back(since - 0.1 + 0.2 * i);
          value.push_back(offset + draw.real(0, 1));
        }
        return Law::table(time, value);
      }
      default:
        return Law::constant(size());
    }
  };
  Law sum = part();
  for (std::size_t more = draw.below(3); more > 0; --more) sum = sum + part();
  return sum;
}

// No wrong result is clean, 99 of 100 errors are at most three times the estimate, and doubts have a reason.
TEST(LawRounding, IsHonestForRandomLaws) {
  test::Draw draw(5);
  std::vector<double> ratios;
  int runs = 0, doubted = 0, needless = 0, refused = 0;
  const int all = test::random_count(200);
  for (int i = 0; i < all; ++i) {
    const double start = draw.maybe() ? 0 : std::pow(10, draw.real(-1, 3));
    const Law law = random_law(draw, start);
    SCOPED_TRACE(i);
    try {
      const Prepared p = prepare(draw.maybe() ? crank(law, start) : platform(law, start));
      Simulator s(p);
      const Trajectory rows = s.run();
      if (!s.report().status.arrived()) continue;
      ++runs;
      const ForwardError truth = forward_error(p, rows);
      const ErrorFigures& guess = s.report().error;
      const double worst = std::max({truth.position, truth.velocity, truth.acceleration});
      EXPECT_FALSE(s.report().status.ok() && worst > kDoubtfulError) << worst;
      ratios.push_back(truth.position / guess.estimated_position.value());
      ratios.push_back(truth.velocity / guess.estimated_velocity.value());
      ratios.push_back(truth.acceleration / guess.estimated_acceleration.value());
      if (s.report().status.ok()) continue;
      ++doubted;
      needless += worst < kDoubtfulError / 1000 ? 1 : 0;
    } catch (const Error& e) {
      ++refused;
      EXPECT_NE(e.kind(), Error::Kind::input) << e.what();
    }
  }
  std::sort(ratios.begin(), ratios.end());
  const auto quantile = [&](double share) {
    return ratios[static_cast<std::size_t>(share * static_cast<double>(ratios.size() - 1))];
  };
  std::printf(
      "%d runs, %d refused: true over estimated error median %.2g, 99 %%: %.2g, largest %.2g; %d in doubt, %d of "
      "them without reason\n",
      runs, refused, quantile(0.5), quantile(0.99), quantile(1), doubted, needless);
  ASSERT_GT(runs, all / 2);
  EXPECT_LE(quantile(0.99), 3);
  EXPECT_GE(quantile(0.5), 0.03);
  EXPECT_LE(needless, all / 100);
}

TEST(LawRounding, AngleOfManyTurnsIsInaccurate) {
  for (const double accuracy : {1e-12, 1e-6}) {
    const Prepared p = prepare(crank(Law::polynomial({1e8, 1}), 0), {.accuracy = accuracy});
    Simulator s(p);
    const Trajectory rows = s.run();
    const ForwardError truth = forward_error(p, rows);
    EXPECT_GT(truth.position, 1e-10);
    EXPECT_EQ(s.report().status.code, accuracy < 1e-8 ? Code::inaccurate : Code::ok);
    EXPECT_GE(s.report().error.estimated_position.value(), truth.position);
    EXPECT_LE(s.report().error.estimated_position.value(), 1000 * truth.position);
  }
}

// A frequency of whole cycles, however late, and numbers that are exact.
TEST(LawRounding, ExactLawsAreAccurate) {
  const std::vector<std::pair<Law, double>> laws = {
      {Law::harmonics({{0.3, 1, 0.3}}), 1e9}, {Law::constant(1e11), 0}, {Law::harmonics({{0.3, 0, 1e11}}), 0}};
  for (const auto& [law, start] : laws) {
    Simulator s(prepare(crank(law, start), {.accuracy = 1e-12}));
    s.run();
    EXPECT_TRUE(s.report().status.ok()) << start;
    EXPECT_LE(s.report().error.estimated_position.value(), 1e-13);
  }
}

// A constant law moves nothing, but its parts are added.
TEST(LawRounding, CoversParts) {
  for (const bool moves : {false, true}) {
    SceneBuilder b = four_bar();
    b.drive("motor", PointAngle{"A", "B", "", Law::constant(1e9) + Law::constant(0.3)});
    if (moves) {
      b.point("E", {1.6, 2, 0}).constrain("arm", Distance{"C", "E", 0.8});
      b.drive("other", PointAngle{"C", "E", "", Law::polynomial({1, 1})});
    }
    const Prepared p = prepare(b.time(0, 1, 0.25).build());
    Simulator s(p);
    const Trajectory rows = s.run();
    const double truth = forward_error(p, rows).position;
    EXPECT_GT(truth, 1e-10);
    EXPECT_GE(s.report().error.estimated_position.value(), truth);
  }
}

// The rate at the start is only rounding, and no measure of the rates of the run.
TEST(LawRounding, StartsAtRestAreAccurate) {
  for (const double late : {0.0, 1.0, 1000.0}) {
    for (const double turn : {0.7, 3.0, 40.0}) {
      const double back = -turn / kTurn;
      const Law cycloid = Law::polynomial({0.3, turn}) + Law::harmonics({{back, 1, 0}});
      const Prepared p = prepare(crank(cycloid, late), {.accuracy = 1e-9});
      Simulator s(p);
      (void)s.examine();
      EXPECT_TRUE(s.report().status.ok()) << late << ' ' << turn;
      const Trajectory rows = s.run();
      EXPECT_TRUE(s.report().status.ok()) << late << ' ' << turn;
      const ForwardError truth = forward_error(p, rows);
      EXPECT_LE(truth.velocity, 2 * s.report().error.estimated_velocity.value());
      EXPECT_LE(truth.acceleration, 2 * s.report().error.estimated_acceleration.value());
    }
  }
}

// The error is measured again before the rounding of the angle has doubled twice.
TEST(LawRounding, FollowsGrowingAngles) {
  const Scene scene =
      four_bar().drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, 0, 0, 0, 1})}).time(0, 14, 0.05).build();
  for (const std::string strategy : {"irreducible/lanes", "irreducible/lanes:4+chunks=4"}) {
    const Prepared p = prepare(scene, {.strategy = strategy});
    Simulator s(p);
    const Trajectory rows = s.run();
    ASSERT_TRUE(s.report().status.arrived()) << name(s.report().status.code);
    const ForwardError truth = forward_error(p, rows);
    EXPECT_GT(truth.position, 1e-12);
    EXPECT_GE(s.report().error.estimated_position.value(), truth.position) << strategy;
    EXPECT_GE(s.report().error.estimated_velocity.value(), truth.velocity) << strategy;
  }
}

TEST(LawRounding, CountsForMembersOfEnsembles) {
  const std::vector<double> sizes = {0.5, 1e8, 3, 1e10};
  Ensemble e(sizes.size(), [&](std::size_t i) { return prepare(crank(Law::polynomial({sizes[i], 1}), 0)); });
  (void)e.run();
  EXPECT_GE(e.report().error.estimated_position.value(), 1e-7);
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    EXPECT_EQ(e.outcomes()[i].status.code, sizes[i] > 5e9 ? Code::inaccurate : Code::ok) << i;
  }
}

// A posture at rest, far from the origin: fixed points are exact, and differences of near points too.
TEST(LawRounding, StandingPostureFarFromTheOrigin) {
  for (const double far : {0.0, 1e6}) {
    const Prepared p = prepare(
        four_bar(far, far).drive("motor", PointAngle{"A", "B", "", Law::constant(0.4)}).time(0, 1, 0.5).build());
    Simulator s(p);
    const Trajectory rows = s.run();
    EXPECT_TRUE(s.report().status.ok());
    EXPECT_GE(4 * s.report().error.estimated_position.value() + kEps, forward_error(p, rows).position);
    EXPECT_LE(s.report().error.estimated_position.value(), 1e-14);
  }
}

// A wheel turns much faster than the displacement that drives it.
TEST(LawRounding, LeadScrewsAreAccurate) {
  for (const double pitch : {0.1, 0.01, 0.001}) {
    SceneBuilder b("screw", 2);
    b.add(Body{.name = "nut", .points = {{"N", {0.3, 0.2, 0}, true}}});
    b.add(Body{.name = "wheel", .points = {{"W", {0.1, 1.05, 0}, true}}});
    b.add(Joint{"slide", Prismatic{"ground", "nut", Triple{1, 0, 0}}});
    b.add(Joint{"spin", Revolute{"ground", "wheel", Triple{0, 1, 0}}});
    b.constrain("thread", Gear{"spin.angle", "slide.displacement", pitch / kTurn});
    b.drive("motor", DrivenCoordinate{"slide.displacement", Law::polynomial({0, 5 * pitch})});
    b.output("W").output("spin.angle").time(0, 1, 0.01);
    const Prepared p = prepare(b.build());
    Simulator s(p);
    const Trajectory rows = s.run();
    EXPECT_TRUE(s.report().status.ok()) << pitch;
    const ForwardError truth = forward_error(p, rows);
    EXPECT_LE(truth.acceleration, 1e-12);
    EXPECT_GE(s.report().error.estimated_acceleration.value(), truth.acceleration);
  }
}

TEST(MonotoneTable, MovesLikeItsPlanAndFile) {
  const Law steps = Law::table({0, 0.2, 0.4, 0.6, 0.8, 1}, {0, 0, 0.5, 0.5, 1, 1}, false, true);
  const Scene scene = crank(steps, 0);
  const test::Result plain = test::run(scene, "irreducible/eigen");
  ASSERT_TRUE(plain.report().status.ok());
  EXPECT_LE(forward_error(plain.simulator.prepared(), plain.trajectory).acceleration, 1e-13);
  std::stringstream plan;
  save_plan(plan, plain.simulator.prepared());
  for (const Prepared& p :
       {load_plan(plan), prepare(parse_scene(write_scene(scene)), {.strategy = "irreducible/eigen"})}) {
    Simulator s(p);
    EXPECT_TRUE(std::ranges::equal(s.run().values(), plain.trajectory.values()));
  }
}

}  // namespace
}  // namespace assur
