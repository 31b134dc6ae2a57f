// Mechanisms that are driven to their limits, and drivers that end.
#include <gtest/gtest.h>

#include "motion/limited.hpp"
#include "plan/preparation.hpp"
#include "simulation/run.hpp"
#include "source_dir.hpp"

namespace assur {
namespace {

using test::Result;

struct Limit {
  std::string name;
  Scene scene;
  double time;        // time of the limit, by a closed form
  std::string group;  // the group that reaches the limit
};

Limit four_bar() {
  const Scene scene = test::limited_four_bar(Law::polynomial({0.5, 1})).time(0, 2, 0.01).build();
  return {"four_bar", scene, std::acos(0.04) - 0.5, "C"};
}

// Crank 0.3, rod 0.2: the rod is perpendicular to the rail at sin theta = 2/3.
Limit slider_crank() {
  SceneBuilder builder("limited_slider", 2);
  builder.fixed_point("O", {0, 0, 0}).fixed_vector("rail", {1, 0, 0});
  builder.point("B", {0.3, 0, 0}).point("C", {0.5, 0, 0});
  builder.constrain("crank", Distance{"O", "B", 0.3});
  builder.constrain("rod", Distance{"B", "C", 0.2});
  builder.constrain("slide", OnLine{"C", "O", "rail"});
  builder.drive("motor", PointAngle{"O", "B", "", Law::polynomial({0, 1})}).time(0, 1, 0.01);
  return {"slider_crank", builder.build(), std::asin(2.0 / 3), ""};
}

void expect_limit(const Limit& limit, const std::string& strategy) {
  SCOPED_TRACE(limit.name + " " + strategy);
  const Result r = test::run(limit.scene, strategy);
  EXPECT_EQ(r.report().status.code, Code::fold);
  ASSERT_EQ(r.report().events.size(), 1u);
  const Event& e = r.report().events[0];
  EXPECT_TRUE(r.report().status.where.is(Place::Kind::group));
  EXPECT_EQ(preparation(r.simulator.prepared()).structure->name_of(r.report().status.where), e.group);
  EXPECT_EQ(e.kind, Code::fold);
  EXPECT_LE(e.time, limit.time);
  EXPECT_GE(e.until, limit.time);
  EXPECT_LE(e.until - e.time, 1e-12);
  if (!limit.group.empty() && strategy.rfind("global", 0) != 0) {
    EXPECT_EQ(e.group, limit.group);
  }
  // All rows before the limit are kept.
  ASSERT_EQ(r.trajectory.rows(), static_cast<std::size_t>(std::floor(limit.time / 0.01)) + 1);
  EXPECT_EQ(r.trajectory.times().back(), limit.scene.time().time(static_cast<std::int64_t>(r.trajectory.rows()) - 1));
  EXPECT_LE(r.report().reached, e.time);  // the last posture whose branch is certain
  EXPECT_GE(r.report().reached, e.time - 1e-5);
  EXPECT_EQ(r.simulator.time(), r.report().reached);
  EXPECT_LE(r.report().error.position, 1e-14);
}

TEST(Limit, BracketsTheLimitOfAFourBar) {
  const Limit limit = four_bar();
  for (const std::string formulation : {"global", "groups", "irreducible"}) {
    for (const std::string& solver : test::solvers()) expect_limit(limit, formulation + "/" + solver);
  }
  for (const std::string option :
       {"+once", "+predict=taylor:0", "+predict=taylor:1", "+predict=taylor:2", "+predict=past:3"}) {
    expect_limit(limit, "groups/eigen" + option);
  }
}

TEST(Limit, BracketsTheLimitOfASliderCrank) {
  const Limit limit = slider_crank();
  for (const std::string formulation : {"global", "groups", "irreducible"}) {
    for (const std::string& solver : test::solvers()) expect_limit(limit, formulation + "/" + solver);
  }
}

// The group of the slider has one unknown, so that it has only one singular value.
TEST(Limit, BracketsTheLimitOfASliderWithOneUnknown) {
  SceneBuilder builder("limited_coordinate", 2);
  builder.fixed_point("O", {0, 0, 0}).point("B", {0.3, 0, 0}).point("C", {0.5, 0, 0});
  builder.constrain("crank", Distance{"O", "B", 0.3}).constrain("rod", Distance{"B", "C", 0.2});
  builder.constrain("slide", FixedCoordinate{"C.y", 0.0});
  builder.drive("motor", PointAngle{"O", "B", "", Law::polynomial({0, 1})}).time(0, 1, 0.01);
  const Limit limit{"slider", builder.build(), std::asin(2.0 / 3), "C.x"};
  for (const std::string formulation : {"global", "groups", "irreducible"}) {
    for (const std::string& solver : test::solvers()) expect_limit(limit, formulation + "/" + solver);
  }
}

// Rates are unbounded at the limit, but the angle is continuous.
TEST(Limit, IsReachedByAnglesWithoutAJump) {
  const Scene scene = test::limited_four_bar(Law::polynomial({0.5, 1}))
                          .measure("swing", AbsoluteAngle{"A1", "C"})
                          .time(0, 2, 0.01)
                          .build();
  Simulator s = test::simulator(scene, "groups/eigen");
  const Trajectory rows = s.run();
  ASSERT_EQ(s.report().status.code, Code::fold);
  const std::size_t rocker = rows.index("swing");
  // In the last step the rocker turns by about the square root of the remaining crank angle.
  EXPECT_NEAR(s.output("swing"), rows(rows.rows() - 1, rocker), 0.3);
}

TEST(Limit, IsFoundWithPositionsOnly) {
  Limit limit = four_bar();
  limit.scene = limit.scene.with_outputs({"C.position"});
  for (const std::string formulation : {"global", "groups", "irreducible"}) expect_limit(limit, formulation + "/eigen");
}

// Before the limit, C is the intersection of two circles on the side of the guess.
TEST(Limit, RowsBeforeItAreRight) {
  const Limit limit = four_bar();
  const Result r = test::run(limit.scene, "groups/eigen");
  for (std::size_t k = 0; k < r.trajectory.rows(); ++k) {
    const double angle = 0.5 + r.trajectory.times()[k], bx = std::cos(angle), by = std::sin(angle);
    const double dx = 2 - bx, dy = -by, square = dx * dx + dy * dy;
    const double along = (square + 1 - 1.44) / (2 * square), across = std::sqrt(1 / square - along * along);
    // sigma is the sine between coupler and rocker. Closed form and posture both have errors of a few eps / sigma.
    const double sigma = across * square / 1.2;
    ASSERT_NEAR(r.trajectory(k, r.trajectory.index("C.x")), bx + along * dx - across * dy, 64 * kEps / sigma) << k;
    ASSERT_NEAR(r.trajectory(k, r.trajectory.index("C.y")), by + along * dy + across * dx, 64 * kEps / sigma) << k;
  }
}

TEST(Limit, IsFoundBackwards) {
  const Limit limit = four_bar();
  Simulator s = test::simulator(limit.scene, "groups/eigen");
  // The crank turns back through 0 to the limit on the other side.
  EXPECT_EQ(s.step(-2.1).code, Code::fold);
  ASSERT_EQ(s.report().events.size(), 1u);
  const double mirrored = -std::acos(0.04) - 0.5;
  EXPECT_GE(s.report().events[0].time, mirrored);
  EXPECT_LE(s.report().events[0].until, mirrored);
  // The crank can turn back from there.
  EXPECT_TRUE(s.step(0).ok());
}

TEST(Limit, EndOfATableIsOutOfRange) {
  SceneBuilder builder("tabled", 2);
  builder.fixed_point("A0", {0, 0, 0}).point("B", {1, 0, 0});
  builder.drive("motor", PointAngle{"A0", "B", "", Law::table({0, 0.3, 0.7, 1}, {0, 0.2, 0.3, 0.9})}).time(0, 1, 0.1);
  Simulator s = test::simulator(builder.build());
  ASSERT_TRUE(s.step(1).ok());
  const double x = s.output("B.x");
  EXPECT_EQ(s.step(1.5).code, Code::out_of_range);
  EXPECT_EQ(s.report().status.code, Code::out_of_range);
  EXPECT_EQ(s.time(), 1);
  EXPECT_EQ(s.output("B.x"), x);
  EXPECT_TRUE(s.step(0.9).ok());
}

TEST(Limit, DrivenDistanceStopsAtZero) {
  SceneBuilder builder("shrinking", 2);
  builder.fixed_point("A", {0, 0, 0}).fixed_vector("rail", {0.8, 0.6, 0}).point("P", {0.8, 0.6, 0});
  builder.constrain("slide", OnLine{"P", "A", "rail"});
  builder.drive("actuator", DrivenDistance{"A", "P", Law::polynomial({1, -1})}).time(0, 0.5, 0.1);
  Simulator s = test::simulator(builder.build());
  ASSERT_TRUE(s.step(0.9).ok());
  EXPECT_NEAR(s.output("slide.lambda"), 0.1, 8 * kEps);
  for (const double t : {1.0, 1.5}) {
    EXPECT_EQ(s.step(t).code, Code::actuator_zero) << t;
    EXPECT_LT(s.time(), 1);
    EXPECT_NEAR(s.time(), 1, 1e-6);
    EXPECT_NEAR(s.output("slide.lambda"), 1 - s.time(), 8 * kEps);
  }
  EXPECT_TRUE(s.step(0.95).ok());
}

// A length that is positive at both ends of a step but not in between: the motion ends at its zero.
TEST(Limit, FindsAZeroDistanceBetweenRows) {
  const auto cylinder = [](Law law) {
    SceneBuilder builder("cylinder", 2);
    builder.fixed_point("O", {0, 0, 0}).fixed_vector("x", {1, 0, 0}).point("P", {law(0).value, 0, 0});
    builder.constrain("rail", OnLine{"P", "O", "x"});
    builder.drive("push", DrivenDistance{"O", "P", std::move(law)}).time(0, 1, 0.25);
    return builder.build();
  };
  struct Dip {
    Law law;
    double zero;
    bool touches = false;  // the length touches zero without changing its sign
  };
  for (const auto& [law, zero, touches] :
       {Dip{Law::polynomial({0.1406 - 1e-6, -0.75, 1}), 0.3700}, Dip{Law::polynomial({0.05, -0.21, 0.21}), 0.3909},
        Dip{Law::polynomial({0.36, -1.2, 1}), 0.6, true}}) {
    for (const std::string strategy : {"irreducible/eigen", "groups/eigen:4+chunks=2"}) {
      const Result r = test::run(cylinder(law), strategy);
      const Code code = r.report().status.code;
      EXPECT_TRUE(code == Code::actuator_zero) << strategy << name(code);
      EXPECT_LT(r.report().reached, zero) << strategy;
      EXPECT_GE(r.trajectory.times().back(), 0.25) << strategy;
    }
  }
  EXPECT_TRUE(test::run(cylinder(Law::polynomial({0.3601, -1.2, 1}))).report().status.ok());
}

// The lever of a driven angle vanishes between two rows. Its equations are linear and do not limit the step.
TEST(Limit, FindsAVanishingLeverBetweenRows) {
  const auto arm = [](double least) {
    SceneBuilder builder("arm", 2);
    builder.fixed_point("O", {0, 0, 0}).fixed_vector("x", {1, 0, 0}).point("B", {1, 0.5, 0});
    builder.drive("turn", RelativeAngle{"x", Direction{"O", "B"}, "", Law::constant(0.46)});
    builder.drive("push", DrivenCoordinate{"B.x", Law::polynomial({1, -4 * (1 - least), 4 * (1 - least)})});
    return builder.time(0, 1, 1).build();
  };
  for (const std::string strategy : {"irreducible/eigen", "groups/eigen", "groups/eigen:4+chunks=2"}) {
    for (const std::vector<std::string>& outputs :
         {std::vector<std::string>{}, std::vector<std::string>{"B.position"}}) {
      const Scene through = arm(-0.05);
      const Result r = test::run(outputs.empty() ? through : through.with_outputs(outputs), strategy);
      EXPECT_EQ(r.report().status.code, Code::actuator_zero) << strategy;
      ASSERT_FALSE(r.report().events.empty()) << strategy;
      EXPECT_EQ(r.report().events.back().group, "turn") << strategy;
      EXPECT_LT(r.report().reached, 0.3909) << strategy;  // the lever vanishes at 0.5 - sqrt(0.25 / 21)
      EXPECT_TRUE(test::run(arm(0.05), strategy).report().status.ok()) << strategy;
    }
  }
}

// Gough's platform is almost singular on its whole way to a limit. Proven balls, and therefore steps, are tens of
// thousands times shorter than the remaining way.
TEST(Limit, AStepMayTakeTensOfThousandsOfAttempts) {
  const Scene scene = read_scene(ASSUR_SOURCE_DIR "/scenes/gough.json");
  std::vector<std::string> legs;
  for (const Driver& d : scene.drivers()) legs.push_back(d.name);
  Simulator s = test::simulator(scene, "irreducible/eigen", {}, legs);
  const std::vector<double> by = {0.0012, -0.0021, 0.0059, 0.0061, -0.0029, -0.0032};
  for (std::size_t i = 0; i < legs.size(); ++i) {
    s.set(legs[i], std::get<DrivenDistance>(scene.drivers()[i].kind).law(0).value + by[i]);
  }
  const Status status = s.step(1);
  EXPECT_EQ(status.code, Code::fold);
  EXPECT_GT(s.report().counters.rejected, 10000);
  EXPECT_GT(s.time(), 0);
  ASSERT_EQ(s.report().events.size(), 1U);
  EXPECT_EQ(s.report().events[0].kind, Code::fold);
}

}  // namespace
}  // namespace assur
