// Redundant equations and undetermined unknowns, by name.
#include "start/rank.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "assur/plan.hpp"
#include "assur/simulator.hpp"
#include "references/delta.hpp"
#include "structure/look.hpp"

namespace assur {
namespace {

using enum Formulation;
using look::structure;
using Names = std::vector<std::string>;

// Three parallel rods on a coupler, two of length 1 and one of length `third`. A dyad P is connected to the coupler.
SceneBuilder parallelogram(double third, double start = 1.0) {
  const Triple crank = {std::cos(start), std::sin(start), 0};
  SceneBuilder b("parallelogram", 2);
  b.fixed_point("A0", {0, 0, 0})
      .fixed_point("A1", {2, 0, 0})
      .fixed_point("A2", {0.5, 0, 0})
      .fixed_point("D", {4, 0, 0});
  b.point("B0", crank).point("B1", {crank[0] + 2, crank[1], 0});
  b.add(Body{"coupler", "", {}, {"B0", "B1"}, {{"M", {0.5, 0, 0}}}, {}});
  b.constrain("coupler_length", Distance{"B0", "B1", 2.0});
  b.constrain("rocker", Distance{"A1", "B1", 1.0});
  b.constrain("third", Distance{"A2", "M", third});
  b.point("P", {crank[0] + 3, crank[1] + 1, 0});
  b.constrain("PB", Distance{"P", "B1", 2.0}).constrain("PD", Distance{"P", "D", 2.0});
  b.drive("motor", PointAngle{"A0", "B0", "", Law::polynomial({start, 1})});
  return b.time(0, 1, 0.01);
}

TEST(Rank, AThirdParallelRodIsRedundant) {
  for (const Formulation f : {global, groups, irreducible}) {
    const GroupedSystem s = structure(parallelogram(1).build(), f);
    EXPECT_EQ(s.cannot_assemble, "");
    EXPECT_TRUE(s.undetermined.empty());
    ASSERT_EQ(s.redundant.size(), 1u);
    // The coupler determines B1 along the coupler, both rods along the rods. Only the two rods depend on each other.
    EXPECT_EQ(s.redundant[0].constraints, (Names{"rocker", "third"}));
    EXPECT_TRUE(s.redundant[0].dropped == "rocker" || s.redundant[0].dropped == "third");
    ASSERT_EQ(s.checks.size(), 1u);
    EXPECT_EQ(s.system->equation_name(s.checks[0]), s.redundant[0].dropped);
    EXPECT_EQ(s.watch.equations, s.checks);
    EXPECT_EQ(s.mobility, 1);
    EXPECT_LE(look::start_residual(s), 1e-15);
    EXPECT_EQ(look::solved(s), 4);
  }
}

TEST(Rank, TheRedundantMechanismRuns) {
  for (const char* strategy : {"groups/eigen", "irreducible/eigen", "global/eigen"}) {
    Simulator simulator(prepare(parallelogram(1).build(), {strategy, {}}));
    const Trajectory run = simulator.run();
    EXPECT_TRUE(simulator.report().status.ok());
    ASSERT_EQ(run.rows(), 101u);
    const std::size_t x = run.index("B1.x"), y = run.index("B1.y");
    for (std::size_t k = 0; k < run.rows(); ++k) {
      // Residuals of 1e-14, relative to terms of about 20; the inverse of (coupler, rocker) is about 1/2.
      EXPECT_NEAR(run(k, x), 2 + std::cos(1 + run.times()[k]), 1e-13);
      EXPECT_NEAR(run(k, y), std::sin(1 + run.times()[k]), 1e-13);
    }
    EXPECT_LE(simulator.report().error.position, 1e-14);  // includes the checked equation
  }
}

// The redundant equation is checked during the run: the length of the third rod has to fit.
TEST(Rank, AViolatedRedundantEquationStopsTheRun) {
  // The equations are redundant at the start and to first order, but the third rod is connected to a point that leaves
  // the circle. At the end they contradict each other by 5e-7 and 5e-3.
  for (const auto& [accuracy, leaves] : {std::pair(0.0, 1e-3), std::pair(1e-4, 0.1)}) {
    SceneBuilder b("leaving", 2);
    b.fixed_point("A", {0, 0, 0}).fixed_point("C", {1, 0, 0}).point("S", {0.5, 0, 0});
    b.point("B", {1, 1, 0}).constrain("height", FixedCoordinate{"B.y", 1});
    b.constrain("rod", Distance{"S", "B", std::hypot(0.5, 1)});
    b.constrain("stop", Distance{"C", "B", 1.0});
    b.drive("slide", DrivenCoordinate{"S.x", Law::polynomial({0.5, 0, 0, 0, 0, 0, leaves})});
    b.drive("lift", DrivenCoordinate{"S.y", Law::constant(0)});
    const Scene scene = b.time(0, 1, 0.1).build();
    EXPECT_EQ(structure(scene, groups).cannot_assemble, "");
    Simulator simulator(prepare(scene, {.strategy = "groups/eigen", .accuracy = accuracy}));
    (void)simulator.run();
    EXPECT_EQ(simulator.report().status.code, Code::inconsistent) << name(simulator.report().status.code);
    EXPECT_LT(simulator.report().reached, 1);
  }
}

TEST(Rank, NamesATooLongRod) {
  const Scene scene = parallelogram(1 + 1e-3).build();
  const GroupedSystem s = structure(scene, groups);
  EXPECT_EQ(s.cannot_assemble.rfind("these equations contradict each other: ", 0), 0u) << s.cannot_assemble;
  for (const char* name : {"'rocker'", "'third'"}) EXPECT_NE(s.cannot_assemble.find(name), std::string::npos);
  for (const char* name : {"'PB'", "'PD'"}) EXPECT_EQ(s.cannot_assemble.find(name), std::string::npos);
  EXPECT_EQ(look::error(Error::Kind::numerical, [&] { (void)prepare(scene); }), s.cannot_assemble);
}

// Measured lengths agree only up to rounding, which is not a contradiction.
TEST(Rank, RoundingIsNoContradiction) {
  const GroupedSystem s = structure(parallelogram(1 + 4e-16).build(), groups);
  EXPECT_EQ(s.cannot_assemble, "");
  EXPECT_EQ(s.redundant.size(), 1u);
}

TEST(Rank, HandlesAFixedPointWithThreeRods) {
  SceneBuilder b("tripod", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("B", {2, 0, 0}).fixed_point("C", {1, 3, 0}).point("P", {0.9, 1.1, 0});
  b.constrain("PA", Distance{"P", "A", std::sqrt(2.0)}).constrain("PB", Distance{"P", "B", std::sqrt(2.0)});
  b.constrain("PC", Distance{"P", "C", 2.0});
  b.time(0, 1, 0.1);
  const GroupedSystem s = structure(b.build(), groups);
  EXPECT_EQ(s.cannot_assemble, "");
  ASSERT_EQ(s.redundant.size(), 1u);
  EXPECT_EQ(s.redundant[0].constraints, (Names{"PA", "PB", "PC"}));
  EXPECT_EQ(s.mobility, 0);
  EXPECT_NEAR(look::start(s, "P.x"), 1, 1e-14);
  EXPECT_NEAR(look::start(s, "P.y"), 1, 1e-14);
}

TEST(Rank, SimilarHexagonsAreUndeterminedByTheirLegs) {
  const GroupedSystem s = structure(sample("hexapod:drive=legs"), groups);
  EXPECT_FALSE(s.undetermined.empty());
  const std::set<std::string> names(s.undetermined.begin(), s.undetermined.end());
  EXPECT_TRUE(names.contains("u.x")) << "the self-motion turns the platform";
  for (const std::string& n : names) EXPECT_TRUE(std::string("Ouvw").find(n[0]) != std::string::npos) << n;
  EXPECT_EQ(s.mobility, 6);
  EXPECT_NE(look::error(Error::Kind::input, [] { (void)prepare(sample("hexapod:drive=legs")); })
                .find("undetermined: no equation determines "),
            std::string::npos);
}

TEST(Rank, AMissingDriverLeavesUnknownsFree) {
  SceneBuilder b("four_bar", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("D", {2, 0, 0}).point("B", {0.8, 0, 0}).point("C", {1.5, 1.2, 0});
  b.constrain("crank", Distance{"A", "B", 0.8}).constrain("coupler", Distance{"B", "C", 1.8});
  b.constrain("rocker", Distance{"D", "C", 1.3});
  b.point("P", {1, 3, 0}).constrain("PA", Distance{"P", "A", 2.5}).constrain("PD", Distance{"P", "D", 2.5});
  b.time(0, 1, 0.1);
  const GroupedSystem s = structure(b.build(), groups);
  EXPECT_EQ(std::set<std::string>(s.undetermined.begin(), s.undetermined.end()),
            (std::set<std::string>{"B.x", "B.y", "C.x", "C.y"}));
  EXPECT_EQ(s.mobility, 1);
  EXPECT_NE(look::error(Error::Kind::input, [&] { (void)prepare(b.build()); })
                .find("undetermined: no equation determines B."),
            std::string::npos);
}

// The point `free` is undetermined. The points with a redundant equation are not.
TEST(Rank, OnlyAFreePointIsUndetermined) {
  const GroupedSystem s = structure(parallelogram(1).point("free", {1, 1, 0}).build(), groups);
  EXPECT_EQ(s.undetermined, (Names{"free.x", "free.y"}));
  EXPECT_EQ(s.redundant.size(), 1u);
  EXPECT_EQ(s.mobility, 3);
}

// ---- singular starts

TEST(Rank, ReportsAStartAtAChangePoint) {
  SceneBuilder b("parallelogram", 2);
  b.fixed_point("A0", {0, 0, 0}).fixed_point("A1", {2, 0, 0}).point("B0", {1, 0, 0}).point("B1", {3, 0, 0});
  b.constrain("coupler", Distance{"B0", "B1", 2.0}).constrain("rocker", Distance{"A1", "B1", 1.0});
  b.drive("motor", PointAngle{"A0", "B0", "", Law::polynomial({0, 1})}).time(0, 1, 0.01);
  const GroupedSystem s = structure(b.build(), groups);
  EXPECT_TRUE(s.redundant.empty());
  EXPECT_TRUE(s.undetermined.empty());
  EXPECT_EQ(s.cannot_assemble, "");
  EXPECT_EQ(s.mobility, 1);
  EXPECT_NE(look::notes(s).find("the start posture is singular"), std::string::npos) << look::notes(s);
}

TEST(Rank, ReportsAStartAtADeadPoint) {
  SceneBuilder b("slider_crank", 2);
  b.fixed_point("O", {0, 0, 0}).point("B", {0.1, 0, 0}).point("C", {0.4, 0, 0});
  b.constrain("crank", Distance{"O", "B", 0.1}).constrain("rod", Distance{"B", "C", 0.3});
  b.constrain("rail", FixedCoordinate{"C.y", 0});
  b.drive("piston", DrivenCoordinate{"C.x", Law::polynomial({0.4, 0, -0.05})}).time(0, 1, 0.01);
  const GroupedSystem s = structure(b.build(), groups);
  EXPECT_TRUE(s.redundant.empty());
  EXPECT_TRUE(s.undetermined.empty());
  EXPECT_EQ(s.cannot_assemble, "");
  EXPECT_NE(look::notes(s).find("the start posture is singular"), std::string::npos) << look::notes(s);
}

// ---- mobility

TEST(Mobility, OfADeltaRobotIsThreeForAllDrivers) {
  const references::Delta delta;
  SceneBuilder motors = delta.scene({0.2, 0.2, 0.2}, 0.2), pose = delta.scene({0.2, 0.2, 0.2}, 0.2),
               free = delta.scene({0.2, 0.2, 0.2}, 0.2);
  for (int i = 0; i < 3; ++i) {
    const std::string n = std::to_string(i);
    motors.drive("motor" + n, RelativeAngle{"r" + n, {"S" + n, "E" + n}, "t" + n, Law::polynomial({0.2, 0.3})});
  }
  const Law zero = Law::constant(0);
  pose.drive("p", Pose{"plate", {zero, zero, Law::polynomial({delta.height(0.2), -0.05})}, {zero, zero, zero}});
  EXPECT_EQ(structure(motors.time(0, 1, 0.1).build(), groups).mobility, 3);
  EXPECT_EQ(structure(free.time(0, 1, 0.1).build(), groups).mobility, 3);
  const GroupedSystem s = structure(pose.time(0, 1, 0.1).build(), groups);
  EXPECT_EQ(s.cannot_assemble, "");
  EXPECT_EQ(s.mobility, 3);
  EXPECT_EQ(s.mobility_at_start, 3);
  // Only the laws keep the platform from turning; a turned platform does not fit its rods.
  ASSERT_EQ(s.redundant.size(), 3u);
  for (const Redundancy& r : s.redundant) EXPECT_EQ(r.kind, Redundancy::Kind::motion) << r.dropped;
}

// A rigid triangle, and a driver that cannot move it.
TEST(Mobility, OfAPointWithDistanceAndCoordinateIsZero) {
  SceneBuilder b("fixed", 2);
  b.fixed_point("A", {0, 0, 0}).point("B", {0.6, 0.8, 0});
  b.constrain("link", Distance{"A", "B", 1.0}).constrain("wall", FixedCoordinate{"B.x", std::cos(0.9)});
  b.drive("m", PointAngle{"A", "B", "", Law::constant(0.9)});
  const GroupedSystem s = structure(b.time(0, 1, 0.1).build(), groups);
  EXPECT_EQ(s.mobility, 0);
  EXPECT_EQ(s.mobility_at_start, 0);
}

// Two rods keep a point on a circle in space; a third rod connects the point to a slider.
TEST(Mobility, OfAWishboneWithARodIsOne) {
  for (const bool driven_by_slider : {true, false}) {
    SceneBuilder b("wishbone", 3);
    b.fixed_point("A1", {0, -1, 0}).fixed_point("A2", {0, 1, 0}).fixed_point("T", {1, 0, 2});
    b.fixed_vector("up", {0, 0, 1}).point("B", {1, 0, 0.1}).point("C", {1, 0, 1});
    b.constrain("front", Distance{"A1", "B"}).constrain("back", Distance{"A2", "B"});
    b.constrain("rod", Distance{"B", "C"}).constrain("rail", OnLine{"C", "T", "up"});
    if (driven_by_slider) {
      b.drive("m", DrivenCoordinate{"rail.lambda", Law::polynomial({-1, 0.1})});
    } else {  // drives the height of B; the equal distances are one equation too many
      b.drive("m", DrivenCoordinate{"B.z", Law::polynomial({0.1, 0.1})});
      b.constrain("twice", EqualDistance{"A1", "B", "A2", "B"});
    }
    const GroupedSystem s = structure(b.time(0, 1, 0.1).build(), groups);
    EXPECT_EQ(s.cannot_assemble, "");
    EXPECT_EQ(s.mobility, 1) << driven_by_slider;
    EXPECT_EQ(s.mobility_at_start, 1) << driven_by_slider;
  }
}

// The flat posture has two directions of motion, all others one.
TEST(Mobility, OfAFlatParallelogramIsTwoAndElsewhereOne) {
  for (const bool driven : {true, false}) {
    SceneBuilder b("parallelogram", 2);
    b.fixed_point("A0", {0, 0, 0}).fixed_point("A1", {2, 0, 0}).point("B0", {1, 0, 0}).point("B1", {3, 0, 0});
    b.constrain("coupler", Distance{"B0", "B1", 2.0}).constrain("rocker", Distance{"A1", "B1", 1.0});
    if (driven) {
      b.drive("motor", PointAngle{"A0", "B0", "", Law::polynomial({0, 1})});
    } else {
      b.constrain("crank", Distance{"A0", "B0", 1.0});
    }
    const GroupedSystem s = structure(b.time(0, 1, 0.01).build(), groups);
    EXPECT_EQ(s.mobility, 1) << driven;
    EXPECT_EQ(s.mobility_at_start, 2) << driven;
  }
}

// ---- kinds of redundancy

TEST(Redundancies, AreDistinguished) {
  // The third rod of a parallelogram is always redundant; a rod that only fits at the start is not.
  const GroupedSystem always = structure(parallelogram(1).build(), groups);
  ASSERT_EQ(always.redundant.size(), 1u);
  EXPECT_EQ(always.redundant[0].kind, Redundancy::Kind::structural);
  EXPECT_EQ(look::notes(always), "");

  SceneBuilder b("leaving", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("D", {2, 0, 0}).fixed_point("F", {0, 3, 0});
  b.point("B", {0.8 * std::cos(1), 0.8 * std::sin(1), 0}).point("C", {1.6, 1.2, 0});
  b.constrain("coupler", Distance{"B", "C"}).constrain("rocker", Distance{"D", "C"});
  b.constrain("stay", Distance{"F", "C"});  // keeps the length that it has at the start
  SceneBuilder at_once = b;
  at_once.drive("motor", PointAngle{"A", "B", "", Law::polynomial({1, 1})});
  const GroupedSystem refused = structure(at_once.time(0, 1, 0.1).build(), groups);
  EXPECT_EQ(refused.cannot_assemble.rfind("the mechanism cannot move: '", 0), 0u) << refused.cannot_assemble;
  EXPECT_NE(refused.cannot_assemble.find("at t = 0.1 s it is violated by "), std::string::npos);

  std::vector<double> slowly(13, 0.0);  // 1 + t^12
  slowly.front() = slowly.back() = 1;
  b.drive("motor", PointAngle{"A", "B", "", Law::polynomial(slowly)});
  const Scene scene = b.time(0, 1, 0.1).build();
  const GroupedSystem once = structure(scene, groups);
  ASSERT_EQ(once.redundant.size(), 1u);
  EXPECT_EQ(once.redundant[0].kind, Redundancy::Kind::start);
  EXPECT_GT(once.redundant[0].violation, 1e-12);
  EXPECT_TRUE(once.redundant[0].is_length);
  EXPECT_EQ(once.mobility, 0);
  const std::string& dropped = once.redundant[0].dropped;
  EXPECT_NE(look::notes(once).find("'" + dropped + "' holds at the start posture, but not later"), std::string::npos);

  Simulator simulator(prepare(scene, {.strategy = "groups/eigen"}));
  (void)simulator.run();
  EXPECT_EQ(simulator.report().status.code, Code::inconsistent);
  ASSERT_FALSE(simulator.report().events.empty());
  const Event& event = simulator.report().events.back();
  EXPECT_EQ(event.kind, Code::inconsistent);
  EXPECT_EQ(event.group, dropped);
  EXPECT_EQ(event.unit, "m");
  EXPECT_GT(event.figure, 1e-11);  // in metres; the run notices it after a short step
  EXPECT_LE(event.time, 0.5);
}

// Three parallel cranks pass their singular line. There two of the solved rods determine the posture only to the square
// root of rounding, and the third rod shows this error (2e-8 m).
TEST(Redundancies, AreNotJudgedBySingularPostures) {
  SceneBuilder b("three cranks", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("D", {2, 0, 0}).fixed_point("E", {1, 0.5, 0});
  b.point("B", {0, 1, 0}).point("C", {2, 1, 0}).point("F", {1, 1.5, 0});
  b.constrain("r", Distance{"A", "B", 1.0}).constrain("c", Distance{"B", "C", 2.0});
  b.constrain("k", Distance{"D", "C", 1.0}).constrain("k3", Distance{"E", "F", 1.0});
  b.constrain("b1", Distance{"B", "F"}).constrain("b2", Distance{"C", "F"});
  b.drive("m", PointAngle{"A", "B", "", Law::polynomial({std::numbers::pi / 2, 2 * std::numbers::pi})});
  for (const double step : {1.0 / 3, 1.0 / 4, 1.0 / 16, 0.01}) {
    const GroupedSystem s = structure(SceneBuilder(b).time(0, 1, step).build(), groups);
    ASSERT_EQ(s.redundant.size(), 1u) << step;
    EXPECT_EQ(s.redundant[0].kind, Redundancy::Kind::structural) << step;
    EXPECT_EQ(look::notes(s), "") << step;
  }
}

// ---- Bricard: mobility 1 with one equation more than unknowns

Scene bricard() { return sample("bricard:middle=0,swing=0.5,step=0.02,steps=100"); }

TEST(Rank, BricardHasOneRedundantEquation) {
  for (const Formulation f : {global, groups, irreducible}) {
    const GroupedSystem s = structure(bricard(), f);
    EXPECT_EQ(s.cannot_assemble, "");
    EXPECT_TRUE(s.undetermined.empty());
    EXPECT_EQ(s.equations, s.unknowns + 1);
    EXPECT_EQ(s.mobility, 1);
    ASSERT_EQ(s.redundant.size(), 1u);
    EXPECT_GT(s.redundant[0].constraints.size(), 1u);
    EXPECT_LE(look::start_residual(s), 1e-15);
  }
}

// At its dead centre the crank may turn either way, but the scene lacks no constraint.
TEST(Rank, DistinguishesADeadCentreFromAMissingConstraint) {
  const auto crank = [](double x, bool with_rod) {
    SceneBuilder b("slider_crank", 2);
    b.fixed_point("A", {0, 0}).point("B", {1, 0}).point("C", {3, 0});
    b.constrain("crank", Distance{"A", "B", 1.0}).constrain("rail", FixedCoordinate{"C.y", 0});
    if (with_rod) b.constrain("rod", Distance{"B", "C", 2.0});
    return b.drive("piston", DrivenCoordinate{"C.x", Law::constant(x)}).time(0, 1, 0.1).build();
  };
  EXPECT_EQ(
      look::error(Error::Kind::numerical, [&] { (void)prepare(crank(3, true)); }),
      "the start posture is singular (a dead centre): the Jacobian does not determine B.y, though it does at nearby "
      "postures; start with other values of the drivers");
  EXPECT_EQ(look::error(Error::Kind::input, [&] { (void)prepare(crank(3, false)); }).substr(0, 40),
            "undetermined: no equation determines B.y");
}

TEST(Rank, BricardRuns) {
  Simulator simulator(prepare(bricard(), {"groups/eigen", {}}));
  const Trajectory run = simulator.run();
  EXPECT_TRUE(simulator.report().status.ok()) << name(simulator.report().status.code);
  ASSERT_EQ(run.rows(), 101u);
  EXPECT_LE(simulator.report().error.position, 1e-14);
  // Opposite hinges of the cube turn equally, so that lengths are symmetric: |P0 P3| = |P1 P4| = |P2 P5|.
  const auto distance = [&](std::size_t row, const std::string& a, const std::string& b) {
    const auto at = [&](const std::string& p, std::size_t k) {
      static const std::map<std::string, Triple> fixed = {{"P5", {0, 0, 1}}, {"P0", {0, 0, 0}}};
      if (const auto f = fixed.find(p); f != fixed.end()) return f->second[k].value();
      return run(row, run.index(p + "." + "xyz"[k]));
    };
    return std::hypot(at(a, 0) - at(b, 0), at(a, 1) - at(b, 1), at(a, 2) - at(b, 2));
  };
  for (std::size_t k = 0; k < run.rows(); k += 10) {
    EXPECT_NEAR(distance(k, "P0", "P3"), distance(k, "P1", "P4"), 1e-12);
    EXPECT_NEAR(distance(k, "P0", "P3"), distance(k, "P2", "P5"), 1e-12);
  }
}

}  // namespace
}  // namespace assur
