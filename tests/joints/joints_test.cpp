// Mechanisms written with bodies and joints: the motion equals that of the same mechanism written with points and
// constraints, or a closed form. Bodies stay rigid and joints hold, as measured in the computed postures.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "lettered_joint.hpp"
#include "numbers.hpp"
#include "plan/preparation.hpp"
#include "scene/triple.hpp"
#include "simulation/run.hpp"

namespace assur {
namespace {

constexpr double kPi = std::numbers::pi;

Law turning(double speed) { return Law::polynomial({0, speed}); }

// ---- rotations, for the same mechanism in many orientations

using Matrix = std::array<Triple, 3>;  // rows

Triple times(const Matrix& r, const Triple& a) {
  return {triple::dot(r[0], a), triple::dot(r[1], a), triple::dot(r[2], a)};
}

// Rotations about the coordinate axes, one after the other.
Matrix rotation(double x, double y, double z) {
  const auto about = [](const Triple& v, std::size_t axis, double angle) {
    const std::size_t i = (axis + 1) % 3, k = (axis + 2) % 3;
    Triple w = v;
    w[i] = std::cos(angle) * v[i] - std::sin(angle) * v[k];
    w[k] = std::sin(angle) * v[i] + std::cos(angle) * v[k];
    return w;
  };
  Matrix columns;
  for (std::size_t c = 0; c < 3; ++c) {
    Triple e{};
    e[c] = 1;
    columns[c] = about(about(about(e, 0, x), 1, y), 2, z);
  }
  Matrix r;
  for (std::size_t i = 0; i < 3; ++i) r[i] = {columns[0][i], columns[1][i], columns[2][i]};
  return r;
}

// 16 kappa eps, with the largest condition kappa of the groups at the end of a run.
double tolerance(test::Result& run) {
  double condition = 1;
  for (const GroupFigures& g : run.simulator.examine()) condition = std::max(condition, g.condition);
  return 16 * condition * kEps;
}

std::size_t unknowns(const Scene& scene) {
  std::size_t count = 0;
  for (const SolvedGroup& g : preparation(prepare(scene)).structure->groups) count += g.unknowns.size();
  return count;
}

// ---- helpers that measure in the computed postures

Triple place(const Trajectory& t, std::size_t row, const std::string& item, const Scene& scene) {
  for (const Point& p : scene.points()) {
    if (p.name == item && p.fixed) return p.at;
  }
  for (const Vector& v : scene.vectors()) {
    if (v.name == item && v.fixed) return v.at;
  }
  return {t(row, t.index(item + ".x")), t(row, t.index(item + ".y")),
          scene.dimension() == 3 ? t(row, t.index(item + ".z")) : 0};
}

// The largest change of a distance between points of one body, or of a dot product of its directions (vectors and pairs
// of points), relative to the length of the mechanism.
double change_of_shapes(const Scene& scene, const Trajectory& t, double length) {
  double worst = 0;
  for (const Body& b : scene.bodies()) {
    std::vector<std::string> points, vectors;
    const auto is_vector = [&](const std::string& name) {
      for (const Vector& v : scene.vectors()) {
        if (v.name == name) return true;
      }
      for (const Body& other : scene.bodies()) {
        for (const Member& m : other.vectors) {
          if (m.name == name) return true;
        }
      }
      return false;
    };
    for (const std::string& name : b.base) (is_vector(name) ? vectors : points).push_back(name);
    for (const Member& m : b.points) points.push_back(m.name);
    for (const Member& m : b.vectors) vectors.push_back(m.name);
    const auto numbers = [&](std::size_t row) {
      std::vector<double> all;
      std::vector<Triple> p, v;
      for (const std::string& name : points) p.push_back(place(t, row, name, scene));
      for (const std::string& name : vectors) v.push_back(place(t, row, name, scene));
      for (std::size_t i = 0; i < p.size(); ++i) {
        for (std::size_t k = 0; k < i; ++k) {
          const Triple d = triple::subtract(p[i], p[k]);
          all.push_back(triple::norm(d) / length);
          for (const Triple& u : v) all.push_back(triple::dot(d, u) / length);
        }
      }
      for (std::size_t i = 0; i < v.size(); ++i) {
        for (std::size_t k = 0; k <= i; ++k) all.push_back(triple::dot(v[i], v[k]));
      }
      return all;
    };
    const std::vector<double> first = numbers(0);
    for (std::size_t row = 1; row < t.rows(); ++row) {
      const std::vector<double> now = numbers(row);
      for (std::size_t i = 0; i < now.size(); ++i) worst = std::max(worst, std::abs(now[i] - first[i]));
    }
  }
  return worst;
}

// ---- in the plane

Scene four_bar_with_joints() {
  return SceneBuilder("four_bar", 2)
      .add(Body{.name = "crank"})
      .add(Body{.name = "coupler", .points = {{"P", {1.2, 1.5, 0}, true}}})
      .add(Body{.name = "rocker"})
      .joint("A", Revolute{"ground", "crank", Triple{0, 0, 0}})
      .joint("B", Revolute{"crank", "coupler", Triple{0.8, 0, 0}})
      .joint("C", Revolute{"coupler", "rocker", Triple{1.6, 1.2, 0}})
      .joint("D", Revolute{"ground", "rocker", Triple{2, 0, 0}})
      .drive("motor", DrivenCoordinate{"A.angle", turning(0.5)})
      .output("C")
      .output("P")
      .output("D.angle")
      .output("C.angle")
      .time(0, 0.8, 0.01)
      .build();
}

TEST(Joints, FourBarMovesAsWrittenByHand) {
  const Scene with_joints = four_bar_with_joints();
  const Scene by_hand = SceneBuilder("four_bar", 2)
                            .fixed_point("A", {0, 0})
                            .fixed_point("D", {2, 0})
                            .point("B", {0.8, 0})
                            .point("C", {1.6, 1.2})
                            .add(Body{.name = "coupler", .base = {"B", "C"}, .points = {{"P", {1.2, 1.5, 0}, true}}})
                            .constrain("rocker", Distance{"D", "C"})
                            .drive("motor", PointAngle{"A", "B", "", turning(0.5)})
                            .measure("rocker_angle", AbsoluteAngle{"D", "C"})
                            .measure("elbow", AngleBetween{{"B", "C"}, {"C", "D"}, ""})
                            .output("C")
                            .output("P")
                            .output("rocker_angle")
                            .output("elbow")
                            .time(0, 0.8, 0.01)
                            .build();
  EXPECT_EQ(unknowns(with_joints), unknowns(by_hand));
  const Trajectory a = test::run(with_joints).trajectory, b = test::run(by_hand).trajectory;
  ASSERT_EQ(a.rows(), 81u);
  const double start = b(0, b.index("rocker_angle")), bent = b(0, b.index("elbow"));
  for (std::size_t k = 0; k < a.rows(); ++k) {
    for (const char* column : {"C.x", "C.y", "C.vx", "P.x", "P.vy", "P.ax"}) {
      EXPECT_NEAR(a(k, a.index(column)), b(k, b.index(column)), 1e-13) << column << " " << k;
    }
    EXPECT_NEAR(a(k, a.index("D.angle")), b(k, b.index("rocker_angle")) - start, 1e-13);
    EXPECT_NEAR(a(k, a.index("C.angle")), b(k, b.index("elbow")) - bent, 1e-13);
  }
}

TEST(Joints, SliderCrankMovesInClosedForm) {
  const double r = 0.1, l = 0.3;
  const Scene scene = SceneBuilder("slider_crank", 2)
                          .add(Body{.name = "crank"})
                          .add(Body{.name = "rod"})
                          .add(Body{.name = "piston", .points = {{"corner", {0.5, 0.05, 0}, true}}})
                          .joint("O", Revolute{"ground", "crank", Triple{0, 0, 0}})
                          .joint("B", Revolute{"crank", "rod", Triple{r, 0, 0}})
                          .joint("C", Revolute{"rod", "piston", Triple{r + l, 0, 0}})
                          .joint("S", Prismatic{"ground", "piston", Triple{2, 0, 0}})
                          .drive("motor", DrivenCoordinate{"O.angle", turning(1)})
                          .output("S.displacement")
                          .output("C.angle")
                          .output("corner")
                          .time(0, 7, 0.1)
                          .build();
  EXPECT_EQ(unknowns(scene), 3u);  // C and the displacement
  const Trajectory t = test::run(scene).trajectory;
  for (std::size_t k = 0; k < t.rows(); ++k) {
    const double phi = t.times()[k], x = r * std::cos(phi) + std::sqrt(l * l - r * r * std::sin(phi) * std::sin(phi));
    EXPECT_NEAR(t(k, t.index("S.displacement")), x - r - l, 1e-14);
    EXPECT_NEAR(t(k, t.index("C.angle")), std::asin(r / l * std::sin(phi)), 1e-14);
    EXPECT_NEAR(t(k, t.index("corner.x")), x + 0.1, 1e-14);
    EXPECT_NEAR(t(k, t.index("corner.y")), 0.05, 1e-14);
  }
}

// A driven prismatic joint, on a body that turns.
TEST(Joints, PrismaticJointSlidesOnAMovingBody) {
  const Scene scene = SceneBuilder("crane", 2)
                          .add(Body{.name = "boom"})
                          .add(Body{.name = "tip", .points = {{"T", {3, 0.2, 0}, true}}})
                          .joint("A", Revolute{"ground", "boom", Triple{0, 0, 0}})
                          .joint("S", Prismatic{"boom", "tip", Triple{1, 0, 0}})
                          .drive("turn", DrivenCoordinate{"A.angle", turning(1)})
                          .drive("reach", DrivenCoordinate{"S.displacement", turning(0.5)})
                          .output("T")
                          .time(0, 7, 0.1)
                          .build();
  const Trajectory t = test::run(scene).trajectory;
  for (std::size_t k = 0; k < t.rows(); ++k) {
    const double s = t.times()[k], x = 3 + 0.5 * s, c = std::cos(s), d = std::sin(s);
    EXPECT_NEAR(t(k, t.index("T.x")), x * c - 0.2 * d, 1e-13);
    EXPECT_NEAR(t(k, t.index("T.y")), x * d + 0.2 * c, 1e-13);
    EXPECT_NEAR(t(k, t.index("T.vx")), 0.5 * c - x * d - 0.2 * c, 1e-13);
  }
}

// ---- in space

// Two shafts with an angle beta between them.
Scene cardan(double beta, const Matrix& r, double speed) {
  const auto turned = [&](const Triple& a) { return times(r, a); };
  const Triple out{std::cos(beta), std::sin(beta), 0};
  return SceneBuilder("cardan", 3)
      .add(Body{.name = "driving"})
      .add(Body{.name = "driven"})
      .joint("A", Revolute{"ground", "driving", turned({-1, 0, 0}), turned({1, 0, 0})})
      .joint("U", Universal{"driving", "driven", turned({0, 0, 0}), turned({0, 0, 1}),
                            turned({-std::sin(beta), std::cos(beta), 0})})
      .joint("B", Revolute{"ground", "driven", turned(out), turned(out)})
      .drive("motor", DrivenCoordinate{"A.angle", turning(speed)})
      .output("A.angle")
      .output("B.angle")
      .time(0, 4 * kPi, 4 * kPi / 200)
      .build();
}

TEST(Joints, UniversalJointTurnsInClosedFormInEveryPosture) {
  const double beta = 0.6;
  std::vector<Matrix> postures;
  for (const double x : {0.0, kPi / 2, kPi, 1.0}) {
    for (const double y : {0.0, kPi / 2, -0.7}) {
      for (const double z : {0.0, kPi / 2, 2.0}) postures.push_back(rotation(x, y, z));
    }
  }
  for (const Matrix& r : postures) {
    test::Result run = test::run(cardan(beta, r, 1));
    const Trajectory& t = run.trajectory;
    ASSERT_EQ(t.rows(), 201u);
    for (std::size_t k = 0; k < t.rows(); ++k) {
      const double phi = t.times()[k], turns = 2 * kPi * std::round(phi / (2 * kPi));
      const double psi = turns + std::atan2(std::sin(phi - turns) * std::cos(beta), std::cos(phi - turns));
      EXPECT_NEAR(t(k, t.index("A.angle")), phi, 1e-13);
      EXPECT_NEAR(std::remainder(t(k, t.index("B.angle")) - psi, 2 * kPi), 0, 1e-13) << k;
    }
    for (const GroupFigures& g : run.simulator.examine()) EXPECT_LT(g.condition, 100);
  }
}

// Bennett (1903): four links with the twists alpha and beta, sin(alpha) / a = sin(beta) / b. One equation is redundant.
TEST(Joints, BennettLinkageMakesFullTurns) {
  const double a = 1, b = 1.5, alpha = 0.5, beta = std::asin(b / a * std::sin(alpha)), theta = 0.7;
  const double k = std::sin((beta + alpha) / 2) / std::sin((beta - alpha) / 2);
  const double theta2 = 2 * std::atan(k / std::tan(theta / 2));
  // Denavit-Hartenberg frames around the loop: joint i turns about z, a link goes along x.
  Triple at{}, x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  SceneBuilder builder("bennett", 3);
  for (const char* link : {"l1", "l2", "l3"}) builder.add(Body{.name = link});
  const char* const names[] = {"ground", "l1", "l2", "l3", "ground"};
  const double turns[] = {theta, theta2, -theta, -theta2};
  for (std::size_t i = 0; i < 4; ++i) {
    builder.joint("J" + std::to_string(i + 1), Revolute{names[i], names[i + 1], at, z});
    const double c = std::cos(turns[i]), s = std::sin(turns[i]), twist = i % 2 == 0 ? alpha : beta;
    const Triple along = triple::add(triple::scale(c, x), triple::scale(s, y));
    const Triple across = triple::add(triple::scale(-s, x), triple::scale(c, y));
    at = triple::add(at, triple::scale(i % 2 == 0 ? a : b, along));
    x = along;
    y = triple::add(triple::scale(std::cos(twist), across), triple::scale(std::sin(twist), z));
    z = triple::cross(x, y);
  }
  EXPECT_LT(triple::norm(at), 1e-15);
  builder.drive("motor", DrivenCoordinate{"J1.angle", turning(1)});
  for (const char* output : {"J1.angle", "J2.angle", "J3.angle", "J4.angle"}) builder.output(output);
  test::Result run = test::run(builder.time(0, 4 * kPi, 4 * kPi / 400).build());
  const Trajectory& t = run.trajectory;
  ASSERT_EQ(t.rows(), 401u);
  for (std::size_t row = 0; row < t.rows(); ++row) {
    const double first = theta + t(row, 0), second = theta2 + t(row, t.index("J2.angle"));
    EXPECT_NEAR(std::sin(first / 2) * std::sin(second / 2), k * std::cos(first / 2) * std::cos(second / 2), 1e-12);
    EXPECT_NEAR(t(row, t.index("J3.angle")), -t(row, 0), 1e-12);
    EXPECT_NEAR(t(row, t.index("J4.angle")), -t(row, t.index("J2.angle")), 1e-12);
  }
  EXPECT_LT(run.simulator.report().error.residual(), 1e-14);
}

// Sarrus (1853): two pairs of links let the top move straight up. One equation is redundant.
TEST(Joints, SarrusLinkageMovesStraight) {
  SceneBuilder builder("sarrus", 3);
  for (const char* name : {"a1", "a2", "b1", "b2"}) builder.add(Body{.name = name});
  builder.add(Body{.name = "top", .points = {{"T", {0.5, 0.5, 1}, true}}});
  const auto chain = [&](const std::string& n, const Triple& out, const Triple& axis) {
    const auto at = [&](double r, double h) { return triple::add(triple::scale(r, out), Triple{0, 0, h}); };
    builder.joint(n + "0", Revolute{"ground", n + "1", at(1, 0), axis});
    builder.joint(n + "1_", Revolute{n + "1", n + "2", at(1.8, 0.5), axis});
    builder.joint(n + "2_", Revolute{n + "2", "top", at(1, 1), axis});
  };
  chain("a", {1, 0, 0}, {0, 1, 0});
  chain("b", {0, 1, 0}, {1, 0, 0});
  builder.drive("motor", DrivenCoordinate{"a0.angle", turning(0.4)}).output("T").output("b0.angle");
  test::Result run = test::run(builder.time(0, 1, 0.01).build());
  const Trajectory& t = run.trajectory;
  ASSERT_EQ(t.rows(), 101u);
  const double l = std::hypot(0.8, 0.5), start = std::atan2(0.5, 0.8), off = tolerance(run);
  for (std::size_t k = 0; k < t.rows(); ++k) {
    EXPECT_NEAR(t(k, t.index("T.x")), 0.5, off);
    EXPECT_NEAR(t(k, t.index("T.y")), 0.5, off);
    EXPECT_NEAR(t(k, t.index("T.z")), 2 * l * std::sin(start - 0.4 * t.times()[k]), off);
    EXPECT_NEAR(t(k, t.index("b0.angle")), -0.4 * t.times()[k], off);  // relative to the axis x the sign is opposite
  }
  EXPECT_LT(run.simulator.report().error.residual(), 1e-14);
}

// A body with a frame of its own, moved by six struts, each with a universal, a prismatic and a spherical joint.
TEST(Joints, StewartPlatformMovesOnStruts) {
  SceneBuilder builder("platform", 3);
  builder.point("O", {0, 0, 1}).vector("u", {1, 0, 0}).vector("v", {0, 1, 0}).vector("w", {0, 0, 1});
  Body plate{.name = "plate", .origin = "O", .frame = {"u", "v", "w"}};
  std::vector<Triple> feet, hands;
  for (int i = 0; i < 6; ++i) {
    const double foot = kPi / 3 * (i + 0.2 * (i % 2)), hand = kPi / 3 * (i - 0.2 * (i % 2)) + 0.3;
    feet.push_back({std::cos(foot), std::sin(foot), 0});
    hands.push_back({0.6 * std::cos(hand), 0.6 * std::sin(hand), 1});
    plate.points.push_back({"P" + std::to_string(i), triple::subtract(hands.back(), {0, 0, 1})});
  }
  builder.add(plate);
  for (std::size_t i = 0; i < 6; ++i) {
    const std::string n = std::to_string(i);
    const Triple along = triple::subtract(hands[i], feet[i]);
    const Triple side = triple::cross(along, {0, 0, 1}), other = triple::cross(along, side);
    builder.add(Body{.name = "cylinder" + n}).add(Body{.name = "rod" + n});
    builder.joint("U" + n, Universal{"ground", "cylinder" + n, feet[i], side, other});
    builder.joint("L" + n, Prismatic{"cylinder" + n, "rod" + n, along});
    builder.joint("S" + n, Spherical{"rod" + n, "plate", "P" + n});
    builder.drive("cylinder_" + n, DrivenCoordinate{"L" + n + ".displacement",
                                                    Law::polynomial({0, 0.01 * (static_cast<double>(i) - 2)})});
    builder.measure("length" + n, MeasuredDistance{"U" + n, "P" + n});
  }
  const Scene scene = builder.time(0, 1, 0.02).build();
  test::Result run = test::run(scene);
  const Trajectory& t = run.trajectory;
  ASSERT_EQ(t.rows(), 51u);
  for (std::size_t i = 0; i < 6; ++i) {
    const double start = triple::norm(triple::subtract(hands[i], feet[i]));
    const std::size_t c = t.index("length" + std::to_string(i));
    for (std::size_t k = 0; k < t.rows(); ++k) {
      EXPECT_NEAR(t(k, c), start + 0.01 * (static_cast<double>(i) - 2) * t.times()[k], 1e-13);
    }
  }
}

TEST(Joints, RigidKeepsPointsAndVectorsInPlace) {
  const Scene scene = SceneBuilder("rigid", 3)
                          .fixed_point("O", {0, 0, 0})
                          .fixed_vector("axis", {0, 0, 1})
                          .point("P", {1, 0, 0})
                          .point("Q", {0.5, 0.7, 0.4})
                          .vector("n", {0.6, 0, 0.8})
                          .add(Body{.name = "arm", .rigid = {"O", "axis", "P", "Q", "n"}})
                          .drive("motor", PointAngle{"O", "P", "axis", turning(1)})
                          .time(0, 7, 0.5)
                          .build();
  const Trajectory t = test::run(scene).trajectory;
  for (std::size_t k = 0; k < t.rows(); ++k) {
    const double c = std::cos(t.times()[k]), s = std::sin(t.times()[k]);
    EXPECT_NEAR(t(k, t.index("Q.x")), 0.5 * c - 0.7 * s, 1e-14);
    EXPECT_NEAR(t(k, t.index("Q.y")), 0.5 * s + 0.7 * c, 1e-14);
    EXPECT_NEAR(t(k, t.index("Q.z")), 0.4, 1e-14);
    EXPECT_NEAR(t(k, t.index("n.x")), 0.6 * c, 1e-14);
    EXPECT_NEAR(t(k, t.index("n.y")), 0.6 * s, 1e-14);
  }
}

// Bodies that a fixed joint connects move as one.
TEST(Joints, FixedJointMakesOneBody) {
  const auto scene = [](bool two) {
    SceneBuilder builder("welded", 2);
    builder.add(Body{.name = "crank"}).add(Body{.name = "rocker"});
    builder.add(Body{.name = "coupler"});
    const std::string other = two ? "plate" : "coupler";
    if (two) builder.add(Body{.name = "plate"}).joint("weld", Fixed{"coupler", "plate"});
    return builder.joint("A", Revolute{"ground", "crank", Triple{0, 0, 0}})
        .joint("B", Revolute{"crank", "coupler", Triple{0.8, 0, 0}})
        .joint("C", Revolute{other, "rocker", Triple{1.6, 1.2, 0}})
        .joint("D", Revolute{"ground", "rocker", Triple{2, 0, 0}})
        .drive("motor", DrivenCoordinate{"A.angle", turning(0.5)})
        .output("D.angle")
        .time(0, 0.8, 0.1)
        .build();
  };
  EXPECT_EQ(unknowns(scene(true)), unknowns(scene(false)));
  EXPECT_EQ(test::run(scene(true)).trajectory.values(), test::run(scene(false)).trajectory.values());
}

// ---- random loops with one degree of freedom

struct RandomLoop {
  Scene scene;
  std::string joints;  // a letter for each joint
};

// A loop of random joints with seven freedoms in total, at random places and in random directions. The first joint is
// revolute and driven.
RandomLoop random_loop(std::mt19937_64& random) {
  std::uniform_real_distribution<double> coordinate(-1, 1);
  const auto triple_of = [&] { return Triple{coordinate(random), coordinate(random), coordinate(random)}; };
  std::string joints = "R";
  for (int left = 6; left > 0;) {
    static constexpr std::pair<char, int> kFreedoms[] = {{'R', 1}, {'P', 1}, {'C', 2}, {'U', 2}, {'S', 3}, {'E', 3}};
    const auto [letter, freedoms] = kFreedoms[random() % 6];
    if (freedoms > left) continue;
    joints += letter;
    left -= freedoms;
  }
  SceneBuilder builder("loop", 3);
  const std::size_t count = joints.size();
  const auto body = [&](std::size_t i) { return i % count == 0 ? std::string("ground") : "b" + std::to_string(i); };
  for (std::size_t i = 1; i < count; ++i) {
    builder.add(Body{.name = body(i), .points = {{"M" + std::to_string(i), triple_of(), true}}});
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Triple at = triple_of(), axis = triple_of(), other = triple::cross(axis, triple_of());
    test::add(builder, {joints[i], "J" + std::to_string(i), body(i), body(i + 1), at, axis, other});
  }
  builder.drive("motor", DrivenCoordinate{"J0.angle", turning(1)}).time(0, 0.02, 0.002);
  return {builder.build(), joints};
}

// Some loops cannot move, for example with three prismatic joints in a row. No loop moves wrongly.
TEST(Joints, RandomLoopsKeepBodiesRigid) {
  std::mt19937_64 random(23);
  int moved = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const RandomLoop loop = random_loop(random);
    SCOPED_TRACE("loop " + std::to_string(trial) + ": " + loop.joints);
    try {
      const test::Result run = test::run(loop.scene);
      const bool ok = run.simulator.report().status.code == Code::ok;
      moved += ok ? 1 : 0;
      if (!ok) continue;
      EXPECT_LT(change_of_shapes(loop.scene, run.trajectory, 1), 1e-9);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), Error::Kind::input) << error.what();
    }
  }
  EXPECT_GT(moved, 120);
}

// The slide cannot move: a hinge joins it to the same arm. Its equations hold whatever the arm does.
TEST(Joints, ASlideThatRestsOnItsArmTurnsWithIt) {
  for (const double degrees : {0.0, 15.0, 33.0, 90.0, 141.0}) {
    SCOPED_TRACE(degrees);
    const double angle = degrees * kTurn / 360;
    SceneBuilder builder("locked", 2);
    builder.add(Body{"arm"}).add(Body{"slide"});
    builder.joint("base", Revolute{"arm", "ground", Triple{0, 0, 0}});
    builder.joint("P", Prismatic{"slide", "arm", Triple{std::cos(angle), std::sin(angle), 0}});
    builder.joint("R", Revolute{"arm", "slide", Triple{0.3, -0.2, 0}});
    builder.drive("motor", DrivenCoordinate{"base.angle", Law::polynomial({0, kTurn})}).time(0, 1, 0.01);
    const test::Result run = test::run(builder.build());
    EXPECT_EQ(run.report().status.code, Code::ok);
    EXPECT_LE(run.report().error.position, 1e-14);
  }
}

// A shaft with a cylindrical joint and a hinge on one line: the displacement is the constant 0.
TEST(Joints, AJointThatCannotSlideHasTheDisplacementZero) {
  const Scene scene = SceneBuilder("shaft", 3)
                          .add(Body{.name = "d", .points = {{"K", {1, 0.2, 0.5}, true}}})
                          .joint("H", Cylindrical{"ground", "d", Triple{0, 0, 0}, Triple{0, 0, 1}})
                          .joint("R", Revolute{"ground", "d", Triple{0, 0, 2}, Triple{0, 0, 1}})
                          .drive("motor", DrivenCoordinate{"R.angle", Law::polynomial({0, 7})})
                          .measure("m", MeasuredCoordinate{"H.displacement"})
                          .output("d")
                          .output("K")
                          .output("H.angle")
                          .output("H.displacement")
                          .output("m")
                          .time(0, 1, 0.125)
                          .build();
  // The outputs of a pose whose origin is a point of the scene can be asked for again.
  std::vector<std::string> more = scene.outputs();
  more.push_back("R.axis.x");
  EXPECT_EQ(scene.with_outputs(more).outputs(), more);
  const test::Result run = test::run(scene);
  EXPECT_EQ(run.report().status.code, Code::ok);
  const Trajectory& t = run.trajectory;
  ASSERT_EQ(t.rows(), 9u);
  for (std::size_t k = 0; k < t.rows(); ++k) {
    EXPECT_NEAR(t(k, t.index("H.angle")), 7 * t.times()[k], 1e-13);
    for (const char* name : {"H.displacement", "m"}) {
      for (const char* part : {"", ".rate", ".acceleration"}) {
        EXPECT_EQ(t(k, t.index(name + std::string(part))), 0) << name << part;
      }
    }
  }
}

}  // namespace
}  // namespace assur
