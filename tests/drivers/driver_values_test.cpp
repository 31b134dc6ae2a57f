// In every row a driven quantity, measured from positions, has the value of its law. Otherwise the scene or the step is
// refused and the driver is named.
#include <gtest/gtest.h>

#include <numbers>
#include <random>
#include <sstream>

#include "assur/ensemble.hpp"
#include "assur/saved_plan.hpp"
#include "references/delta.hpp"
#include "simulation/run.hpp"
#include "structure/grouped_system.hpp"

namespace assur {
namespace {

constexpr double kPi = std::numbers::pi;

double turned(double a) { return std::remainder(a, 2 * kPi); }

// A unit vector e whose angle from x, about z or in the plane, is driven. The guess has the angle `guess`; the law
// starts at `start`.
Scene pointer(int dimension, double guess, double start) {
  SceneBuilder b("pointer", dimension);
  b.fixed_vector("x", {1, 0, 0}).vector("e", {std::cos(guess), std::sin(guess), 0});
  std::string axis;
  if (dimension == 3) {
    axis = "z";
    b.fixed_vector("z", {0, 0, 1}).constrain("hinge", Dot{"e", "z", 0.0});
  }
  b.drive("m", RelativeAngle{"x", "e", axis, Law::polynomial({start, 1})});
  b.measure("q", AngleBetween{"x", "e", axis}).output("e").output("q.value").time(0, 1, 0.25);
  return b.build();
}

// Newton's method alone ends half a turn away if the guess is wrong by more than a right angle.
TEST(DriverValues, RelativeAnglesMatchTheLawFromAnyGuess) {
  for (const int dimension : {2, 3}) {
    for (int degrees = -180; degrees <= 180; degrees += 10) {
      const double off = degrees * kPi / 180;
      const test::Result r = test::run(pointer(dimension, 0.3 + off, 0.3), "irreducible/eigen");
      ASSERT_EQ(r.report().status.code, Code::ok) << dimension << "D, off by " << degrees;
      for (std::size_t k = 0; k < r.trajectory.rows(); ++k) {
        const double t = r.trajectory.times()[k];
        const auto at = [&](const char* column) { return r.trajectory(k, r.trajectory.index(column)); };
        // A few roundings of numbers of size 1.
        EXPECT_NEAR(at("q"), 0.3 + t, 64 * kEps) << dimension << "D, off by " << degrees << " at " << t;
        EXPECT_NEAR(at("e.x"), std::cos(0.3 + t), 64 * kEps);
        EXPECT_NEAR(at("e.y"), std::sin(0.3 + t), 64 * kEps);
      }
    }
  }
}

// The angle of each elbow, computed with atan2 from its position, follows the law.
TEST(DriverValues, DeltaRobotsMatchTheLawFromPoorGuesses) {
  const references::Delta delta;
  for (const double off : {0.4, 1.7, 2.2, -1.7, kPi}) {
    SceneBuilder b = delta.scene({0.2 + off, 0.2 + off, 0.2 + off}, 0.2);
    for (int i = 0; i < 3; ++i) {
      const std::string n = std::to_string(i);
      b.drive("motor" + n, RelativeAngle{"r" + n, {"S" + n, "E" + n}, "t" + n, Law::polynomial({0.2, 0.3})});
    }
    const Scene scene = b.time(0, 1, 0.1).build();
    if (off > 2) {
      // Guesses at 2.4 and 3.3 rad lie on another branch, beyond a posture with parallel rods.
      const std::string why = group_equations(scene).cannot_assemble;
      EXPECT_TRUE(why.starts_with("the start posture cannot be reached: at ")) << off << ": " << why;
      EXPECT_NE(why.find("motor0 = "), std::string::npos) << why;
      continue;
    }
    const test::Result r = test::run(scene, "irreducible/eigen");
    ASSERT_EQ(r.report().status.code, Code::ok) << off;
    for (std::size_t k = 0; k < r.trajectory.rows(); ++k) {
      const double angle = 0.2 + 0.3 * r.trajectory.times()[k];
      for (int i = 0; i < 3; ++i) {
        const Triple elbow = delta.elbow(i, angle);
        for (int j = 0; j < 3; ++j) {
          const std::string column = "E" + std::to_string(i) + "." + "xyz"[j];
          // Roundings of 1e-16, amplified by a condition of about 1e3 of the whole robot.
          EXPECT_NEAR(r.trajectory(k, r.trajectory.index(column)), elbow[static_cast<std::size_t>(j)], 1e-13) << off;
        }
      }
      EXPECT_NEAR(r.trajectory(k, r.trajectory.index("O.z")), delta.height(angle), 1e-12) << off;
    }
  }
}

// ---- random scenes

struct Case {
  Scene scene;
  struct Angle {
    std::string measure;
    Law law;
  };
  std::vector<Angle> angles;
};

class Maker {
 public:
  explicit Maker(unsigned seed) : random_(seed) {}

  double number(double from, double to) {
    return from + (to - from) * (static_cast<double>(random_()) / static_cast<double>(std::mt19937::max()));
  }
  int whole(int most) { return static_cast<int>(random_() % static_cast<unsigned>(most)); }
  double off() { return whole(4) == 0 ? number(-0.3, 0.3) : number(-kPi, kPi); }
  Triple direction() {
    for (;;) {
      const Triple a = {number(-1, 1), number(-1, 1), number(-1, 1)};
      const double n = std::hypot(a[0], a[1], a[2]);
      if (n > 0.2 && n < 1) return {a[0] / n, a[1] / n, a[2] / n};
    }
  }

  // Links in the plane, each driven by its angle from the previous one.
  Case chain_in_the_plane() {
    SceneBuilder b("chain", 2);
    Case c;
    const int links = 2 + whole(3);
    b.fixed_vector("x", {1, 0, 0});
    Triple at = {number(-5, 5), number(-5, 5), 0};
    b.fixed_point("P0", at);
    double heading = 0;
    for (int i = 1; i <= links; ++i) {
      const std::string n = std::to_string(i), before = std::to_string(i - 1);
      const double length = number(0.3, 2), law = number(-kPi, kPi);
      heading += law + off();
      at = {at[0] + length * std::cos(heading), at[1] + length * std::sin(heading), 0};
      b.point("P" + n, at).constrain("link" + n, Distance{"P" + before, "P" + n, length});
      const Direction d = i == 1 ? Direction("x") : Direction("P" + std::to_string(i - 2), "P" + before);
      angle(b, c, n, d, {"P" + before, "P" + n}, "", law);
    }
    return finish(b, c);
  }

  // A direction on a cone about a fixed axis, and another direction about an axis that moves with it.
  Case chain_in_space() {
    SceneBuilder b("serial", 3);
    Case c;
    const Triple z = direction(), x = across(z);
    const double cone = number(0.4, kPi - 0.4), guess = number(-kPi, kPi);
    b.fixed_vector("z", z).fixed_vector("x", x);
    const Triple e = about(z, x, cone, guess);
    b.vector("e", e).constrain("cone", Dot{"e", "z", std::cos(cone)});
    angle(b, c, "1", "x", "e", "z", turned(guess - off()));
    if (whole(2) == 0) return finish(b, c);
    // A frame at e: a is perpendicular to z and to e, and f turns about a from e.
    const Triple a = unit(cross(z, e));
    b.vector("a", a).constrain("a_z", Dot{"a", "z", 0.0}).constrain("a_e", Dot{"a", "e", 0.0});
    const double second = number(-kPi, kPi);
    const Triple f = about(a, e, kPi / 2, second);
    b.vector("f", f).constrain("f_a", Dot{"f", "a", 0.0});
    angle(b, c, "2", "e", "f", "a", turned(second - off()));
    return finish(b, c);
  }

  // A four-bar that is driven at the joint between crank and coupler, or at the ground.
  Case four_bar() {
    SceneBuilder b("four_bar", 2);
    Case c;
    const double crank = number(0.4, 0.8), coupler = number(1.5, 2), rocker = number(1.3, 1.8), base = 2;
    const double true_angle = number(-kPi, kPi);
    const Triple B = {crank * std::cos(true_angle), crank * std::sin(true_angle), 0};
    const double bd = std::hypot(base - B[0], B[1]);
    const double along = (coupler * coupler - rocker * rocker + bd * bd) / (2 * bd);
    const double up = std::sqrt(coupler * coupler - along * along);
    const double ux = (base - B[0]) / bd, uy = -B[1] / bd;
    const Triple C = {B[0] + along * ux - up * uy, B[1] + along * uy + up * ux, 0};
    const double inner =
        std::atan2(-B[0] * (C[1] - B[1]) + B[1] * (C[0] - B[0]), -B[0] * (C[0] - B[0]) - B[1] * (C[1] - B[1]));
    const double turn = off();
    const double g = true_angle + turn, h = number(-0.3, 0.3);
    b.fixed_vector("x", {1, 0, 0}).fixed_point("A", {0, 0, 0}).fixed_point("D", {base, 0, 0});
    b.point("B", {crank * std::cos(g), crank * std::sin(g), 0}).point("C", {C[0] + h, C[1] + h, 0});
    b.constrain("crank", Distance{"A", "B", crank}).constrain("coupler", Distance{"B", "C", coupler});
    b.constrain("rocker", Distance{"D", "C", rocker});
    if (whole(2) == 0) {
      angle(b, c, "1", {"B", "A"}, {"B", "C"}, "", inner);
    } else {
      angle(b, c, "1", "x", {"A", "B"}, "", true_angle);
    }
    return finish(b, c);
  }

  Case any() {
    switch (whole(3)) {
      case 0:
        return chain_in_the_plane();
      case 1:
        return chain_in_space();
      default:
        return four_bar();
    }
  }

 private:
  static Triple cross(const Triple& a, const Triple& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  }
  static Triple unit(const Triple& a) {
    const double n = std::hypot(a[0], a[1], a[2]);
    return {a[0] / n, a[1] / n, a[2] / n};
  }
  Triple across(const Triple& a) { return unit(cross(a, direction())); }
  // A direction at the angle `cone` from a, turned about a by `turn` from x. x is perpendicular to a.
  static Triple about(const Triple& a, const Triple& x, double cone, double turn) {
    const Triple y = cross(a, x);
    Triple out;
    for (std::size_t k = 0; k < 3; ++k) {
      out[k] = std::cos(cone) * a[k] + std::sin(cone) * (std::cos(turn) * x[k] + std::sin(turn) * y[k]);
    }
    return out;
  }

  void angle(SceneBuilder& b, Case& c, const std::string& n, const Direction& d, const Direction& e,
             const std::string& axis, double start) {
    const Law law = Law::polynomial({start, number(-0.2, 0.2)});
    b.drive("m" + n, RelativeAngle{d, e, axis, law});
    b.measure("q" + n, AngleBetween{d, e, axis}).output("q" + n + ".value");
    c.angles.push_back({"q" + n, law});
  }
  static Case finish(SceneBuilder& b, Case& c) { return {b.time(0, 1, 0.25).build(), std::move(c.angles)}; }

  std::mt19937 random_;
};

// Measures are evaluated from positions, so they do not repeat the values of the drivers.
TEST(DriverValues, MatchTheLawsOrAreRefusedByName) {
  int run = 0, refused = 0, far = 0;
  for (unsigned seed = 1; seed <= 2000; ++seed) {
    const Case c = Maker(seed).any();
    SCOPED_TRACE("seed " + std::to_string(seed) + " " + c.scene.name());
    try {
      const test::Result r = test::run(c.scene, "irreducible/eigen");
      ++run;
      for (std::size_t k = 0; k < r.trajectory.rows(); ++k) {
        for (const Case::Angle& a : c.angles) {
          const double q = r.trajectory(k, r.trajectory.index(a.measure));
          // Rows without a report of inaccuracy have estimated errors of at most 1e-6.
          EXPECT_NEAR(turned(q - a.law(r.trajectory.times()[k]).value), 0, 1e-6) << "row " << k;
        }
      }
    } catch (const Error& e) {
      ++refused;
      const std::string what = e.what();
      EXPECT_TRUE(what.find("driver m") != std::string::npos || what.find("group ") != std::string::npos) << what;
    }
    far += 1;
  }
  RecordProperty("refused", refused);
  EXPECT_GE(run, far * 99 / 100);  // the values of all laws at the start can be reached
}

// ---- during the run

// P is (1 - t) times (1, tan 0.5). The lever of the angle vanishes at t = 1, and the direction is reversed afterwards.
SceneBuilder vanishing(const std::string& name) {
  SceneBuilder b(name, 2);
  b.fixed_vector("x", {1, 0, 0}).fixed_point("O", {0, 0, 0}).point("P", {1, 0.5, 0});
  b.drive("slide", DrivenCoordinate{"P.x", Law::polynomial({1, -1})});
  b.drive("m", RelativeAngle{"x", {"O", "P"}, "", Law::constant(0.5)});
  b.measure("q", AngleBetween{"x", {"O", "P"}, ""});
  return b;
}

TEST(DriverValues, AVanishingLeverStopsTheRunAndIsNamed) {
  for (const double step : {0.0625, 0.3, 1.5}) {
    const Scene scene = vanishing("vanishing").time(0, 1.5, step).build();
    Simulator s = test::simulator(scene, "irreducible/eigen");
    const Trajectory run = s.run();
    EXPECT_EQ(s.report().status.code, Code::actuator_zero) << step;
    EXPECT_LE(s.report().reached, 1);
    ASSERT_FALSE(s.report().events.empty());
    EXPECT_EQ(s.report().events.back().group, "m");
    EXPECT_EQ(s.report().events.back().kind, Code::actuator_zero);
    EXPECT_LE(s.report().events.back().time, 1);
    EXPECT_GE(s.report().events.back().until, 1 - 1e-5);
    for (std::size_t k = 0; k < run.rows(); ++k) EXPECT_NEAR(run(k, run.index("q")), 0.5, 1e-9);
  }
}

// Runs in chunks, in lanes and with a saved plan.
TEST(DriverValues, AVanishingLeverStopsEveryKindOfRun) {
  const Scene scene = vanishing("vanishing").time(0, 1.5, 0.0625).build();
  const double reached = 15 * 0.0625;
  Simulator chunks = test::simulator(scene, "irreducible/lanes:4+chunks=8");
  (void)chunks.run();
  EXPECT_EQ(chunks.report().status.code, Code::actuator_zero);
  EXPECT_NEAR(chunks.report().reached, 1, 0.0625);

  Ensemble ensemble(4, [&](std::size_t) { return prepare(scene, {.strategy = "irreducible/lanes:4"}); });
  (void)ensemble.run();
  for (const Ensemble::Outcome& outcome : ensemble.outcomes()) {
    EXPECT_EQ(outcome.status.code, Code::actuator_zero);
    EXPECT_GE(outcome.reached, reached);
    EXPECT_LE(outcome.reached, 1);
    ASSERT_FALSE(outcome.events.empty());
    EXPECT_EQ(outcome.events.back().group, "m");
  }

  std::stringstream file;
  save_plan(file, prepare(scene, {.strategy = "irreducible/eigen"}));
  Simulator loaded(load_plan(file, {.table = backends()}));
  Status status;
  while (loaded.time() < 1.5 && (status = loaded.step()).ok()) {
  }
  EXPECT_EQ(status.code, Code::actuator_zero);
  ASSERT_FALSE(loaded.report().events.empty());
  EXPECT_EQ(loaded.report().events.back().group, "m");
}

// The axis of the angle tilts until it is parallel to x, where the motor m has no effect.
TEST(DriverValues, AnAxisAlongADirectionStopsTheRunAndIsNamed) {
  SceneBuilder b("leaning", 3);
  b.fixed_vector("x", {1, 0, 0}).fixed_vector("y", {0, 1, 0}).fixed_vector("z", {0, 0, 1});
  b.vector("a", {0, 0, 1}).constrain("a_y", Dot{"a", "y", 0.0});
  b.drive("lean", RelativeAngle{"z", "a", "y", Law::polynomial({0, 1})});  // a is along x at t = pi / 2
  b.vector("e", {0.6, 0.8, 0}).constrain("e_a", Dot{"e", "a", 0.0});
  b.drive("m", RelativeAngle{"x", "e", "a", Law::constant(0.8)});
  b.measure("q", AngleBetween{"x", "e", "a"});
  const Scene scene = b.time(0, 2, 0.1).build();
  Simulator s = test::simulator(scene, "irreducible/eigen");
  const Trajectory run = s.run();
  EXPECT_EQ(s.report().status.code, Code::actuator_zero);
  EXPECT_NEAR(s.report().reached, kPi / 2, 0.1);
  ASSERT_FALSE(s.report().events.empty());
  EXPECT_EQ(s.report().events.back().group, "m");
  for (std::size_t k = 0; k < run.rows(); ++k) EXPECT_NEAR(run(k, run.index("q")), 0.8, 1e-6);
}

// ---- refused

std::string refusal(const Scene& scene) {
  try {
    (void)prepare(scene, {.strategy = "irreducible/eigen"});
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

// Two vectors of one body: the axis is parallel to the direction in every posture.
TEST(DriverValues, AnAxisAlongADirectionOfItsBodyIsRefused) {
  SceneBuilder b("rigid", 3);
  b.fixed_point("O", {0, 0, 0}).fixed_vector("z", {0, 0, 1});
  b.vector("u", {0.8, 0.6, 0}).vector("v", {-0.6, 0.8, 0}).vector("w", {0, 0, 1});
  b.add(Body{"body", "O", {"u", "v", "w"}, {}, {}, {{"s", {0, 0, 1}}}});
  b.constrain("across_u", Dot{"u", "z", 0.0}).constrain("across_v", Dot{"v", "z", 0.0});
  b.fixed_vector("x", {1, 0, 0});
  b.drive("m", RelativeAngle{"s", "x", "w", Law::polynomial({0, 1})});
  const std::string what = refusal(b.time(0, 1, 0.1).build());
  EXPECT_NE(what.find("driver m has no angle in the start posture: its axis is parallel to its first direction"),
            std::string::npos)
      << what;
}

// The equations of the declared group also hold for frames with two reversed axes and for the mirror image. The frames
// are led to the law of the pose; the mirror image is refused.
TEST(DriverValues, PosesMatchTheLawFromATurnedFrame) {
  for (const Triple& sign : {Triple{-1, -1, 1}, Triple{1, -1, -1}, Triple{-1, 1, -1}, Triple{-1, -1, -1}}) {
    SceneBuilder b("posed", 3);
    b.point("O", {0, 0, 0});
    b.vector("u", {sign[0], 0, 0}).vector("v", {0, sign[1], 0}).vector("w", {0, 0, sign[2]});
    b.add(Body{"body", "O", {"u", "v", "w"}, {}, {}, {}});
    b.add(DeclaredGroup{"frame", {"O", "u", "v", "w"}, false});
    const Law zero = Law::constant(0), turn = Law::polynomial({0, 0.1});
    b.drive("p", Pose{"body", {zero, zero, zero}, {turn, zero, zero}});
    const Scene scene = b.time(0, 1, 0.1).build();
    if (sign[0] * sign[1] * sign[2] < 0) {
      EXPECT_THROW((void)prepare(scene, {.strategy = "groups/eigen"}), Error);
      continue;
    }
    const test::Result r = test::run(scene, "groups/eigen");
    ASSERT_EQ(r.report().status.code, Code::ok);
    for (std::size_t k = 0; k < r.trajectory.rows(); ++k) {
      const double c = std::cos(0.1 * r.trajectory.times()[k]), s = std::sin(0.1 * r.trajectory.times()[k]);
      const auto at = [&](const char* column) { return r.trajectory(k, r.trajectory.index(column)); };
      EXPECT_NEAR(at("u.x"), c, 64 * kEps);
      EXPECT_NEAR(at("u.y"), s, 64 * kEps);
      EXPECT_NEAR(at("v.x"), -s, 64 * kEps);
      EXPECT_NEAR(at("w.z"), 1, 64 * kEps);
    }
  }
}

// An axis whose length follows from other equations, and is not 1, scales the sine of the angle.
TEST(DriverValues, RefusesAnAxisThatIsNoUnitVector) {
  SceneBuilder b("long_axis", 3);
  b.fixed_vector("x", {1, 0, 0}).fixed_vector("z", {0, 0, 1});
  b.add(Vector{"a", {0, 0, 1}, false, false}).constrain("twice", Linear{{{"a", 1.0}, {"z", -2.0}}, {}});
  b.vector("e", {1, 0.2, 0}).constrain("hinge", Dot{"e", "z", 0.0});
  b.drive("m", RelativeAngle{"x", "e", "a", Law::polynomial({0.2, 1})});
  const std::string what = refusal(b.time(0, 1, 0.1).build());
  EXPECT_NE(what.find("driver m has no angle in the start posture: its axis is not a unit vector"), std::string::npos)
      << what;
}

}  // namespace
}  // namespace assur
