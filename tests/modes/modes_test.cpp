#include "assur/modes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "assur/simulator.hpp"
#include "source_dir.hpp"

namespace assur {
namespace {

using Real = long double;

double value(const AssemblyModes& modes, const AssemblyMode& mode, const std::string& name) {
  for (std::size_t j = 0; j < modes.unknowns.size(); ++j) {
    if (modes.unknowns[j] == name) return mode.values[j];
  }
  ADD_FAILURE() << "no unknown " << name;
  return 0;
}

// The ends of all paths add up, and no path is lost.
void expect_closed_count(const AssemblyModes& m) {
  EXPECT_EQ(static_cast<int>(m.modes.size()) + m.not_real + m.diverged + m.multiple + m.excluded, m.paths) << m.group;
  EXPECT_TRUE(m.complete()) << m.group;
}

Scene four_bar(double angle) {
  return SceneBuilder("four_bar", 2)
      .fixed_point("A", {0, 0})
      .fixed_point("D", {2, 0})
      .point("B", {0.8, 0})
      .point("C", {1.6, 1.2})
      .constrain("coupler", Distance{"B", "C", 1.8})
      .constrain("rocker", Distance{"D", "C", 1.3})
      .drive("motor", PointAngle{"A", "B", "", Law::polynomial({angle, 1})})
      .time(0, 0.5, 0.01)
      .build();
}

// The dyad of a four-bar is the intersection of two circles.
TEST(Modes, DyadHasTwo) {
  for (const double angle : {0.0, 0.4, 1.0, 2.5, 4.0}) {
    const std::vector<AssemblyModes> all = assembly_modes(four_bar(angle));
    ASSERT_EQ(all.size(), 1u);  // B is driven
    const AssemblyModes& m = all.front();
    EXPECT_EQ(m.group, "C");
    EXPECT_EQ(m.unknowns, (std::vector<std::string>{"C.x", "C.y"}));
    ASSERT_EQ(m.modes.size(), 2u);
    EXPECT_TRUE(m.has_start);
    expect_closed_count(m);
    const double bx = 0.8 * std::cos(angle), by = 0.8 * std::sin(angle);
    const double dx = 2 - bx, dy = -by, d = std::hypot(dx, dy);
    const double along = (d * d + 1.8 * 1.8 - 1.3 * 1.3) / (2 * d), across = std::sqrt(1.8 * 1.8 - along * along);
    for (const std::size_t k : {0u, 1u}) {
      const double side = k == 0 ? across : -across;  // the guess is to the left of BD
      EXPECT_NEAR(m.modes[k].values[0], bx + (along * dx - side * dy) / d, 1e-14);
      EXPECT_NEAR(m.modes[k].values[1], by + (along * dy + side * dx) / d, 1e-14);
      EXPECT_LT(m.modes[k].residual, 1e-15);
    }
  }
}

// A platform in the plane on three legs of given lengths. Base and platform are those of Innocenti and Merlet, which
// Zein, Wenger and Chablat use (Non-singular assembly-mode changing motions for 3-RPR parallel manipulators, Mechanism
// and Machine Theory 43, 2008). The group has at most six modes for each orientation of the triangle (Gosselin,
// Sefrioui and Richard, Solutions polynomiales au problème de la cinématique directe des manipulateurs parallèles plans
// à trois degrés de liberté, Mechanism and Machine Theory 27, 1992).
struct Platform {
  std::array<Real, 3> leg{14.98L, 15.38L, 12.0L};
  bool mirrored = false;

  static constexpr Real kA2 = 15.91L, kA3 = 10, kD12 = 17.04L, kD23 = 16.54L, kD13 = 20.84L;

  // Position of B3 in axes with their origin at B1 and x to B2.
  [[nodiscard]] std::array<Real, 2> third() const {
    const Real x = (kD12 * kD12 + kD13 * kD13 - kD23 * kD23) / (2 * kD12);
    const Real y = std::sqrt(kD13 * kD13 - x * x);
    return {x, mirrored ? -y : y};
  }

  // B1, B2, B3 at the angle phi of the platform, from the first two legs: B1 is where the circle of leg 1 meets the
  // circle of leg 2, moved by B1 - B2. False if they do not meet.
  [[nodiscard]] bool at(Real phi, bool left, std::array<Real, 6>& b) const {
    const Real c = std::cos(phi), s = std::sin(phi);
    const Real ox = kA2 - kD12 * c, oy = -kD12 * s, d = std::hypot(ox, oy);
    const Real along = (d * d + leg[0] * leg[0] - leg[1] * leg[1]) / (2 * d), h = leg[0] * leg[0] - along * along;
    if (!(h >= 0)) return false;
    const Real across = left ? std::sqrt(h) : -std::sqrt(h);
    const Real x = (along * ox - across * oy) / d, y = (along * oy + across * ox) / d;
    const auto [u, v] = third();
    b = {x, y, x + kD12 * c, y + kD12 * s, x + u * c - v * s, y + u * s + v * c};
    return true;
  }

  // All postures: sign changes of the error of the third leg over the angle, by bisection.
  [[nodiscard]] std::vector<std::array<double, 6>> postures() const {
    constexpr int kAngles = 100000;
    std::vector<std::array<double, 6>> out;
    std::array<Real, 6> b{};
    const auto error = [&](Real phi, bool left, Real& e) {
      if (!at(phi, left, b)) return false;
      e = b[4] * b[4] + (b[5] - kA3) * (b[5] - kA3) - leg[2] * leg[2];
      return true;
    };
    for (const bool left : {true, false}) {
      for (int k = 0; k < kAngles; ++k) {
        Real low = 2 * std::numbers::pi_v<Real> * k / kAngles, high = 2 * std::numbers::pi_v<Real> * (k + 1) / kAngles;
        Real e_low = 0, e_high = 0, e = 0;
        if (!error(low, left, e_low) || !error(high, left, e_high) || (e_low < 0) == (e_high < 0)) continue;
        for (int i = 0; i < 100; ++i) {
          const Real middle = (low + high) / 2;
          if (!error(middle, left, e)) break;
          ((e < 0) == (e_low < 0) ? low : high) = middle;
        }
        (void)at(low, left, b);
        std::array<double, 6> posture{};
        std::transform(b.begin(), b.end(), posture.begin(), [](Real v) { return static_cast<double>(v); });
        out.push_back(posture);
      }
    }
    return out;
  }

  // As a scene with three points: both orientations of the triangle satisfy its equations.
  [[nodiscard]] Scene points(const std::array<double, 6>& b) const {
    SceneBuilder builder = begun();
    return builder.point("B1", {b[0], b[1]})
        .point("B2", {b[2], b[3]})
        .point("B3", {b[4], b[5]})
        .constrain("d12", Distance{"B1", "B2", static_cast<double>(kD12)})
        .constrain("d23", Distance{"B2", "B3", static_cast<double>(kD23)})
        .constrain("d13", Distance{"B1", "B3", static_cast<double>(kD13)})
        .build();
  }

  // As a scene with a body: B3 is affine in B1 and B2.
  [[nodiscard]] Scene body(const std::array<double, 6>& b) const {
    const auto [u, v] = third();
    SceneBuilder builder = begun();
    return builder.point("B1", {b[0], b[1]})
        .point("B2", {b[2], b[3]})
        .constrain("d12", Distance{"B1", "B2", static_cast<double>(kD12)})
        .add(Body{.name = "platform",
                  .base = {"B1", "B2"},
                  .points = {{"B3", {static_cast<double>(u), static_cast<double>(v)}}}})
        .build();
  }

 private:
  [[nodiscard]] SceneBuilder begun() const {
    SceneBuilder builder("platform", 2);
    builder.fixed_point("A1", {0, 0});
    builder.fixed_point("A2", {static_cast<double>(kA2), 0});
    builder.fixed_point("A3", {0, static_cast<double>(kA3)});
    for (const int k : {1, 2, 3}) {
      const std::string n = std::to_string(k);
      builder.drive(
          "leg" + n,
          DrivenDistance{"A" + n, "B" + n, Law::constant(static_cast<double>(leg[static_cast<std::size_t>(k - 1)]))});
    }
    return builder;
  }
};

// Compares the unknowns of all modes with postures in any order.
void expect_same(const AssemblyModes& m, std::vector<std::array<double, 6>> postures) {
  static const std::array<std::string, 6> kNames = {"B1.x", "B1.y", "B2.x", "B2.y", "B3.x", "B3.y"};
  ASSERT_EQ(m.modes.size(), postures.size());
  for (const AssemblyMode& mode : m.modes) {
    const auto far = [&](const std::array<double, 6>& p) {
      double most = 0;
      for (std::size_t j = 0; j < 6; ++j) {
        if (std::find(m.unknowns.begin(), m.unknowns.end(), kNames[j]) == m.unknowns.end()) continue;
        most = std::max(most, std::abs(value(m, mode, kNames[j]) - p[j]));
      }
      return most;
    };
    const auto nearest = std::min_element(postures.begin(), postures.end(),
                                          [&](const auto& a, const auto& b) { return far(a) < far(b); });
    EXPECT_LT(far(*nearest), 1e-12);  // m; lengths are 10 to 20 m, conditions below 100
    EXPECT_LT(mode.condition, 100);
    EXPECT_LT(mode.residual, 1e-14);
    postures.erase(nearest);
  }
}

TEST(Modes, PlatformInThePlaneHasSix) {
  Platform platform;
  const std::vector<std::array<double, 6>> postures = platform.postures();
  ASSERT_EQ(postures.size(), 6u);
  for (std::size_t k = 0; k < postures.size(); ++k) {
    const AssemblyModes m = assembly_modes(platform.body(postures[k]), "B1");
    EXPECT_EQ(m.unknowns.size(), 4u);
    EXPECT_EQ(m.paths, 16);
    expect_closed_count(m);
    EXPECT_TRUE(m.has_start);
    expect_same(m, postures);
    EXPECT_NEAR(value(m, m.modes[0], "B1.x"), postures[k][0], 1e-12);
    EXPECT_EQ(m.nearest("B1", {postures[k][0] + 0.1, postures[k][1]}), 0u);
  }
}

// Written with three points, the triangle may also lie on its back.
TEST(Modes, TriangleOfThreePointsHasBothOrientations) {
  Platform platform;
  std::vector<std::array<double, 6>> postures = platform.postures();
  const std::array<double, 6> first = postures.front();
  platform.mirrored = true;
  const std::vector<std::array<double, 6>> mirrored = platform.postures();
  ASSERT_FALSE(mirrored.empty());
  postures.insert(postures.end(), mirrored.begin(), mirrored.end());
  const AssemblyModes m = assembly_modes(platform.points(first), "B1+B2+B3");
  EXPECT_EQ(m.unknowns.size(), 6u);
  EXPECT_EQ(m.paths, 64);
  EXPECT_EQ(static_cast<int>(m.modes.size()) + m.not_real, 12);
  expect_closed_count(m);
  expect_same(m, postures);
}

// Where two of the six modes meet, they are one fold and no modes.
TEST(Modes, MeetingModesAreAFold) {
  Platform platform;
  const std::array<double, 6> guess = platform.postures().front();
  const auto modes = [&](double leg) {
    platform.leg[2] = leg;
    return assembly_modes(platform.body(guess), "B1");
  };
  double six = 12, fewer = 12;
  while (modes(fewer).modes.size() == 6) fewer += 0.25;
  ASSERT_LT(fewer, 30);
  ASSERT_EQ(modes(fewer).modes.size(), 4u);
  AssemblyModes meeting;
  while (meeting.multiple == 0) {
    const double middle = (six + fewer) / 2;
    ASSERT_TRUE(six < middle && middle < fewer);
    meeting = modes(middle);
    ASSERT_TRUE(meeting.complete());
    (meeting.modes.size() == 6 ? six : fewer) = middle;
  }
  EXPECT_EQ(meeting.multiple, 2);
  EXPECT_EQ(meeting.modes.size(), 4u);
  ASSERT_EQ(meeting.folds.size(), 1u);
  const AssemblyModes before = modes(six), after = modes(fewer + 1e-3);
  ASSERT_EQ(before.modes.size(), 6u);
  EXPECT_EQ(after.not_real, 2);
  const auto worst = std::max_element(before.modes.begin(), before.modes.end(),
                                      [](const auto& a, const auto& b) { return a.condition < b.condition; });
  EXPECT_GT(worst->condition, 1e5);
  for (std::size_t j = 0; j < 4; ++j) EXPECT_NEAR(worst->values[j], meeting.folds[0][j], 1e-3);
}

// The platform on three legs of the 3-RPS manipulator has 16 postures, real or not (Nanua, Waldron and Murthy, Direct
// kinematic solution of a Stewart platform, IEEE Transactions on Robotics and Automation 6, 1990).
TEST(Modes, ThreeRpsHasSixteen) {
  const Scene scene = read_scene(ASSUR_SOURCE_DIR "/scenes/three_rps.json");
  const AssemblyModes m = assembly_modes(scene, "P1");
  EXPECT_EQ(m.paths, 64);
  EXPECT_EQ(static_cast<int>(m.modes.size()) + m.not_real + m.excluded, 16);
  expect_closed_count(m);
  EXPECT_TRUE(m.has_start);
}

// A point at given distances of three others.
TEST(Modes, PointOnThreeSpheresHasTwo) {
  const Scene scene = SceneBuilder("tripod", 3)
                          .fixed_point("A", {0, 0, 0})
                          .fixed_point("B", {1, 0, 0})
                          .fixed_point("C", {0, 1, 0})
                          .point("P", {0.3, 0.4, 0.9})
                          .constrain("a", Distance{"A", "P", 1})
                          .constrain("b", Distance{"B", "P", 1})
                          .constrain("c", Distance{"C", "P", 1})
                          .build();
  const AssemblyModes m = assembly_modes(scene, "P");
  ASSERT_EQ(m.modes.size(), 2u);
  EXPECT_EQ(m.paths, 2);
  expect_closed_count(m);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_NEAR(m.modes[k].values[0], 0.5, 1e-15);
    EXPECT_NEAR(m.modes[k].values[1], 0.5, 1e-15);
    EXPECT_NEAR(m.modes[k].values[2], k == 0 ? std::sqrt(0.5) : -std::sqrt(0.5), 1e-15);
  }
}

TEST(Modes, SomeGroupsHaveOneMode) {
  // Linear equations.
  const Scene linear = SceneBuilder("linear", 2)
                           .fixed_point("A", {1, 2})
                           .point("P", {0, 0})
                           .constrain("twice", Linear{{{"P", 1}, {"A", -2}}, {}})
                           .build();
  const AssemblyModes one = assembly_modes(linear, "P.x");
  ASSERT_EQ(one.modes.size(), 1u);
  EXPECT_EQ(one.paths, 1);
  EXPECT_EQ(one.modes[0].values, (std::vector<double>{2}));
  // The angle between two rods has a direction: with rho < 0 it would be off by half a turn.
  const Scene rods = SceneBuilder("rods", 2)
                         .fixed_point("A", {0, 0})
                         .fixed_point("B", {1, 0})
                         .point("C", {1.5, 0.8})
                         .constrain("rod", Distance{"B", "C", 1})
                         .drive("elbow", RelativeAngle{{"A", "B"}, {"B", "C"}, "", Law::constant(1.0)})
                         .build();
  const AssemblyModes elbow = assembly_modes(rods, "C");
  ASSERT_EQ(elbow.modes.size(), 1u);
  EXPECT_EQ(elbow.excluded, 1);
  expect_closed_count(elbow);
  EXPECT_NEAR(value(elbow, elbow.modes[0], "C.x"), 1 + std::cos(1.0), 1e-15);
}

// At a fold, both modes of the dyad are one. The scene cannot be prepared there.
TEST(Modes, DyadAtItsFoldHasNone) {
  for (const double length : {1.0, 1 + 0x1p-50, 1 - 0x1p-50}) {
    const Scene scene = SceneBuilder("stretched", 2)
                            .fixed_point("A", {0, 0})
                            .fixed_point("D", {2, 0})
                            .point("P", {1, 0})
                            .constrain("rod", Distance{"D", "P", 1})
                            .drive("cylinder", DrivenDistance{"A", "P", Law::constant(length)})
                            .build();
    const AssemblyModes m = assembly_modes(scene, "P");
    EXPECT_TRUE(m.modes.empty());
    EXPECT_FALSE(m.has_start);
    EXPECT_EQ(m.multiple, 2);
    EXPECT_EQ(m.lost, 0);
    ASSERT_EQ(m.folds.size(), 1u);
    EXPECT_NEAR(m.folds[0][0], 1, 1e-6);
    EXPECT_NEAR(m.folds[0][1], 0, 1e-6);
    EXPECT_THROW((void)m.nearest("P", {1, 0}), Error);
  }
}

// Rods that are too short have no posture at all, which is an answer and no failure.
TEST(Modes, RodsThatAreTooShortHaveNoMode) {
  const Scene scene = SceneBuilder("short", 2)
                          .fixed_point("A", {0, 0})
                          .fixed_point("D", {2, 0})
                          .point("P", {1, 0.1})
                          .point("Q", {1, 1})
                          .constrain("left", Distance{"A", "P", 0.9})
                          .constrain("right", Distance{"D", "P", 0.9})
                          .constrain("top", Distance{"P", "Q", 1})
                          .constrain("side", Distance{"A", "Q", 1})
                          .build();
  const std::vector<AssemblyModes> all = assembly_modes(scene);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_TRUE(all[0].modes.empty());
  EXPECT_EQ(all[0].not_real, 2);
  EXPECT_FALSE(all[0].has_start);
  EXPECT_TRUE(all[0].complete());
  EXPECT_EQ(all[1].why_none, "depends on group P, which has no posture; choose a mode of it");
}

TEST(Modes, ChosenModesAreTheStartPosture) {
  const Scene scene = four_bar(0.4);
  const AssemblyModes m = assembly_modes(scene, "C");
  for (std::size_t k = 0; k < m.modes.size(); ++k) {
    Simulator simulator(prepare_in_modes(scene, {{"C", k}}));
    const Trajectory motion = simulator.run();
    ASSERT_TRUE(simulator.report().status.ok());
    EXPECT_NEAR(motion(0, motion.index("C.x")), m.modes[k].values[0], 1e-15);
    EXPECT_NEAR(motion(0, motion.index("C.y")), m.modes[k].values[1], 1e-15);
    // The whole motion stays in the mode: C on the same side of BD.
    const auto side = [&](double cx, double cy, double angle) {
      const double bx = 0.8 * std::cos(angle), by = 0.8 * std::sin(angle);
      return (2 - bx) * (cy - by) + by * (cx - bx) > 0;
    };
    for (std::size_t row = 0; row < motion.rows(); ++row) {
      EXPECT_EQ(side(motion(row, motion.index("C.x")), motion(row, motion.index("C.y")), 0.4 + motion.times()[row]),
                k == 0);
    }
  }
  EXPECT_EQ(m.nearest("C", {1, 2}), 0u);
  EXPECT_EQ(m.nearest("C", {1, -2}), 1u);
}

// Groups after a chosen one have the modes that belong to it: the second loop stands on C.
TEST(Modes, LaterGroupsFollowAChoice) {
  const Scene scene = SceneBuilder("two_loops", 2)
                          .fixed_point("A", {0, 0})
                          .fixed_point("D", {2, 0})
                          .fixed_point("F", {4, 0})
                          .point("B", {0.8, 0})
                          .point("C", {1.6, 1.2})
                          .point("E", {3, 1.5})
                          .constrain("coupler", Distance{"B", "C", 1.8})
                          .constrain("rocker", Distance{"D", "C", 1.3})
                          .constrain("second_coupler", Distance{"C", "E", 2})
                          .constrain("second_rocker", Distance{"F", "E", 2})
                          .drive("motor", PointAngle{"A", "B", "", Law::polynomial({0.3, 1})})
                          .build();
  const AssemblyModes c = assembly_modes(scene, "C");
  ASSERT_EQ(c.modes.size(), 2u);
  for (std::size_t k : {0u, 1u}) {
    const AssemblyModes e = assembly_modes(scene, "E", {{"C", k}});
    ASSERT_EQ(e.modes.size(), 2u);
    for (std::size_t l : {0u, 1u}) {
      const double dx = e.modes[l].values[0] - c.modes[k].values[0], dy = e.modes[l].values[1] - c.modes[k].values[1];
      EXPECT_NEAR(std::hypot(dx, dy), 2, 1e-14);
      const Prepared prepared = prepare_in_modes(scene, {{"E", l}, {"C.x", k}});
      Simulator simulator(prepared);
      EXPECT_NEAR(simulator.run().last("E.y"), e.modes[l].values[1], 1e-14);
    }
  }
}

TEST(Modes, ChosenModesHoldInEveryFormulation) {
  for (const std::string file : {"slider_crank", "three_rps", "excavator"}) {
    const Scene scene = read_scene(ASSUR_SOURCE_DIR "/scenes/" + file + ".json").with_outputs({"all"});
    const std::vector<AssemblyModes> all = assembly_modes(scene);
    const AssemblyModes& m = all.front();
    ASSERT_GE(m.modes.size(), 2u) << file;
    for (const std::string strategy : {"auto", "groups/lanes", "global/eigen", "irreducible/eigen"}) {
      for (std::size_t k = 0; k < std::min<std::size_t>(m.modes.size(), 4); ++k) {
        std::optional<Prepared> prepared;
        try {
          prepared = prepare_in_modes(scene, {{m.group, k}}, {.strategy = strategy});
        } catch (const Error& e) {  // a later group has no posture in this mode
          EXPECT_EQ(e.kind(), Error::Kind::numerical) << file << ' ' << e.what();
          EXPECT_GT(k, 0u) << file << ' ' << e.what();
          continue;
        }
        Simulator simulator(*prepared);
        const Trajectory motion = simulator.run(std::vector<double>{scene.time().start});
        ASSERT_EQ(motion.rows(), 1u);
        for (std::size_t j = 0; j < m.unknowns.size(); ++j) {
          EXPECT_NEAR(motion.last(m.unknowns[j]), m.modes[k].values[j], 1e-13) << file << ' ' << strategy << ' ' << k;
        }
      }
    }
  }
}

// E reaches C in the mode of the guess only.
TEST(Modes, LaterGroupsWithoutAPostureAreNamed) {
  const Scene scene = SceneBuilder("reach", 2)
                          .fixed_point("A", {0, 0})
                          .fixed_point("D", {2, 0})
                          .fixed_point("F", {1, 3})
                          .point("C", {1, 1})
                          .point("E", {2, 2})
                          .constrain("left", Distance{"A", "C", std::sqrt(2.0)})
                          .constrain("right", Distance{"D", "C", std::sqrt(2.0)})
                          .constrain("up", Distance{"C", "E", std::sqrt(2.0)})
                          .constrain("down", Distance{"F", "E", std::sqrt(2.0)})
                          .build();
  EXPECT_EQ(prepare_in_modes(scene, {{"C", 0}, {"E", 1}}).structure().cannot_assemble(), "");
  try {
    (void)prepare_in_modes(scene, {{"C", 1}});
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), Error::Kind::numerical);
    EXPECT_STREQ(e.what(), "group E cannot be assembled in the chosen modes; choose others");
  }
  const std::vector<AssemblyModes> all = assembly_modes(scene, {{"C", 1}});
  ASSERT_EQ(all.size(), 2u);
  EXPECT_TRUE(all[1].modes.empty());
  EXPECT_EQ(all[1].not_real, 2);
}

// A redundant rod holds in one mode only: the antiparallelogram breaks it.
TEST(Modes, RedundantEquationsExcludeModes) {
  const AssemblyModes m = assembly_modes(sample("parallelograms:1"), "B1");
  ASSERT_EQ(m.modes.size(), 1u);
  EXPECT_EQ(m.excluded, 1);
  EXPECT_TRUE(m.has_start);
}

TEST(Modes, RefusesGroupsThatItCannotCompute) {
  const auto message = [](auto&& call) {
    try {
      call();
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("no error");
  };
  const Scene scene = four_bar(0.4);
  EXPECT_EQ(message([&] { (void)assembly_modes(scene, "X"); }),
            "no group has the name 'X' or solves an unknown of that name; there are: C");
  EXPECT_EQ(message([&] {
              (void)prepare_in_modes(scene, {{"C", 2}});
            }),
            "group C has no mode 2: it has 2 modes, counted from 0");
  EXPECT_EQ(message([&] {
              (void)prepare_in_modes(scene, {{"C", 0}, {"C.y", 1}});
            }),
            "two choices name group C; leave one out");
  EXPECT_EQ(message([&] {
              (void)assembly_modes(scene, "C").nearest("B", {0, 0});
            }),
            "group C does not solve a point or vector 'B'");
  const AssemblyModes c = assembly_modes(scene, "C");
  const Triple middle{(c.modes[0].values[0] + c.modes[1].values[0]) / 2,
                      (c.modes[0].values[1] + c.modes[1].values[1]) / 2};
  EXPECT_EQ(message([&] { (void)c.nearest("C", middle); }),
            "modes 0 and 1 of group C are equally near to the place given for 'C'; choose one by its number");
  EXPECT_EQ(message([&] { (void)assembly_modes(sample("gough"), "B1"); }),
            "the modes of group B1+u+v+w cannot be computed: it has 12 unknowns; at most 6 can be computed");
  const Scene geared = read_scene(ASSUR_SOURCE_DIR "/scenes/geared_five_bar.json");
  EXPECT_EQ(
      message([&] { (void)assembly_modes(geared, "D"); }),
      "the modes of group D cannot be computed: it has the equation 'gears' of a function or a gear, which is not "
      "a polynomial");
  const AssemblyModes other = assembly_modes(geared, "C");
  EXPECT_EQ(other.modes.size(), 2u);
}

}  // namespace
}  // namespace assur
