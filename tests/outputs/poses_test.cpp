// Poses of bodies as outputs: origin, quaternion, angular velocity and acceleration, against closed forms.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "scene/triple.hpp"
#include "simulation/run.hpp"

namespace assur {
namespace {

using triple::add;
using triple::cross;
using triple::scale;
using triple::subtract;

using Quaternion = std::array<double, 4>;  // w, x, y, z

Quaternion times(const Quaternion& a, const Quaternion& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}

Quaternion about(const Triple& axis, double angle) {
  const double s = std::sin(angle / 2);
  return {std::cos(angle / 2), s * axis[0], s * axis[1], s * axis[2]};
}

Triple turned(const Quaternion& q, const Triple& v) {
  const Triple u = {q[1], q[2], q[3]}, t = scale(2, cross(u, v));
  return add(v, add(scale(q[0], t), cross(u, t)));
}

Triple columns(const Trajectory& t, std::size_t row, const std::string& stem) {
  return {t(row, t.index(stem + "x")), t(row, t.index(stem + "y")), t(row, t.index(stem + "z"))};
}

// Either sign if w is about 0.
void expect_quaternion(const Trajectory& t, std::size_t row, const std::string& body, Quaternion q, double tolerance) {
  const Triple v = columns(t, row, body + ".q");
  const Quaternion got = {t(row, t.index(body + ".qw")), v[0], v[1], v[2]};
  EXPECT_GE(got[0], 0);
  double dot = 0;
  for (std::size_t i = 0; i < 4; ++i) dot += got[i] * q[i];
  if (dot < 0) {
    EXPECT_TRUE(q[0] < 0 || std::abs(q[0]) < tolerance);
    for (double& x : q) x = -x;
  }
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(got[i], q[i], tolerance) << body << ' ' << i << " row " << row;
}

void expect_triple(const Triple& got, const Triple& wanted, double tolerance, const std::string& what) {
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(got[i], wanted[i], tolerance) << what << ' ' << i;
}

// The first axis is along z, the second one along y as written. Rates are 1 + t and 0.7.
const Triple kCentre = {0.1, 0.2, 0}, kElbow = {0.6, 0.2, 0};
SceneBuilder arm() {
  return SceneBuilder("arm", 3)
      .add(Body{.name = "upper"})
      .add(Body{.name = "hand"})
      .joint("A", Revolute{"ground", "upper", kCentre, Triple{0, 0, 1}})
      .joint("B", Revolute{"upper", "hand", kElbow, Triple{0, 1, 0}})
      .drive("m", DrivenCoordinate{"A.angle", Law::polynomial({0, 1, 0.5})})
      .drive("n", DrivenCoordinate{"B.angle", Law::polynomial({0, 0.7})})
      .time(0, 6, 0.05);
}

TEST(Poses, FollowTheClosedFormOfAnArm) {
  const Trajectory t = test::run(arm().output("hand").build()).trajectory;
  ASSERT_EQ(t.columns().size(), 19u);
  const Triple z = {0, 0, 1};
  for (std::size_t row = 0; row < t.rows(); ++row) {
    const double time = t.times()[row], first = time + 0.5 * time * time, second = 0.7 * time, speed = 1 + time;
    const Quaternion base = about(z, first), q = times(base, about({0, 1, 0}, second));
    const Triple u = turned(base, {0, 1, 0}), omega = add(scale(speed, z), scale(0.7, u)),
                 alpha = add(z, scale(0.7 * speed, cross(z, u)));
    expect_quaternion(t, row, "hand", q, 1e-14);
    expect_triple(columns(t, row, "hand.w"), omega, 1e-13, "angular velocity");
    expect_triple(columns(t, row, "hand.alpha"), alpha, 1e-12, "angular acceleration");
    // The point of the hand that was at the origin of the ground.
    const Triple elbow = add(kCentre, turned(base, subtract(kElbow, kCentre))), arm = turned(q, scale(-1, kElbow));
    expect_triple(columns(t, row, "hand.origin."), add(elbow, arm), 1e-14, "origin");
    const Triple velocity = add(scale(speed, cross(z, subtract(elbow, kCentre))), cross(omega, arm));
    expect_triple(columns(t, row, "hand.origin.v"), velocity, 1e-13, "velocity of the origin");
  }
}

TEST(Poses, HavePartsThatCanBeAskedForAlone) {
  const Scene scene = arm().output("hand.angular_velocity").output("upper.quaternion").build();
  const Trajectory t = test::run(scene).trajectory;
  EXPECT_EQ(t.columns(), (std::vector<std::string>{"hand.wx", "hand.wy", "hand.wz", "upper.qw", "upper.qx", "upper.qy",
                                                   "upper.qz"}));
  const Scene other = scene.with_outputs({"upper.angular_acceleration", "hand.origin.vx"});
  EXPECT_EQ(test::run(other).trajectory.columns(),
            (std::vector<std::string>{"upper.alphax", "upper.alphay", "upper.alphaz", "hand.origin.vx"}));
  // An output that is asked for later has the same pose as one that is asked for at once.
  const Trajectory late = test::run(arm().output("B").build().with_outputs({"hand"})).trajectory;
  const Trajectory early = test::run(arm().output("hand").build()).trajectory;
  ASSERT_EQ(late.columns(), early.columns());
  for (std::size_t c = 0; c < late.columns().size(); ++c) {
    EXPECT_NEAR(late(late.rows() - 1, c), early(early.rows() - 1, c), 1e-12) << late.columns()[c];
  }
}

// Local axes of a body with a base of its own are those of its driven pose.
TEST(Poses, EqualTheLawsOfADrivenPlatform) {
  const Scene scene = open_scene("stewart:steps=50").with_outputs({"terminal"});
  const Pose* pose = nullptr;
  for (const Driver& d : scene.drivers()) {
    if (const auto* p = std::get_if<Pose>(&d.kind)) pose = p;
  }
  ASSERT_NE(pose, nullptr);
  const Trajectory t = test::run(scene).trajectory;
  for (std::size_t row = 0; row < t.rows(); ++row) {
    const double time = t.times()[row];
    const auto angle = [&](std::size_t k) { return pose->rotation[k](time).value; };
    const Quaternion q =
        times(times(about({0, 0, 1}, angle(0)), about({0, 1, 0}, angle(1))), about({1, 0, 0}, angle(2)));
    expect_quaternion(t, row, "terminal", q, 1e-14);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(columns(t, row, "terminal.origin.")[k], pose->translation[k](time).value, 1e-14);
    }
  }
}

TEST(Poses, CountTurnsInThePlane) {
  const Scene scene = SceneBuilder("crank", 2)
                          .add(Body{.name = "crank"})
                          .joint("A", Revolute{"ground", "crank", Triple{1, 0}})
                          .drive("motor", DrivenCoordinate{"A.angle", Law::polynomial({0, 2})})
                          .output("crank")
                          .time(0, 10, 0.1)
                          .build();
  const Trajectory t = test::run(scene).trajectory;
  for (std::size_t row = 0; row < t.rows(); ++row) {
    const double angle = 2 * t.times()[row];
    EXPECT_NEAR(t(row, t.index("crank.angle")), angle, 1e-14 * (1 + angle));
    EXPECT_NEAR(t(row, t.index("crank.angle.rate")), 2, 1e-14);
    EXPECT_NEAR(t(row, t.index("crank.origin.x")), 1 - std::cos(angle), 1e-14);
    EXPECT_NEAR(t(row, t.index("crank.origin.y")), -std::sin(angle), 1e-14);
  }
}

TEST(Poses, HaveErrorsLikeOtherOutputs) {
  const Scene scene = arm().output("hand").build();
  test::Result run = test::run(scene);
  try {
    const ForwardError error = forward_error(prepare(scene), run.trajectory);
    EXPECT_LT(error.position, 1e-14);
    EXPECT_LT(error.velocity, 1e-13);
    EXPECT_LT(error.acceleration, 1e-12);
  } catch (const Error& e) {
    if (e.kind() != Error::Kind::environment) throw;
    GTEST_SKIP() << e.what();  // no quad precision in this build
  }
}

TEST(Poses, RefuseUnknownParts) {
  const auto refusal = [&](const std::string& output) -> std::string {
    try {
      (void)arm().output(output).build();
    } catch (const Error& e) {
      return e.what();
    }
    return "accepted";
  };
  for (const char* part : {"speed", "angle", "position"}) {
    EXPECT_EQ(refusal(std::string("hand.") + part),
              "/outputs/0: 'hand' is a body; its outputs are 'hand' alone, the whole pose, or its parts: origin, "
              "quaternion, angular_velocity, angular_acceleration");
  }
}

// ---- joints whose driver a program sets

TEST(JointDrivers, SetTheAngleOfAJointInThePlane) {
  for (const double y : {0.0, 0.1, -3.0}) {
    const Scene scene = SceneBuilder("crank", 2)
                            .add(Body{.name = "crank", .points = {{"P", {0.1, y}, true}}})
                            .joint("A", Revolute{"ground", "crank", Triple{0, 0}})
                            .drive("motor", DrivenCoordinate{"A.angle", Law::constant(0)})
                            .output("A.angle")
                            .time(0, 1, 0.1)
                            .build();
    Simulator simulator = test::simulator(scene, "auto", {}, {"motor"});
    for (const double angle : {0.01, 0.3, -0.2}) {
      simulator.set("motor", angle);
      ASSERT_TRUE(simulator.step(simulator.time() + 0.1).ok());
      EXPECT_NEAR(simulator.output("A.angle"), angle, 1e-15) << y;
    }
  }
}

// A fixed joint makes a body a part of the ground; its pose is that of the posture as written.
TEST(Poses, OfABodyThatIsFixedToTheGround) {
  for (const int dimension : {2, 3}) {
    SceneBuilder b("grounded", dimension);
    const bool space = dimension == 3;
    b.add(Body{.name = "base", .points = {{"P", {1, 0, 0}, true}}});
    b.add(Body{.name = "arm", .points = {{"Q", {2, 1, 0}, true}}});
    b.joint("weld", Fixed{"ground", "base"});
    b.joint("J", Revolute{"base", "arm", Triple{}, space ? Anchor{Triple{0, 0, 1}} : Anchor{}});
    b.drive("motor", DrivenCoordinate{"J.angle", Law::polynomial({0, 1})})
        .output("base")
        .output("base.origin.velocity");
    const test::Result r = test::run(b.output("Q").time(0, 1, 0.5).build());
    ASSERT_TRUE(r.report().status.ok());
    const auto last = [&](const std::string& column) { return r.trajectory.last(column); };
    EXPECT_EQ(last("base.origin.x"), 0);
    EXPECT_EQ(last("base.origin.vy"), 0);
    EXPECT_EQ(space ? last("base.qw") : last("base.angle") + 1, 1);
    EXPECT_EQ(space ? last("base.wz") : last("base.angle.rate"), 0);
    EXPECT_NEAR(last("Q.x"), 2 * std::cos(1.0) - std::sin(1.0), 1e-14);
  }
}

}  // namespace
}  // namespace assur
