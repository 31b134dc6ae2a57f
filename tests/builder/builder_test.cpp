#include "assur/scene.hpp"
#include "numbers.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <concepts>

namespace assur {
namespace {

SceneBuilder four_bar() {
  SceneBuilder builder("four_bar", 2);
  builder.fixed_point("A", {0, 0, 0}).fixed_point("D", {2, 0, 0}).point("B", {0.8, 0, 0}).point("C", {1.6, 1.2, 0});
  builder.constrain("coupler", Distance{"B", "C", 1.8}).constrain("rocker", Distance{"D", "C", 1.3});
  builder.drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, 6})});
  builder.measure("rocker_angle", AbsoluteAngle{"D", "C"}).output("C").time(0, 1, 0.01);
  return builder;
}

// The findings, one on each line; "" if there are none.
template <std::invocable Call>
std::string findings(Call&& call) {
  try {
    (void)call();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::input);
    return error.what();
  }
  return "";
}
std::string findings(const SceneBuilder& builder) {
  return findings([&] { return builder.build(); });
}

// A scene may have millions of parts and belong to many plans.
TEST(Scene, CopiesShareTheirParts) {
  SceneBuilder builder("bar", 2);
  builder.fixed_point("A", {0, 0, 0}).point("B", {1, 0, 0}).constrain("bar", Distance{"A", "B", 1.0});
  const Scene scene = builder.build(), again = builder.build();
  const Scene other = scene.with_outputs({"B"}).with_time({0, 1, 0.5});
  EXPECT_EQ(&other.points(), &scene.points());
  EXPECT_EQ(&other.constraints(), &scene.constraints());
  EXPECT_TRUE(scene.outputs().empty());
  EXPECT_NE(&again.points(), &scene.points());
  EXPECT_EQ(again.points().size(), 2U);
  EXPECT_EQ(std::move(builder).build().points().size(), 2U);
}

TEST(SceneBuilder, BuildsWhatWasAdded) {
  const Scene scene = four_bar().build();
  EXPECT_EQ(scene.name(), "four_bar");
  EXPECT_EQ(scene.points().size(), 4u);
  EXPECT_EQ(scene.constraints().size(), 2u);
  EXPECT_EQ(scene.outputs(), std::vector<std::string>{"C"});
}

TEST(SceneBuilder, ReportsTheSameErrorsAsTheReader) {
  SceneBuilder builder = four_bar();
  builder.constrain("bad", Distance{"B", "Cc", -1}).drive("push", DrivenCoordinate{"A.x", {}});
  builder.drive("turn", RelativeAngle{{"A", "X"}, {"D", "C"}, "", {}});
  EXPECT_EQ(findings(builder),
            "/constraints/bad/distance/1: there is no point 'Cc'; did you mean 'C'?\n"
            "/constraints/bad/value: a distance must be > 0, not -1 m\n"
            "/drivers/push/coordinate: everything here is fixed, so nothing can be driven; drive something that moves\n"
            "/drivers/turn/angle/0/1: there is no point 'X'");
}

TEST(SceneBuilder, OrderDoesNotMatter) {
  SceneBuilder builder("late", 2);
  builder.output("M").constrain("rod", Distance{"A", "M", 1.0});
  builder.add(Body{"arm", "", {}, {"A", "B"}, {{"M", {1, 1, 0}}}, {}});
  builder.point("B", {1, 0, 0}).point("A", {0, 0, 0});
  EXPECT_EQ(findings(builder), "");
}

TEST(SceneBuilder, NumbersMustBeFinite) {
  SceneBuilder builder("nan", 3);
  builder.point("P", {0, kNan, 0}).vector("u", {0, 0, INFINITY}).point("Q", {1, 0, 0}).fixed_point("O", {0, 0, 0});
  builder.constrain("d", Distance{"P", "Q", kNan}).constrain("l", Linear{{{"P", kNan}}, {0, 0, kNan}});
  builder.constrain("c", FixedCoordinate{"Q.x", kNan}).constrain("f", Distance{"P", "Q", {}}).time(0, kNan, 1);
  EXPECT_EQ(findings(builder),
            "/points/P/at/1: the value is nan; a finite number is wanted\n"
            "/vectors/u/at/2: the value is inf; a finite number is wanted\n"
            "/constraints/d/value: the value is nan; a finite number is wanted\n"
            "/constraints/l/linear/0/1: the value is nan; a finite number is wanted\n"
            "/constraints/l/value/2: the value is nan; a finite number is wanted\n"
            "/constraints/c/value: the value is nan; a finite number is wanted\n"
            "/time/end: the value is nan; a finite number is wanted");
}

TEST(SceneBuilder, RefusesAThirdCoordinateInThePlane) {
  SceneBuilder builder("plane", 2);
  builder.point("P", {0, 0, 1}).constrain("sum", Linear{{{"P", 1}}, {0, 0, 2}});
  EXPECT_EQ(findings(builder),
            "/points/P/at/2: a plane scene has no z; write 0 or leave it out\n"
            "/constraints/sum/value/2: a plane scene has no z; write 0 or leave it out");
}

TEST(SceneBuilder, RefusesOtherDimensions) {
  EXPECT_EQ(findings(SceneBuilder("line", 1).point("P", {})), "/dimension: the dimension is 2 or 3, not 1");
}

TEST(SceneBuilder, ErrorsOfTheReaderComeFirstAndOnce) {
  SceneBuilder builder = four_bar();
  builder.add(Point{"E", {kNan, 0, 0}, false}).diagnose({"/points/E/at", "unreadable"});
  builder.constrain("odd", Dot{}).diagnose({"/constraints/odd", ""});
  builder.constrain("use", FixedCoordinate{"odd.lambda", 0}).constrain("arm", Distance{"E", "E2", 1.0});
  EXPECT_EQ(findings(builder),
            "/points/E/at: unreadable\n/constraints/arm/distance/1: there is no point 'E2'; did you mean 'E'?");
}

TEST(SceneBuilder, OrdersBodiesByTheirDependencies) {
  SceneBuilder builder("chain", 2);
  builder.point("O", {0, 0, 0}).fixed_vector("x", {1, 0, 0});
  constexpr int kLength = 50000;  // too deep for a recursion
  for (int i = kLength; i > 0; --i) {
    const std::string below = i == 1 ? "O" : "P" + std::to_string(i - 1);
    builder.add(Body{"b" + std::to_string(i), below, {}, {}, {{"P" + std::to_string(i), {1, 0, 0}}}, {}});
  }
  const Scene scene = builder.constrain("end", Distance{"O", "P3", {}}).build();
  ASSERT_EQ(scene.bodies().size(), static_cast<std::size_t>(kLength));
  EXPECT_EQ(scene.bodies().front().name, "b1");
  EXPECT_EQ(scene.bodies().back().name, "b" + std::to_string(kLength));
}

TEST(SceneBuilder, MembersArePlacedByTheirBody) {
  SceneBuilder builder("placed", 3);
  builder.fixed_point("O", {1, 0, 0}).point("A", {0, 0, 0}).point("B", {0, 2, 0}).point("C", {-3, 1, 0});
  builder.add(Body{"plate", "", {}, {"A", "B", "C"}, {{"M", {0, 0, 5}}, {"N", {1, -1, 0}}}, {}});  // axes y, -x, z
  builder.fixed_point("above", {0, 0, 5});
  builder.constrain("m", Distance{"above", "M", {}}).constrain("n", Distance{"O", "N", {}});
  EXPECT_EQ(
      findings(builder),
      "/constraints/m/distance: 'above' and 'M' are at the same place, so the omitted value is 0; give a value, or "
      "use a single point");
}

TEST(SceneBuilder, MembersOfAFixedBaseAreFixed) {
  SceneBuilder builder("fixed", 2);
  builder.fixed_point("A", {0, 0, 0}).fixed_point("B", {1, 0, 0}).point("C", {0, 1, 0});
  builder.add(Body{"wall", "", {}, {"A", "B"}, {{"M", {1, 1, 0}}}, {}});
  builder.add(Body{"cart", "C", {}, {}, {{"N", {1, 1, 0}}}, {{"t", {1, 0, 0}}}});
  builder.constrain("dead", Distance{"A", "M", 2.0}).constrain("alive", Distance{"A", "N", 2.0});
  builder.constrain("dead_too", Dot{"t", {"A", "B"}, 0.5});
  EXPECT_EQ(findings(builder),
            "/constraints/dead/distance: everything here is fixed, so it cannot constrain anything; remove it or let "
            "something move\n"
            "/constraints/dead_too/dot: everything here is fixed, so it cannot constrain anything; remove it or let "
            "something move");
}

TEST(SceneBuilder, ChecksCallbacks) {
  const auto residual = [](std::span<const double>, std::span<double>) {};
  const auto curvature = [](std::span<const double>, std::span<const double>, std::span<double>) {};
  SceneBuilder builder = four_bar();
  builder.drive("pull", DrivenDistance{"A", "C", Law::constant(1)});
  builder.constrain("good", Callback{{"C.x", "pull"}, 1, residual, residual, curvature});
  EXPECT_EQ(findings(builder), "");
  builder.constrain("bad", Callback{{"C.z", "motor", "Q.x"}, 0, residual, residual, {}});
  builder.constrain("none", Callback{{}, 1, residual, residual, curvature});
  builder.constrain("dead", Callback{{"A.x", "pull"}, 1, residual, residual, curvature});
  EXPECT_EQ(findings(builder),
            "/constraints/bad/callback: a callback gives at least one equation, not 0\n"
            "/constraints/bad/callback: a callback needs all three functions: residual, jacobian and curvature\n"
            "/constraints/bad/callback/coordinates/0: 'C.z' is not a coordinate; write 'C' with .x or .y\n"
            "/constraints/bad/callback/coordinates/1: 'motor' gives no single number; only distance and coordinate "
            "drivers do\n"
            "/constraints/bad/callback/coordinates/2: there is no point, vector or constraint 'Q'\n"
            "/constraints/none/callback: a callback needs the names of the coordinates that it constrains\n"
            "/constraints/dead/callback: everything here is fixed, so it cannot constrain anything; remove it or let "
            "something move");
}

TEST(SceneBuilder, DoesNotCallLawFunctions) {
  int calls = 0;
  SceneBuilder builder = four_bar();
  builder.drive("pull", DrivenDistance{"A", "C", Law::function([&](double) {
                                         ++calls;
                                         return Motion{-1, 0, 0};
                                       })});
  EXPECT_EQ(findings(builder), "");
  EXPECT_EQ(calls, 0);
}

TEST(SceneBuilder, ManyUnknownNamesStayFast) {
  SceneBuilder builder("many", 2);
  constexpr int kCount = 20000;
  for (int i = 0; i < kCount; ++i) builder.point("P" + std::to_string(i), {1.0 * i, 0, 0});
  for (int i = 0; i < kCount; ++i) {
    builder.constrain("c" + std::to_string(i), Distance{"P" + std::to_string(i), "Q" + std::to_string(i), 1.0});
  }
  try {
    (void)builder.build();
    FAIL();
  } catch (const Error& error) {
    ASSERT_EQ(error.diagnostics().size(), static_cast<std::size_t>(kCount));
    EXPECT_EQ(error.diagnostics().front().what, "there is no point 'Q0'; did you mean 'P0'?");
    EXPECT_EQ(error.diagnostics().back().what, "there is no point 'Q19999'");  // suggestions are for the first ones
  }
}

TEST(TimeGrid, StepsAreMultiplied) {
  const TimeGrid grid{0.5, 1.5, 0.1};
  EXPECT_EQ(grid.steps(), 10);
  EXPECT_EQ(grid.time(0), 0.5);
  EXPECT_EQ(grid.time(7), 0.5 + 7 * 0.1);
  EXPECT_EQ(TimeGrid{}.steps(), 0);
}

TEST(TimeGrid, IsChecked) {
  const auto checked = [](double start, double end, double step) {
    return findings(SceneBuilder("t", 2).time(start, end, step));
  };
  EXPECT_EQ(checked(0, 0, 1), "");
  EXPECT_EQ(checked(0, 1, 1 / 3.0), "");
  EXPECT_EQ(checked(0, 1000, 0.001), "");
  EXPECT_EQ(checked(0, 0, 0), "/time/step: the step is 0 s; it must be > 0");
  EXPECT_EQ(checked(0, 1, -0.1), "/time/step: the step is -0.1 s; it must be > 0");
  EXPECT_EQ(checked(0, -1, 0.1), "/time/end: the end, -1 s, comes before the start, 0 s");
  EXPECT_EQ(
      checked(0, 1, 0.4),
      "/time/step: (end - start) / step is 2.5; a whole number of steps is wanted, e.g. to the end 1.2000000000000002");
  EXPECT_EQ(checked(0, 1 + 2e-9, 1).rfind("/time/step: (end - start) / step is 1.000000002", 0), 0u);
  EXPECT_EQ(checked(0, 1 + 0.5e-9, 1), "");
  // Rounding of times is not an error, for any number of steps and any start.
  EXPECT_EQ(checked(0, 0.001 * 2147483647, 0.001), "");
  EXPECT_EQ(checked(1e9, 1e9 + 0.003, 0.001), "");
  EXPECT_EQ(SceneBuilder("t", 2).time(1e9, 1e9 + 0.003, 0.001).build().time().steps(), 3);
  EXPECT_NE(checked(1e9, 1e9 + 0.0035, 0.001).find("; a whole number of steps is wanted"), std::string::npos);
  EXPECT_EQ(checked(0, 1e12, 1), "");
  EXPECT_EQ(checked(0, 2e12, 1), "/time/step: (end - start) / step is 2e+12; more than 1e+12 steps are not possible");
  EXPECT_EQ(checked(-1e308, 1e308, 1),
            "/time/step: (end - start) / step is inf; more than 1e+12 steps are not possible");
  EXPECT_EQ(checked(1e15, 1e15 + 1, 0.5),
            "/time/step: the step of 0.5 s is lost in rounding: around 1000000000000001 s doubles are 0.125 s apart; "
            "take times nearer to 0, or longer steps");
}

TEST(Scene, WithOutputsChecksTheOutputs) {
  const Scene scene = four_bar().build();
  const Scene other = scene.with_outputs({"B.velocity", "rocker_angle.rate"});
  EXPECT_EQ(other.outputs().size(), 2u);
  EXPECT_EQ(scene.outputs().size(), 1u);
  EXPECT_EQ(findings([&] {
              return scene.with_outputs({"C", "Bb", "C.speed"});
            }),
            "/outputs/1: there is no point, vector or measure 'Bb'; did you mean 'B'?\n"
            "/outputs/2: 'C' has no part 'speed'; expected position, velocity, acceleration, x, y, vx, vy, ax or ay");
}

TEST(Scene, WithTimeChecksTablesAndLengths) {
  SceneBuilder builder("table", 2);
  builder.point("A", {0, 0, 0}).time(0, 1, 0.5);
  builder.drive("push", DrivenCoordinate{"A.x", Law::table({0, 1}, {0, 1})});
  const Scene scene = builder.build();
  EXPECT_EQ(scene.with_time({0, 0.5, 0.25}).time().steps(), 2);
  EXPECT_EQ(
      findings([&] {
        return scene.with_time({0, 2, 0.5});
      }),
      "/drivers/push/law: its table goes from t = 0 s to 1 s, the time grid from 0 s to 2 s; the table must cover the "
      "grid or be "
      "periodic");
  EXPECT_EQ(findings([&] { return scene.with_time({0, 1, -1}); }), "/time/step: the step is -1 s; it must be > 0");
  EXPECT_EQ(scene.with_time({0.5, 0.5, 0.25}).time().steps(), 0);  // one posture
  // A distance that fits at one start may not fit at another; members of a body keep their place.
  SceneBuilder rod("rod", 2);
  rod.fixed_point("O", {0, 0, 0}).point("A", {1, 0, 0}).point("B", {2, 0, 0}).time(1, 2, 0.5);
  rod.add(Body{"bar", "", {}, {"A", "B"}, {{"M", {0, 1, 0}}}, {}});
  rod.drive("pull", DrivenDistance{"O", "M", Law::polynomial({0, 1})});
  rod.drive("turn", PointAngle{"O", "M", "", Law::polynomial({0, 1})});
  EXPECT_EQ(rod.build().with_time({0.5, 1, 0.5}).time().start, 0.5);
  EXPECT_EQ(findings([&] {
              return rod.build().with_time({0, 1, 0.5});
            }),
            "/drivers/pull/law: the distance at the start is 0 m; a driven distance must stay > 0");
  // A time grid of 1e-10 steps is an error, not a rounded step.
  EXPECT_EQ(findings([&] {
              return scene.with_time({0, 1, 1e10});
            }),
            "/time/step: (end - start) / step is 1e-10; a whole number of steps is wanted, e.g. to the end 1e+10");
}

}  // namespace
}  // namespace assur
