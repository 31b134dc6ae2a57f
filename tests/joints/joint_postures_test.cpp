// Each kind of joint between a body that moves as chosen and a second body, with axes all over the sphere and over full
// turns of the joint: its freedoms, its motion, and a condition that depends on neither.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "errors/conditions.hpp"
#include "scene/triple.hpp"
#include "simulation/run.hpp"
#include "structure/grouped_system.hpp"

namespace assur {
namespace {

constexpr double kPi = std::numbers::pi;

// Directions all over the sphere, the poles, the axes and a direction close to one among them.
std::vector<Triple> directions() {
  std::vector<Triple> all = {{1e-9, 1e-9, 1}, {-1e-5, 1, 0}};
  for (int i = 0; i <= 4; ++i) {
    const double polar = kPi * i / 4;
    for (int k = 0; k < (i % 4 == 0 ? 1 : 8); ++k) {
      const double azimuth = 2 * kPi * k / 8;
      all.push_back({std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar)});
    }
  }
  return all;
}

Triple square_to(const Triple& axis) {
  const Triple x = triple::cross(axis, {1, 0, 0}), y = triple::cross(axis, {0, 1, 0});
  return triple::norm(x) > triple::norm(y) ? x : y;
}

Triple unit(const Triple& a) { return triple::scale(1 / triple::norm(a), a); }

// v turned about a unit axis.
Triple turned(const Triple& axis, double angle, const Triple& v) {
  const Triple along = triple::scale(triple::dot(axis, v), axis), flat = triple::subtract(v, along);
  return triple::add(
      along, triple::add(triple::scale(std::cos(angle), flat), triple::scale(std::sin(angle), triple::cross(axis, v))));
}

double worst_condition(const Scene& scene) {
  double worst = 1;
  for (const test::Condition& c : test::both_conditions(scene, test::grid_of(scene))) worst = std::max(worst, c.own);
  return worst;
}

const Triple kAt = {0.3, -0.2, 0.4}, kOrigin = {0, 0, 0};

// The body `arm` turns about z; the joint connects it and `hand`.
SceneBuilder arm(bool swap, const auto& joint) {
  const std::string a = swap ? "hand" : "arm", b = swap ? "arm" : "hand";
  SceneBuilder builder("joint", 3);
  builder.add(Body{.name = "arm"})
      .add(Body{.name = "hand", .points = {{"T", {0.9, 0.5, 0.1}, true}, {"V", {0.2, 0.8, -0.6}, true}}})
      .joint("base", Revolute{"ground", "arm", Triple{0, 0, 0}, Triple{0, 0, 1}})
      .drive("motor", DrivenCoordinate{"base.angle", Law::polynomial({0, 2 * kPi})});
  builder.joint("J", joint(a, b));
  return std::move(builder.time(0, 1, 1.0 / 24));
}

// The place of the point that was at p, if the hand has turned and moved along the axis of J.
Triple expected(const Triple& p, const Triple& axis, double angle, double way, double time) {
  const Triple in_arm =
      triple::add(triple::add(kAt, turned(axis, angle, triple::subtract(p, kAt))), triple::scale(way, axis));
  return turned({0, 0, 1}, 2 * kPi * time, in_arm);
}

void expect_hand(const Scene& scene, const Triple& axis, double turn, double way, double most) {
  const double kappa = worst_condition(scene);
  EXPECT_LT(kappa, most);
  const test::Result run = test::run(scene);
  ASSERT_EQ(run.report().status.code, Code::ok);
  const Trajectory& t = run.trajectory;
  for (std::size_t k = 0; k < t.rows(); ++k) {
    const double time = t.times()[k];
    for (const auto& [name, p] : {std::pair("T", Triple{0.9, 0.5, 0.1}), std::pair("V", Triple{0.2, 0.8, -0.6})}) {
      const Triple e = expected(p, unit(axis), turn * time, way * time, time);
      for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(t(k, t.index(std::string(name) + "." + "xyz"[i])), e[i], 32 * kappa * kEps) << name << " row " << k;
      }
    }
  }
}

std::int64_t mobility(SceneBuilder builder) { return group_equations(builder.build()).mobility; }

constexpr double kTurn = 2 * kPi;

TEST(JointPostures, RevoluteTurnsAboutEveryAxis) {
  for (const Triple& axis : directions()) {
    for (const bool swap : {false, true}) {
      SCOPED_TRACE(testing::PrintToString(axis));
      SceneBuilder b = arm(swap, [&](auto& p, auto& q) { return Revolute{p, q, kAt, axis}; });
      EXPECT_EQ(mobility(b), 2);
      b.drive("turn", DrivenCoordinate{"J.angle", Law::polynomial({0, swap ? kTurn : -kTurn})});
      expect_hand(b.build(), axis, -kTurn, 0, 400);
    }
  }
}

TEST(JointPostures, PrismaticSlidesAlongEveryAxis) {
  for (const Triple& axis : directions()) {
    for (const bool swap : {false, true}) {
      SCOPED_TRACE(testing::PrintToString(axis));
      SceneBuilder b = arm(swap, [&](auto& p, auto& q) { return Prismatic{p, q, axis}; });
      EXPECT_EQ(mobility(b), 2);
      b.drive("slide", DrivenCoordinate{"J.displacement", Law::polynomial({0, swap ? -0.7 : 0.7})});
      expect_hand(b.build(), axis, 0, 0.7, 400);
    }
  }
}

TEST(JointPostures, CylindricalTurnsAndSlidesAboutEveryAxis) {
  for (const Triple& axis : directions()) {
    for (const bool swap : {false, true}) {
      SCOPED_TRACE(testing::PrintToString(axis));
      SceneBuilder b = arm(swap, [&](auto& p, auto& q) { return Cylindrical{p, q, kAt, axis}; });
      EXPECT_EQ(mobility(b), 3);
      const double sign = swap ? -1 : 1;
      b.drive("turn", DrivenCoordinate{"J.angle", Law::polynomial({0, sign * kTurn})});
      b.drive("slide", DrivenCoordinate{"J.displacement", Law::polynomial({0, sign * 0.7})});
      expect_hand(b.build(), axis, kTurn, 0.7, 400);
    }
  }
}

TEST(JointPostures, FixedHoldsTheHand) {
  for (const bool swap : {false, true}) {
    const SceneBuilder b = arm(swap, [&](auto& p, auto& q) { return Fixed{p, q}; });
    EXPECT_EQ(mobility(b), 1);
    expect_hand(b.build(), {0, 0, 1}, 0, 0, 100);
  }
}

TEST(JointPostures, SphericalHasThreeFreedomsInEveryPosture) {
  for (const Triple& axis : directions()) {
    for (const bool swap : {false, true}) {
      SCOPED_TRACE(testing::PrintToString(axis));
      // An arm with three revolute joints whose axes meet, which turn the hand all over: the wrist is at right angles
      // to both neighbours as written, so that it is regular.
      const Triple u = unit(axis), v = unit(square_to(axis)), w = triple::cross(u, v);
      SceneBuilder b("ball", 3);
      b.add(Body{.name = "one"}).add(Body{.name = "two"});
      b.add(Body{.name = "hand", .points = {{"T", {0.9, 0.5, 0.1}, true}, {"V", {0.2, 0.8, -0.6}, true}}});
      b.joint("S", swap ? Spherical{"hand", "ground", kAt} : Spherical{"ground", "hand", kAt});
      EXPECT_EQ(mobility(SceneBuilder(b).joint("A", Fixed{"ground", "one"}).joint("B", Fixed{"one", "two"})), 3);
      b.joint("A", Revolute{"ground", "one", kAt, u}).joint("B", Revolute{"one", "two", kAt, v});
      b.joint("C", Revolute{"two", "hand", kAt, w});
      b.drive("a", DrivenCoordinate{"A.angle", Law::polynomial({0, kTurn})});
      b.drive("b", DrivenCoordinate{"B.angle", Law::polynomial({0, 2 * kTurn})});
      b.drive("c", DrivenCoordinate{"C.angle", Law::polynomial({0, -kTurn})});
      const Scene scene = b.time(0, 1, 1.0 / 48).build();
      const double kappa = worst_condition(scene);
      EXPECT_LT(kappa, 1000);
      const test::Result run = test::run(scene);
      ASSERT_EQ(run.report().status.code, Code::ok);
      const Trajectory& t = run.trajectory;
      for (std::size_t k = 0; k < t.rows(); ++k) {
        const double s = kTurn * t.times()[k];
        const Triple p = triple::subtract({0.9, 0.5, 0.1}, kAt);
        const Triple e = triple::add(kAt, turned(u, s, turned(v, 2 * s, turned(w, -s, p))));
        for (std::size_t i = 0; i < 3; ++i) {
          EXPECT_NEAR(t(k, t.index(std::string("T.") + "xyz"[i])), e[i], 32 * kappa * kEps) << k;
        }
      }
    }
  }
}

// The second shaft of a universal joint turns once, with the angle of the closed form.
TEST(JointPostures, UniversalTurnsInEveryDirectionOfItsShafts) {
  const double bend = 0.7;
  for (const Triple& axis : directions()) {
    for (const bool swap : {false, true}) {
      SCOPED_TRACE(testing::PrintToString(axis));
      const Triple u = unit(axis), v = unit(square_to(axis)), out = turned(v, bend, u), w = triple::cross(v, out);
      SceneBuilder b("cardan", 3);
      b.add(Body{.name = "in"}).add(Body{.name = "out", .points = {{"T", {0.9, 0.5, 0.1}, true}}});
      b.joint("A", Revolute{"ground", "in", kAt, u});
      b.joint("U", swap ? Universal{"out", "in", kAt, w, v} : Universal{"in", "out", kAt, v, w});
      EXPECT_EQ(mobility(b), 3);
      b.joint("B", Revolute{"ground", "out", triple::add(kAt, out), out});
      EXPECT_EQ(mobility(b), 1);
      b.drive("motor", DrivenCoordinate{"A.angle", Law::polynomial({0, kTurn})}).output("B.angle");
      const Scene scene = b.time(0, 1, 1.0 / 48).build();
      const double kappa = worst_condition(scene);
      EXPECT_LT(kappa, 400);
      const test::Result run = test::run(scene);
      ASSERT_EQ(run.report().status.code, Code::ok);
      for (std::size_t k = 0; k < run.trajectory.rows(); ++k) {
        // The axis v of the first shaft turns in its plane; w stays at right angles to it and to the second shaft.
        const Triple now = triple::cross(turned(u, kTurn * run.trajectory.times()[k], v), out);
        const double angle = std::atan2(triple::dot(out, triple::cross(w, now)), triple::dot(w, now));
        const double off = run.trajectory(k, run.trajectory.index("B.angle")) - angle;
        EXPECT_NEAR(std::remainder(off, kTurn), 0, 32 * kappa * kEps) << k;
      }
    }
  }
}

// A table with two slides at right angles and a revolute joint moves the hand in the plane of the planar joint.
TEST(JointPostures, PlanarHasThreeFreedomsInEveryDirection) {
  const Triple T = {0.9, 0.5, 0.1};
  for (const Triple& axis : directions()) {
    for (const bool swap : {false, true}) {
      SCOPED_TRACE(testing::PrintToString(axis));
      const Triple u = unit(axis), v = unit(square_to(axis)), w = triple::cross(u, v);
      SceneBuilder b("table", 3);
      b.add(Body{.name = "hand", .points = {{"T", T, true}, {"V", {0.2, 0.8, -0.6}, true}}});
      b.joint("E", swap ? Planar{"hand", "ground", u} : Planar{"ground", "hand", u});
      EXPECT_EQ(mobility(b), 3);
      b.add(Body{.name = "one"}).add(Body{.name = "two"});
      b.joint("X", Prismatic{"ground", "one", v}).joint("Y", Prismatic{"one", "two", w});
      b.joint("A", Revolute{"two", "hand", kAt, u});
      EXPECT_EQ(mobility(b), 3);
      b.drive("x", DrivenCoordinate{"X.displacement", Law::polynomial({0, 0.8})});
      b.drive("y", DrivenCoordinate{"Y.displacement", Law::polynomial({0, -0.6})});
      b.drive("a", DrivenCoordinate{"A.angle", Law::polynomial({0, kTurn})});
      const Scene scene = b.time(0, 1, 1.0 / 24).build();
      const double kappa = worst_condition(scene);
      EXPECT_LT(kappa, 400);
      const test::Result run = test::run(scene);
      ASSERT_EQ(run.report().status.code, Code::ok);
      for (std::size_t k = 0; k < run.trajectory.rows(); ++k) {
        const double time = run.trajectory.times()[k];
        const Triple turn = triple::add(kAt, turned(u, kTurn * time, triple::subtract(T, kAt)));
        const Triple e = triple::add(turn, triple::add(triple::scale(0.8 * time, v), triple::scale(-0.6 * time, w)));
        for (std::size_t i = 0; i < 3; ++i) {
          const double off = run.trajectory(k, run.trajectory.index(std::string("T.") + "xyz"[i])) - e[i];
          EXPECT_NEAR(off, 0, 32 * kappa * kEps) << k;
        }
      }
    }
  }
}

// Bodies whose features are all on one line lead the turn of the first body to the last one.
TEST(JointPostures, CoaxialJointsLeadTheTurnToTheHand) {
  for (const Triple& axis : directions()) {
    for (const bool driven : {false, true}) {
      SCOPED_TRACE(testing::PrintToString(axis));
      const Triple u = unit(axis);
      SceneBuilder b("spindle", 3);
      b.add(Body{.name = "column"}).add(Body{.name = "quill"});
      b.add(Body{.name = "hand", .points = {{"T", {0.9, 0.5, 0.1}, true}, {"V", {0.2, 0.8, -0.6}, true}}});
      b.joint("A", Revolute{"ground", "column", kAt, u});
      b.joint("P", Prismatic{"column", "quill", u}).joint("Q", Prismatic{"quill", "hand", u});
      b.drive("p", DrivenCoordinate{"P.displacement", Law::polynomial({0, 0.4})});
      b.drive("q", DrivenCoordinate{"Q.displacement", Law::polynomial({0, 0.3})});
      if (driven) {
        b.drive("a", DrivenCoordinate{"A.angle", Law::polynomial({0, kTurn})});
      } else {  // the same turn, from a gear; the angle has an output
        b.add(Body{.name = "wheel"}).joint("W", Revolute{"ground", "wheel", triple::add(kAt, square_to(u)), u});
        b.drive("w", DrivenCoordinate{"W.angle", Law::polynomial({0, -kTurn})});
        b.constrain("gear", Gear{"W.angle", "A.angle", -1});
      }
      const Scene scene = b.time(0, 1, 1.0 / 24).build();
      const test::Result run = test::run(scene);
      ASSERT_EQ(run.report().status.code, Code::ok);
      const Trajectory& t = run.trajectory;
      for (std::size_t k = 0; k < t.rows(); ++k) {
        const double time = t.times()[k];
        const Triple p = triple::subtract({0.9, 0.5, 0.1}, kAt);
        const Triple e = triple::add(triple::add(kAt, turned(u, kTurn * time, p)), triple::scale(0.7 * time, u));
        for (std::size_t i = 0; i < 3; ++i) {
          EXPECT_NEAR(t(k, t.index(std::string("T.") + "xyz"[i])), e[i], 1e-13) << k;
        }
      }
    }
  }
}

// The ground may be the first or the second body; a welded body rests.
TEST(JointPostures, FixedHoldsTheHandToTheGround) {
  for (const bool swap : {false, true}) {
    for (const bool more : {false, true}) {
      SceneBuilder b("frame", 2);
      b.add(Body{.name = "frame"}).add(Body{.name = "crank", .points = {{"T", {1, 0, 0}, true}}});
      const std::string frame = more ? "foot" : "frame";
      if (more) b.add(Body{.name = "foot"}).joint("G", swap ? Fixed{"foot", "frame"} : Fixed{"frame", "foot"});
      b.joint("F", swap ? Fixed{frame, "ground"} : Fixed{"ground", frame});
      b.joint("A", Revolute{"frame", "crank", kOrigin});
      EXPECT_EQ(mobility(b), 1);
      b.drive("motor", DrivenCoordinate{"A.angle", Law::polynomial({0, kTurn})});
      const Trajectory t = test::run(b.time(0, 1, 0.125).build()).trajectory;
      ASSERT_EQ(t.rows(), 9u);
      for (std::size_t k = 0; k < t.rows(); ++k) {
        EXPECT_NEAR(t(k, t.index("T.x")), std::cos(kTurn * t.times()[k]), 1e-14);
        EXPECT_NEAR(t(k, t.index("T.y")), std::sin(kTurn * t.times()[k]), 1e-14);
      }
    }
  }
}

// In the plane.
TEST(JointPostures, InThePlaneTurnAndSlideInEveryDirection) {
  for (int k = 0; k < 24; ++k) {
    const double direction = kTurn * k / 24;
    const Triple axis = {std::cos(direction), std::sin(direction), 0};
    for (const bool swap : {false, true}) {
      SCOPED_TRACE(k);
      SceneBuilder b("plane", 2);
      b.add(Body{.name = "arm"}).add(Body{.name = "slide"});
      b.add(Body{.name = "hand", .points = {{"T", {0.9, 0.5, 0}, true}}});
      b.joint("base", swap ? Revolute{"arm", "ground", kOrigin} : Revolute{"ground", "arm", kOrigin});
      b.joint("P", swap ? Prismatic{"slide", "arm", axis} : Prismatic{"arm", "slide", axis});
      b.joint("R", swap ? Revolute{"hand", "slide", Triple{0.3, -0.2}} : Revolute{"slide", "hand", Triple{0.3, -0.2}});
      EXPECT_EQ(mobility(b), 3);
      const double sign = swap ? -1 : 1;
      b.drive("motor", DrivenCoordinate{"base.angle", Law::polynomial({0, sign * kTurn})});
      b.drive("slider", DrivenCoordinate{"P.displacement", Law::polynomial({0, sign * 0.7})});
      b.drive("wrist", DrivenCoordinate{"R.angle", Law::polynomial({0, -2 * sign * kTurn})});
      const Scene scene = b.time(0, 1, 1.0 / 48).build();
      const double kappa = worst_condition(scene);
      EXPECT_LT(kappa, 400);
      const test::Result run = test::run(scene);
      ASSERT_EQ(run.report().status.code, Code::ok);
      const Triple z = {0, 0, 1}, wrist = {0.3, -0.2, 0};
      for (std::size_t row = 0; row < run.trajectory.rows(); ++row) {
        const double time = run.trajectory.times()[row];
        const Triple hand = triple::add(wrist, turned(z, -2 * kTurn * time, triple::subtract({0.9, 0.5, 0}, wrist)));
        const Triple e = turned(z, kTurn * time, triple::add(hand, triple::scale(0.7 * time, axis)));
        EXPECT_NEAR(run.trajectory(row, run.trajectory.index("T.x")), e[0], 32 * kappa * kEps) << row;
        EXPECT_NEAR(run.trajectory(row, run.trajectory.index("T.y")), e[1], 32 * kappa * kEps) << row;
      }
    }
  }
}

}  // namespace
}  // namespace assur
