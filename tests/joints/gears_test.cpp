// Gears and racks between coordinates of joints.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "assur/ensemble.hpp"
#include "joints/gear.hpp"
#include "scene/triple.hpp"
#include "simulation/run.hpp"
#include "structure/grouped_system.hpp"

namespace assur {
namespace {

constexpr double kPi = std::numbers::pi;

Law turning(double speed) { return Law::polynomial({0, speed}); }

// Crank and last link of a five-bar turn in this ratio.
Scene five_bar(double ratio, double last = 0.2) {
  return SceneBuilder("geared five-bar", 2)
      .add(Body{.name = "crank"})
      .add(Body{.name = "left"})
      .add(Body{.name = "right"})
      .add(Body{.name = "follower"})
      .joint("A", Revolute{"ground", "crank", Triple{0, 0}})
      .joint("B", Revolute{"crank", "left", Triple{0.3, 0}})
      .joint("C", Revolute{"left", "right", Triple{0.8, 1}})
      .joint("D", Revolute{"right", "follower", Triple{1.2, last}})
      .joint("E", Revolute{"ground", "follower", Triple{1.2, 0}})
      .constrain("gear", Gear{"A.angle", "E.angle", ratio})
      .drive("motor", DrivenCoordinate{"A.angle", turning(2 * kPi)})
      .output("B")
      .output("C")
      .output("D")
      .output("E.angle")
      .time(0, 3, 0.01)
      .build();
}

TEST(Gears, GearedFiveBarTurnsInItsRatio) {
  for (const double ratio : {1.0, -1.0, -2.0, 0.5, -2.0 / 3, 3.0}) {
    SCOPED_TRACE(ratio);
    const test::Result r = test::run(five_bar(ratio));
    EXPECT_EQ(r.report().status.code, Code::ok);
    const Trajectory& t = r.trajectory;
    ASSERT_EQ(t.rows(), 301u);
    const auto at = [&](std::size_t row, const char* name) {
      return Triple{t(row, t.index(std::string(name) + ".x")), t(row, t.index(std::string(name) + ".y")), 0};
    };
    const auto length = [&](std::size_t row, const char* p, const char* q) {
      return triple::norm(triple::subtract(at(row, p), at(row, q)));
    };
    for (std::size_t k = 0; k < t.rows(); ++k) {
      const double phi = 2 * kPi * t.times()[k], psi = ratio * phi;
      EXPECT_NEAR(t(k, t.index("E.angle")), psi, 1e-13);
      EXPECT_NEAR(t(k, t.index("E.angle.rate")), 2 * kPi * ratio, 1e-11);
      EXPECT_NEAR(t(k, t.index("E.angle.acceleration")), 0, 1e-9);
      EXPECT_NEAR(at(k, "D")[0], 1.2 - 0.2 * std::sin(psi), 1e-14);
      EXPECT_NEAR(at(k, "D")[1], 0.2 * std::cos(psi), 1e-14);
      EXPECT_NEAR(length(k, "B", "C"), length(0, "B", "C"), 1e-14);
      EXPECT_NEAR(length(k, "D", "C"), length(0, "D", "C"), 1e-14);
    }
  }
}

// Members with gears share tiles if the ratios are equal, and move as alone.
TEST(Gears, MembersShareTiles) {
  const auto member = [](std::size_t m) { return five_bar(m == 6 ? -1.0 : -2.0, 0.18 + 0.005 * double(m)); };
  for (const char* lanes : {"lanes:4", "lanes:8"}) {
    const std::string strategy = std::string("irreducible/") + lanes;
    Ensemble ensemble(8, [&](std::size_t m) { return prepare(member(m), {.strategy = strategy}); });
    const EnsembleTrajectory together = ensemble.run();
    for (std::size_t m = 0; m < 8; ++m) {
      EXPECT_EQ(ensemble.outcomes()[m].alone, m == 6);
      const Trajectory alone = test::run(member(m), strategy).trajectory;
      ASSERT_EQ(together.rows(m), alone.rows());
      const auto row = together.row(m, 0);
      EXPECT_TRUE(std::equal(alone.values().begin(), alone.values().end(), row.data())) << lanes << ' ' << m;
    }
  }
}

// A nut on a helix: a gear between both coordinates of one cylindrical joint, driven by either of them.
TEST(Gears, BetweenBothCoordinatesOfAJointMakeAScrew) {
  const double pitch = 0.004, radius = 0.1;  // m
  for (const bool by_angle : {true, false}) {
    const std::string driven = by_angle ? "S.angle" : "S.displacement";
    const Scene scene = SceneBuilder("screw", 3)
                            .add(Body{.name = "nut", .points = {{"P", {radius, 0, 0}, true}}})
                            .joint("S", Cylindrical{"ground", "nut", Triple{0, 0, 0}, Triple{0, 0, 1}})
                            .constrain("thread", Gear{"S.angle", "S.displacement", pitch / (2 * kPi)})
                            .drive("motor", DrivenCoordinate{driven, turning(by_angle ? 2 * kPi : pitch)})
                            .output("P")
                            .output("S.angle")
                            .time(0, 3, 0.05)
                            .build();
    for (const char* strategy : {"auto", "irreducible/eigen"}) {
      SCOPED_TRACE(driven + " " + strategy);
      const Trajectory t = test::run(scene, strategy).trajectory;
      ASSERT_EQ(t.rows(), 61u);
      for (std::size_t k = 0; k < t.rows(); ++k) {
        const double turns = t.times()[k], angle = 2 * kPi * turns;
        EXPECT_NEAR(t(k, t.index("S.angle")), angle, 1e-10);  // lengths of 1e-16 m are 2e-13 rad on this thread
        EXPECT_NEAR(t(k, t.index("P.x")), radius * std::cos(angle), 1e-11);
        EXPECT_NEAR(t(k, t.index("P.y")), radius * std::sin(angle), 1e-11);
        EXPECT_NEAR(t(k, t.index("P.z")), pitch * turns, 1e-13);
        EXPECT_NEAR(t(k, t.index("P.vz")), pitch, 1e-12);
      }
    }
  }
}

// The rod of a slider-crank, which no driver turns, moves a wheel.
TEST(Gears, WheelFollowsAnAngleThatIsSolved) {
  const Scene scene = SceneBuilder("slider-crank with a wheel", 2)
                          .add(Body{.name = "crank"})
                          .add(Body{.name = "rod"})
                          .add(Body{.name = "piston"})
                          .add(Body{.name = "wheel", .points = {{"P", {1, 1.1, 0}, true}}})
                          .joint("O", Revolute{"ground", "crank", Triple{0, 0}})
                          .joint("B", Revolute{"crank", "rod", Triple{0.1, 0}})
                          .joint("C", Revolute{"rod", "piston", Triple{0.4, 0}})
                          .joint("S", Prismatic{"ground", "piston", Triple{1, 0}})
                          .joint("W", Revolute{"ground", "wheel", Triple{1, 1}})
                          .constrain("gear", Gear{"C.angle", "W.angle", 17.0 / 31})
                          .drive("motor", DrivenCoordinate{"O.angle", turning(1)})
                          .output("W.angle")
                          .time(0, 13, 0.05)
                          .build();
  const Trajectory t = test::run(scene).trajectory;
  for (std::size_t k = 0; k < t.rows(); ++k) {
    const double c = std::asin(0.1 / 0.3 * std::sin(t.times()[k]));
    EXPECT_NEAR(t(k, t.index("W.angle")), 17.0 / 31 * c, 1e-14);
  }
}

TEST(Gears, PinionMovesItsRack) {
  const double radius = 0.05;
  for (const bool pinion_drives : {true, false}) {
    SceneBuilder builder("rack", 2);
    builder.add(Body{.name = "pinion", .points = {{"P", {0.03, 0.04, 0}, true}}})
        .add(Body{.name = "rack", .points = {{"Q", {1, 0, 0}, true}}})
        .joint("A", Revolute{"ground", "pinion", Triple{0, 0}})
        .joint("S", Prismatic{"ground", "rack", Triple{1, 0}})
        .output("A.angle")
        .output("S.displacement")
        .time(0, 1, 0.005);
    if (pinion_drives) {
      builder.constrain("gear", Gear{"A.angle", "S.displacement", radius});
      builder.drive("motor", DrivenCoordinate{"A.angle", turning(20)});
    } else {
      builder.constrain("gear", Gear{"S.displacement", "A.angle", 1 / radius});
      builder.drive("cylinder", DrivenCoordinate{"S.displacement", turning(20 * radius)});
    }
    const Trajectory t = test::run(builder.build()).trajectory;
    ASSERT_EQ(t.rows(), 201u);
    for (std::size_t k = 0; k < t.rows(); ++k) {
      EXPECT_NEAR(t(k, t.index("A.angle")), 20 * t.times()[k], 1e-13) << pinion_drives;
      EXPECT_NEAR(t(k, t.index("S.displacement")), 20 * radius * t.times()[k], 1e-14) << pinion_drives;
    }
  }
}

// The axes of bevel gears meet at any angle.
TEST(Gears, BevelGearsTurnAboutAxesInSpace) {
  const Scene scene = SceneBuilder("bevel gears", 3)
                          .add(Body{.name = "first"})
                          .add(Body{.name = "second", .points = {{"P", {0.4, 0.7, 0.1}, true}}})
                          .joint("A", Revolute{"ground", "first", Triple{0, 0, 0}, Triple{0, 0, 1}})
                          .joint("B", Revolute{"ground", "second", Triple{0, 0, 0}, Triple{1, 0.2, 0.5}})
                          .constrain("gear", Gear{"A.angle", "B.angle", -20.0 / 30})
                          .drive("motor", DrivenCoordinate{"A.angle", turning(3)})
                          .output("B.angle")
                          .output("P")
                          .time(0, 5, 0.02)
                          .build();
  const Trajectory t = test::run(scene).trajectory;
  ASSERT_EQ(t.rows(), 251u);
  const Triple axis = triple::scale(1 / std::sqrt(1.29), {1, 0.2, 0.5}), p = {0.4, 0.7, 0.1};
  for (std::size_t k = 0; k < t.rows(); ++k) {
    const double angle = -2 * t.times()[k], c = std::cos(angle), s = std::sin(angle);
    EXPECT_NEAR(t(k, t.index("B.angle")), angle, 1e-13);
    const Triple turned = triple::add(
        triple::scale(c, p),
        triple::add(triple::scale(s, triple::cross(axis, p)), triple::scale((1 - c) * triple::dot(axis, p), axis)));
    EXPECT_NEAR(t(k, t.index("P.x")), turned[0], 1e-14);
    EXPECT_NEAR(t(k, t.index("P.y")), turned[1], 1e-14);
    EXPECT_NEAR(t(k, t.index("P.z")), turned[2], 1e-14);
  }
}

// Steps of the driver in which the wheels pass many teeth.
TEST(Gears, LongStepsSkipNoTooth) {
  for (const double ratio : {31.0 / 17, -97.0 / 100, 500.0, 3.0 / 250}) {
    SCOPED_TRACE(ratio);
    const Scene scene = SceneBuilder("wheels", 2)
                            .add(Body{.name = "first"})
                            .add(Body{.name = "second", .points = {{"P", {1, 0.3, 0}, true}}})
                            .joint("A", Revolute{"ground", "first", Triple{0, 0}})
                            .joint("B", Revolute{"ground", "second", Triple{1, 0}})
                            .constrain("gear", Gear{"A.angle", "B.angle", ratio})
                            .drive("motor", DrivenCoordinate{"A.angle", turning(2)})
                            .output("P")
                            .time(0, 5, 1)
                            .build();
    for (const char* strategy : {"auto", "irreducible/eigen", "irreducible/lanes:4+chunks=2"}) {
      const test::Result r = test::run(scene, strategy);
      EXPECT_EQ(r.report().status.code, Code::ok) << strategy;
      const Trajectory& t = r.trajectory;
      ASSERT_EQ(t.rows(), 6u);
      for (std::size_t k = 0; k < t.rows(); ++k) {
        const double angle = ratio * 2 * t.times()[k];
        EXPECT_NEAR(t(k, t.index("P.x")), 1 - 0.3 * std::sin(angle), 1e-12) << strategy << ' ' << k;
        EXPECT_NEAR(t(k, t.index("P.y")), 0.3 * std::cos(angle), 1e-12) << strategy << ' ' << k;
      }
    }
  }
}

// Two wheels on the ground, or on an arm that stands at `arm`; the law of the first wheel begins at `start`.
SceneBuilder wheels(double ratio, const Law& law, double arm = 0) {
  SceneBuilder b("wheels", 2);
  b.add(Body{.name = "arm"})
      .add(Body{.name = "a"})
      .add(Body{.name = "b"})
      .joint("O", Revolute{"ground", "arm", Triple{0, 0}})
      .joint("A", Revolute{"arm", "a", Triple{0, 0}})
      .joint("B", Revolute{"arm", "b", Triple{1, 0}})
      .constrain("gear", Gear{"A.angle", "B.angle", ratio})
      .drive("arm_motor", DrivenCoordinate{"O.angle", Law::constant(arm)})
      .drive("motor", DrivenCoordinate{"A.angle", law})
      .output("B.angle")
      .time(0, 1, 0.5);
  return b;
}

double turns_apart(double a, double b) { return std::remainder(a - b, 2 * kPi); }

// The law need not begin at 0, where the wheels are as written.
TEST(Gears, StartOnTheToothToWhichTheWheelsTurn) {
  for (const double ratio : {-0.5, -20.0 / 13, 2.0 / 3, 3.0, 17.0 / 31}) {
    for (const double start : {0.0, 0.5, 3.2, 6.7, -9.0, 40.0}) {
      for (const double arm : {0.0, 0.5, 4.0}) {
        SCOPED_TRACE(testing::Message() << ratio << ' ' << start << ' ' << arm);
        const test::Result r = test::run(wheels(ratio, Law::polynomial({start, 0.5}), arm).build());
        EXPECT_EQ(r.report().status.code, Code::ok);
        const Trajectory& t = r.trajectory;
        ASSERT_EQ(t.rows(), 3u);
        for (std::size_t k = 0; k < t.rows(); ++k) {
          const double wanted = ratio * (start + 0.5 * t.times()[k]);
          EXPECT_NEAR(turns_apart(t(k, t.index("B.angle")), wanted), 0, 1e-12 * (1 + std::abs(wanted)));
        }
      }
    }
  }
}

// After 13 turns of the first wheel both are as written, so that many turns need not be made.
TEST(Gears, StartAfterThousandsOfTurns) {
  const double start = 2 * kPi * (13 * 1000 + 5) + 0.3, ratio = -20.0 / 13;
  for (const double sign : {1.0, -1.0}) {
    const test::Result r = test::run(wheels(ratio, Law::polynomial({sign * start, 0.5}), 0.5).build());
    EXPECT_EQ(r.report().status.code, Code::ok);
    const double wanted = ratio * sign * (2 * kPi * 5 + 0.3);
    EXPECT_NEAR(turns_apart(r.trajectory(0, r.trajectory.index("B.angle")), wanted), 0, 1e-9);  // rounding of `start`
  }
}

TEST(Gears, ALaterStartIsOnTheToothOfTheMotion) {
  const Scene scene = five_bar(-2.0 / 3);
  const Trajectory all = test::run(scene).trajectory, late = test::run(scene.with_time({1.6, 3, 0.01})).trajectory;
  ASSERT_EQ(late.rows(), 141u);
  for (const char* column : {"B.x", "C.x", "C.y", "D.x", "D.y"}) {
    for (std::size_t k = 0; k < late.rows(); ++k) {
      EXPECT_NEAR(late(k, late.index(column)), all(k + 160, all.index(column)), 1e-12) << column << ' ' << k;
    }
  }
}

// A displacement determines whole turns of its pinion, and another wheel on the pinion shows them.
TEST(Gears, ARackStartsWhereItsPinionTurnsIt) {
  const double radius = 0.05, ratio = 2.0 / 3;
  for (const bool pinion_drives : {true, false}) {
    SceneBuilder builder("rack", 2);
    for (const char* name : {"pinion", "rack", "wheel"}) builder.add(Body{.name = name});
    builder.joint("A", Revolute{"ground", "pinion", Triple{0, 0}})
        .joint("S", Prismatic{"ground", "rack", Triple{1, 0}})
        .joint("B", Revolute{"ground", "wheel", Triple{1, 0}})
        .constrain("teeth", Gear{"A.angle", "S.displacement", radius})
        .constrain("wheels", Gear{"A.angle", "B.angle", ratio})
        .output("A.angle")
        .output("B.angle")
        .output("S.displacement")
        .time(0, 1, 0.125);
    if (pinion_drives) {
      builder.drive("motor", DrivenCoordinate{"A.angle", Law::polynomial({50, 1})});
    } else {
      builder.drive("cylinder", DrivenCoordinate{"S.displacement", Law::polynomial({50 * radius, radius})});
    }
    const Trajectory t = test::run(builder.build()).trajectory;
    ASSERT_EQ(t.rows(), 9u);
    for (std::size_t k = 0; k < t.rows(); ++k) {
      const double angle = 50 + t.times()[k];
      EXPECT_NEAR(turns_apart(t(k, t.index("A.angle")), angle), 0, 1e-11) << pinion_drives;
      EXPECT_NEAR(turns_apart(t(k, t.index("B.angle")), ratio * angle), 0, 1e-11) << pinion_drives;
      EXPECT_NEAR(t(k, t.index("S.displacement")), radius * angle, 1e-12) << pinion_drives;
    }
  }
}

// An angle between points does not count whole turns: the wheels turn the shorter way, and a note reports this.
TEST(Gears, OnlyCoordinatesCountWholeTurns) {
  const auto by_points = [](double start) {
    return SceneBuilder("wheels", 2)
        .add(Body{.name = "a", .points = {{"P", {0, -0.5, 0}, true}}})
        .add(Body{.name = "b"})
        .joint("A", Revolute{"ground", "a", Triple{0, 0}})
        .joint("B", Revolute{"ground", "b", Triple{1, 0}})
        .constrain("gear", Gear{"A.angle", "B.angle", -0.5})
        .drive("motor", PointAngle{"A", "P", "", Law::polynomial({start, 1})})
        .output("B.angle")
        .time(0, 1, 0.5)
        .build();
  };
  for (const double turns : {0.0, 1.0}) {
    const Scene scene = by_points(-kPi / 2 + 0.2 + 2 * kPi * turns);
    const Trajectory t = test::run(scene).trajectory;
    EXPECT_NEAR(t(0, t.index("B.angle")), -0.1, 1e-14);
    const std::vector<Diagnostic> notes = group_equations(scene).notes;
    EXPECT_EQ(std::count_if(notes.begin(), notes.end(),
                            [](const Diagnostic& n) {
                              return n.where == "/drivers/motor" && n.what.starts_with("the driver does not count");
                            }),
              turns == 0 ? 0 : 1);
  }
}

TEST(Gears, AStartThatCannotBeReachedIsRefused) {
  const GroupedSystem far = group_equations(wheels(2.0 / 201, Law::constant(1e9)).build());
  EXPECT_TRUE(far.cannot_assemble.starts_with("the start posture cannot be reached: ")) << far.cannot_assemble;
  EXPECT_NE(far.cannot_assemble.find("which teeth of the gears mesh"), std::string::npos) << far.cannot_assemble;
  // also if the direct way finds no posture, in the place of residuals that are not numbers
  try {
    (void)prepare(SceneBuilder("rack", 2)
                      .add(Body{.name = "pinion"})
                      .add(Body{.name = "bar"})
                      .joint("A", Revolute{"ground", "pinion", Triple{0, 0}})
                      .joint("S", Prismatic{"ground", "bar", Triple{1, 0}})
                      .constrain("teeth", Gear{"A.angle", "S.displacement", 1e-6})
                      .drive("cylinder", DrivenCoordinate{"S.displacement", Law::polynomial({3, 1})})
                      .output("A.angle")
                      .time(0, 1e-6, 1e-7)
                      .build());
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find("is nan"), std::string::npos) << error.what();
  }
}

TEST(Gears, RatiosAreThoseOfWholeNumbers) {
  const auto ratio = [](double x) { return whole_ratio(x).value_or(std::pair(0, 0)); };
  EXPECT_EQ(ratio(2), std::pair(2, 1));
  EXPECT_EQ(ratio(-0.5), std::pair(-1, 2));
  EXPECT_EQ(ratio(0.6666666667), std::pair(2, 3));
  EXPECT_EQ(ratio(997.0 / 1000), std::pair(997, 1000));
  EXPECT_EQ(ratio(1000), std::pair(1000, 1));
  EXPECT_EQ(ratio(std::numbers::pi), std::pair(0, 0));
  EXPECT_EQ(ratio(1001), std::pair(0, 0));
  EXPECT_EQ(ratio(1e-5), std::pair(0, 0));
}

std::string refusal(const std::string& gear) {
  try {
    (void)parse_scene(R"({"assur": 1, "dimension": 2, "bodies": {"a": {}, "b": {}}, "joints": {
      "A": {"revolute": ["ground", "a"], "at": [0, 0]}, "B": {"revolute": ["ground", "b"], "at": [1, 0]}},
      "constraints": {"g": )" +
                      gear + R"(}, "drivers": {"m": {"coordinate": "A.angle", "law": {"constant": 0}}}})");
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Gears, NameInvalidInput) {
  EXPECT_EQ(refusal(R"({"gear": ["A.angle", "B.angle"], "ratio": -2})"), "accepted");
  EXPECT_EQ(refusal(R"({"gear": ["A.angle", "B.angle"], "ratio": 0})"),
            "scene: /constraints/g/ratio: the ratio is 0; it must be finite and not 0");
  EXPECT_EQ(
      refusal(R"({"gear": ["A.angle", "B.angle"], "ratio": 3.14159})"),
      "scene: /constraints/g/ratio: the ratio of two angles is that of whole numbers up to 1000, as of teeth, within "
      "1e-9; 3.14159 is not");
  EXPECT_EQ(refusal(R"({"gear": ["A.angle", "A.angle"], "ratio": 1})"),
            "scene: /constraints/g/gear: both coordinates are 'A.angle'");
  EXPECT_EQ(refusal(R"({"gear": ["A.angle", "C.angle"], "ratio": 1})"),
            "scene: /constraints/g/gear/1: 'C.angle' is no coordinate of a joint; write JOINT.angle or "
            "JOINT.displacement");
  EXPECT_EQ(refusal(R"({"gear": ["A.angle", "B.displacement"], "ratio": 1})"),
            "scene: /constraints/g/gear/1: joint 'B' is revolute and has no displacement; it has: angle");
  EXPECT_EQ(refusal(R"({"gear": ["A.angle", "B.angle"]})"),
            "scene: /constraints/g/ratio: this is missing: the motion of the second coordinate by that of the first");
}

}  // namespace
}  // namespace assur
