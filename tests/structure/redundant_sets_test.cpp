// Redundancy as sets of joints or constraints, with the number of equations too many.
#include "structure/redundant_sets.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "assur/plan.hpp"
#include "assur/simulator.hpp"
#include "structure/look.hpp"

namespace assur {
namespace {

using Names = std::vector<std::string>;
constexpr double kPi = std::numbers::pi;

std::vector<RedundantSet> sets_of(const Scene& scene) {
  const Structure s = analyze(scene);
  EXPECT_EQ(s.cannot_assemble, "");
  EXPECT_TRUE(s.undetermined.empty());
  return redundant_sets(scene, s.redundant);
}

// Expects one set of these joints, and so many equations too many.
void expect_one(const Scene& scene, const Names& joints, std::size_t too_many) {
  const std::vector<RedundantSet> sets = sets_of(scene);
  ASSERT_EQ(sets.size(), 1u) << scene.name();
  EXPECT_EQ(sets[0].named.joints, joints);
  EXPECT_TRUE(sets[0].named.others.empty());
  EXPECT_EQ(sets[0].checked.size(), too_many);
  EXPECT_EQ(sets[0].kind, Redundancy::Kind::structural);
}

// The rule of Kutzbach counts 6 (bodies - joints) + the freedoms of the joints; the mechanisms have one freedom each.
TEST(RedundantSets, AreLoopsOfJoints) {
  expect_one(sample("bennett"), {"A", "B", "C", "D"}, 3);
  expect_one(sample("goldberg"), {"A", "B", "C", "D", "E"}, 2);
  expect_one(sample("sarrus"), {"foot_x", "knee_x", "head_x", "foot_y", "knee_y", "head_y"}, 1);
  expect_one(sample("bricard_joints"), {"A", "B", "C", "D", "E", "F"}, 1);
}

// n parallelograms in series, each with a third bar in its middle, which shares the bodies `link` with its neighbours.
// In the plane each has one equation too many. In space each of its two loops has three more.
Scene chain(int loops, int dimension, const Triple& axis = {0, 0, 1}) {
  SceneBuilder b("chain", dimension);
  const auto at = [&](double x, double y) -> Triple {
    if (dimension == 2 || axis[2] == 1) return {x, y, 0};
    const double n = std::sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]), c = axis[2] / n;
    const double s = std::sqrt(1 - c * c), u = axis[0] / (n * s), v = axis[1] / (n * s);  // turns z to the axis
    return {c * u * x - v * y, c * v * x + u * y, -s * x};
  };
  const auto joint = [&](const std::string& name, const std::string& one, const std::string& other,
                         const Triple& place) {
    Revolute r{one, other, place};
    if (dimension == 3) r.axis = axis;
    b.joint(name, r);
  };
  const auto n = [](const char* name, int i) { return name + std::to_string(i); };
  b.add(Body{.name = "bar0"});
  joint("A0", "ground", "bar0", at(0, 0));
  for (int i = 1; i <= loops; ++i) {
    const double x = 2.0 * i;
    b.add(Body{.name = n("bar", i)}).add(Body{.name = n("link", i)}).add(Body{.name = n("third", i)});
    joint(n("L", i), n("bar", i - 1), n("link", i), at(x - 2, 1));
    joint(n("R", i), n("link", i), n("bar", i), at(x, 1));
    joint(n("A", i), "ground", n("bar", i), at(x, 0));
    joint(n("M", i), n("link", i), n("third", i), at(x - 1, 1));
    joint(n("G", i), "ground", n("third", i), at(x - 1, 0));
  }
  b.drive("motor", DrivenCoordinate{"A0.angle", Law::polynomial({0, 0.5})});
  return b.time(0, 1, 0.01).build();
}

TEST(RedundantSets, OfChainsOfParallelogramsAreOneSet) {
  for (const int loops : {1, 2, 10, 60}) {
    SCOPED_TRACE(loops);
    const std::vector<RedundantSet> plane = sets_of(chain(loops, 2));
    ASSERT_EQ(plane.size(), 1u);
    EXPECT_EQ(plane[0].checked.size(), static_cast<std::size_t>(loops));
    const std::set<std::string> joints(plane[0].named.joints.begin(), plane[0].named.joints.end());
    for (const std::string k : {"L", "R", "A", "M", "G"}) EXPECT_EQ(joints.count(k + std::to_string(loops)), 1u) << k;
    const std::vector<RedundantSet> points = sets_of(sample("parallelograms:" + std::to_string(loops)));
    ASSERT_EQ(points.size(), 1u);
    EXPECT_EQ(points[0].checked.size(), static_cast<std::size_t>(loops));
    EXPECT_TRUE(points[0].named.joints.empty());
    EXPECT_EQ(points[0].named.others.size(), 2 * static_cast<std::size_t>(loops));  // rockers and third rods
  }
}

// Along z the axes are those of coordinates, and equations between known values; along another axis they are not.
TEST(RedundantSets, OfPlanarLoopsInSpaceCountThreeForEachLoop) {
  for (const Triple& axis : {Triple{0, 0, 1}, Triple{1, 2, 2}}) {
    for (const int loops : {1, 4}) {
      const std::vector<RedundantSet> sets = sets_of(chain(loops, 3, axis));
      ASSERT_EQ(sets.size(), 1u) << loops;
      // Two loops each: 3 equations for each loop, and the parallel third bar.
      EXPECT_EQ(sets[0].checked.size(), static_cast<std::size_t>(7 * loops)) << loops;
      EXPECT_EQ(sets[0].named.joints.size(), static_cast<std::size_t>(5 * loops + 1));
    }
  }
}

// Mechanisms beside each other have a set each, whose names are those of their own joints.
TEST(RedundantSets, AreSeparateForSeparateLoops) {
  SceneBuilder b("two", 3);
  for (const std::string n : {"1", "2"}) {
    const double x = n == "1" ? 0 : 10;
    for (const std::string body : {"input", "coupler", "output"}) b.add(Body{.name = body + n});
    b.joint("A" + n, Revolute{"ground", "input" + n, Triple{1 + x, 0, 0.3}, Triple{-1.2, 0.48, 2}});
    b.joint("B" + n, Revolute{"input" + n, "coupler" + n, Triple{0.4 + x, 1, -0.3}, Triple{0, 1.2, 2}});
    b.joint("C" + n, Revolute{"coupler" + n, "output" + n, Triple{-1 + x, 0, 0.3}, Triple{1.2, -0.48, 2}});
    b.joint("D" + n, Revolute{"output" + n, "ground", Triple{-0.4 + x, -1, -0.3}, Triple{0, -1.2, 2}});
    b.drive("motor" + n, DrivenCoordinate{"A" + n + ".angle", Law::polynomial({0, 1})});
  }
  std::vector<RedundantSet> sets = sets_of(b.time(0, 1, 0.01).build());
  ASSERT_EQ(sets.size(), 2u);
  std::sort(sets.begin(), sets.end(), [](const auto& p, const auto& q) { return p.named.joints < q.named.joints; });
  EXPECT_EQ(sets[0].named.joints, (Names{"A1", "B1", "C1", "D1"}));
  EXPECT_EQ(sets[1].named.joints, (Names{"A2", "B2", "C2", "D2"}));
  for (const RedundantSet& set : sets) EXPECT_EQ(set.checked.size(), 3u);
}

// All distances of n points: 2 n - 3 of them make a rigid body in the plane, 3 n - 6 in space.
TEST(RedundantSets, OfRigidBodiesNameTheDistances) {
  const Triple at[] = {{0, 0, 0}, {1, 0.2, 0.1}, {0.3, 1.1, -0.2}, {1.2, 0.9, 0.6}, {0.5, 0.4, 1.3}};
  for (const int dimension : {2, 3}) {
    const int points = dimension + 2, needed = dimension * points - dimension * (dimension + 1) / 2;
    SceneBuilder b("rigid", dimension);
    for (int i = 0; i < points; ++i) {
      const Triple p = dimension == 2 ? Triple{at[i][0], at[i][1], 0} : at[i];
      if (i < dimension) {
        b.fixed_point("P" + std::to_string(i), p);
      } else {
        b.point("P" + std::to_string(i), p);
      }
      for (int k = 0; k < i; ++k) {
        if (i < dimension) continue;
        b.constrain("d" + std::to_string(k) + std::to_string(i),
                    Distance{"P" + std::to_string(k), "P" + std::to_string(i)});
      }
    }
    const int given = points * (points - 1) / 2;
    const std::vector<RedundantSet> sets = sets_of(b.time(0, 1, 0.1).build());
    ASSERT_EQ(sets.size(), 1u) << dimension;
    EXPECT_EQ(sets[0].checked.size(), static_cast<std::size_t>(given - needed));
    EXPECT_EQ(sets[0].named.others.size(), static_cast<std::size_t>(given - dimension * (dimension - 1) / 2));
  }
}

// An error of a length is refused with the joints of its loop, before or during the motion; rounding is not.
TEST(RedundantSets, ErrorsOfALengthAreRefusedByTheJointsOfTheLoop) {
  const auto with_error = [](double error) {
    SceneBuilder b("bennett", 3);
    for (const char* body : {"input", "coupler", "output"}) b.add(Body{.name = body});
    b.joint("A", Revolute{"ground", "input", Triple{1, 0, 0.3}, Triple{-1.2, 0.48, 2}});
    b.joint("B", Revolute{"input", "coupler", Triple{0.4, 1, -0.3}, Triple{0, 1.2, 2}});
    b.joint("C", Revolute{"coupler", "output", Triple{-1 + error, 0, 0.3}, Triple{1.2, -0.48, 2}});
    b.joint("D", Revolute{"output", "ground", Triple{-0.4, -1, -0.3}, Triple{0, -1.2, 2}});
    b.drive("motor", DrivenCoordinate{"A.angle", Law::polynomial({0, 2 * kPi})});
    return b.time(0, 1, 0.005).build();
  };
  for (const double error : {1e-9, 1e-7, 1e-5, -1e-9}) {
    SCOPED_TRACE(error);
    Simulator simulator(prepare(with_error(error)));
    (void)simulator.run();
    EXPECT_EQ(simulator.report().status.code, Code::inconsistent);
    ASSERT_FALSE(simulator.report().events.empty());
    const Event& last = simulator.report().events.back();
    EXPECT_EQ(last.group, "joints A, B, C, D");
    EXPECT_EQ(last.unit, "m");
    EXPECT_GT(last.figure, 1e-11);
  }
  for (const double error : {0.0, 1e-13, -1e-13}) {
    SCOPED_TRACE(error);
    Simulator simulator(prepare(with_error(error)));
    (void)simulator.run();
    EXPECT_TRUE(simulator.report().status.ok()) << name(simulator.report().status.code);
    EXPECT_LE(simulator.report().error.position, error == 0 ? 1e-14 : 1e-13);
  }
  // In between either way, with the amount.
  Simulator simulator(prepare(with_error(1e-11)));
  (void)simulator.run();
  EXPECT_TRUE(simulator.report().status.ok() || simulator.report().status.code == Code::inconsistent);
  EXPECT_GE(simulator.report().error.position, 1e-12);
}

// Joints that contradict each other at the start: the circles of two cranks on one coupler, one of which has another
// length than its joints say, so that no posture has both.
TEST(RedundantSets, ContradictionsNameTheJoints) {
  SceneBuilder b("contradiction", 3);
  for (const char* body : {"crank", "coupler", "rocker"}) b.add(Body{.name = body});
  b.joint("A", Revolute{"ground", "crank", Triple{0, 0, 0}, Triple{0, 0, 1}});
  b.joint("B", Revolute{"crank", "coupler", Triple{0.8, 0, 0}, Triple{0, 0, 1}});
  b.joint("C", Revolute{"coupler", "rocker", Triple{1.6, 1.2, 0}, Triple{0, 0, 1}});
  b.joint("D", Revolute{"ground", "rocker", Triple{2, 0, 0}, Triple{0, 0.001, 1}});
  b.drive("motor", DrivenCoordinate{"A.angle", Law::polynomial({0.5, 1})});
  const Structure s = analyze(b.time(0, 1, 0.01).build());
  EXPECT_EQ(s.cannot_assemble.rfind("these joints contradict each other: 'A', 'B', 'C', 'D' (", 0), 0u)
      << s.cannot_assemble;
}

}  // namespace
}  // namespace assur
