// Redundancy as sets of joints or constraints, with the number of equations too many.
#include "start/redundant_sets.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "assur/plan.hpp"
#include "assur/simulator.hpp"
#include "backends/allocations.hpp"
#include "decimal.hpp"
#include "structure/look.hpp"

namespace assur {
namespace {

using Names = std::vector<std::string>;
constexpr double kPi = std::numbers::pi;

std::vector<RedundantSet> sets_of(const Scene& scene) {
  const GroupedSystem s = group_equations(scene);
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

// Redundancy is local, so that the work grows with the number of loops.
TEST(RedundantSets, WorkGrowsInProportionToTheLengthOfAChain) {
  const auto count = [](int loops) {
    const Scene scene = chain(loops, 2);
    const std::int64_t before = test::allocations();
    const GroupedSystem s = group_equations(scene);
    const std::vector<RedundantSet> sets = redundant_sets(scene, s.redundant);
    const std::int64_t work = test::allocations() - before;
    EXPECT_EQ(s.cannot_assemble, "");
    EXPECT_EQ(sets.size(), 1u);
    EXPECT_EQ(sets.front().checked.size(), static_cast<std::size_t>(loops));
    EXPECT_EQ(sets.front().named.joints.size(), 5u * static_cast<std::size_t>(loops) + 1);
    for (const Redundancy& r : s.redundant) EXPECT_LE(r.constraints.size(), 4u) << r.dropped;
    for (const SolvedGroup& g : s.groups) EXPECT_LE(g.of, 2) << g.name;
    return work;
  };
  const std::int64_t few = count(500), many = count(2000);
  EXPECT_LE(many, 4.2 * static_cast<double>(few)) << few << " and " << many;
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

// The scene with a joint elsewhere, or with another axis.
Scene with_error(const Scene& scene, const std::string& joint, const Triple& at, const Triple& axis = {}) {
  SceneBuilder b(scene.name(), scene.dimension());
  for (const Body& body : scene.bodies()) b.add(Body{.name = body.name});
  for (const Joint& j : scene.joints()) {
    Revolute r = std::get<Revolute>(j.kind);
    if (j.name == joint) {
      for (std::size_t k = 0; k < 3; ++k) {
        std::get<Triple>(r.at)[k] += at[k];
        if (scene.dimension() == 3) std::get<Triple>(r.axis)[k] += axis[k];
      }
    }
    b.joint(j.name, r);
  }
  for (const Driver& d : scene.drivers()) b.add(d);
  return b.time(scene.time().start, scene.time().end, scene.time().step).build();
}

struct Erroneous {
  std::string name;
  std::function<Scene(double)> scene;  // with an error of a length or of a direction
  Names joints;                        // among those named
  std::string unit;
};

// An error of a length is refused before the motion, with the joints of its loops and the amount; rounding is not.
TEST(RedundantSets, ErrorsOfALengthAreRefusedByTheJointsOfTheLoop) {
  const std::vector<Erroneous> all = {
      {"Bennett",
       [](double e) {
         return with_error(sample("bennett"), "C", {e, 0, 0});
       },
       {"A", "B", "C", "D"},
       " m"},
      {"Goldberg",
       [](double e) {
         return with_error(sample("goldberg"), "C", {0, 0, e});
       },
       {"A", "B", "C", "D", "E"},
       " m"},
      {"Bricard",
       [](double e) {
         return with_error(sample("bricard_joints"), "C", {0, e, 0});
       },
       {"A", "B", "C", "D", "E", "F"},
       " m"},
      {"Sarrus",
       [](double e) {
         return with_error(sample("sarrus"), "knee_x", {}, {0, 0, e});
       },
       {"foot_x", "knee_x", "head_x", "foot_y", "knee_y", "head_y"},
       ""},
      {"loop in space",
       [](double e) {
         return with_error(chain(1, 3, {1, 2, 2}), "L1", {}, {0, e, 0});
       },
       {"A0", "L1", "R1", "A1", "M1", "G1"},
       ""},
      {"third bar, across",
       [](double e) {
         return with_error(chain(1, 2), "M1", {e, 0, 0});
       },
       {"A0", "L1", "R1", "A1", "M1", "G1"},
       " m"},
      {"third bar, along",
       [](double e) {
         return with_error(chain(1, 2), "M1", {0, e, 0});
       },
       {"A0", "L1", "R1", "A1", "M1", "G1"},
       " m"},
      {"tenth parallelogram",
       [](double e) {
         return with_error(chain(10, 2), {"M10"}, {e, e, 0});
       },
       {"M10"},
       " m"},
  };
  for (const Erroneous& of : all) {
    SCOPED_TRACE(of.name);
    for (const double error : {1e-9, -1e-9, 1e-7, 1e-5}) {
      SCOPED_TRACE(error);
      const Scene scene = of.scene(error);
      const GroupedSystem s = group_equations(scene);
      EXPECT_EQ(s.cannot_assemble.rfind("the mechanism cannot move: ", 0), 0u) << error << s.cannot_assemble;
      EXPECT_NE(s.cannot_assemble.find(" hold"), std::string::npos) << s.cannot_assemble;
      const std::vector<RedundantSet> sets = redundant_sets(scene, s.redundant);
      const auto is_it = [&](const RedundantSet& set) {
        return s.cannot_assemble.find(set.named.text()) != std::string::npos &&
               s.cannot_assemble.find(general(set.worst.violation, 3) + of.unit) != std::string::npos;
      };
      const auto set = std::find_if(sets.begin(), sets.end(), is_it);
      ASSERT_NE(set, sets.end()) << s.cannot_assemble;
      EXPECT_LT(set->worst.violation, 2 * std::abs(error));
      for (const std::string& j : of.joints) {
        EXPECT_EQ(std::count(set->named.joints.begin(), set->named.joints.end(), j), 1) << j;
      }
      EXPECT_EQ(look::error(Error::Kind::numerical, [&] { (void)prepare(scene); }), s.cannot_assemble);
    }
    for (const double error : {1e-4, 1e-2}) EXPECT_NE(group_equations(of.scene(error)).cannot_assemble, "") << error;
    for (const double error : {0.0, 1e-13, -1e-13}) {
      const GroupedSystem s = group_equations(of.scene(error));
      EXPECT_EQ(s.cannot_assemble, "") << error;
      for (const Redundancy& r : s.redundant)
        EXPECT_EQ(r.kind, Redundancy::Kind::structural) << error << " " << r.violation << " t " << r.time;
    }
  }
  for (const double error : {0.0, 1e-13, -1e-13}) {
    Simulator simulator(prepare(all[0].scene(error)));
    (void)simulator.run();
    EXPECT_TRUE(simulator.report().status.ok()) << name(simulator.report().status.code);
    EXPECT_LE(simulator.report().error.position, error == 0 ? 1e-14 : 1e-13);
  }
  // An error between these bounds is accepted, and the residual shows it.
  Simulator simulator(prepare(all[0].scene(1e-11)));
  (void)simulator.run();
  EXPECT_TRUE(simulator.report().status.ok()) << name(simulator.report().status.code);
  EXPECT_GE(simulator.report().error.position, 1e-12);
}

// What an error that is not refused does to the motion is at most three times what the run estimates.
TEST(RedundantSets, SmallErrorsCountInTheEstimates) {
  const std::vector<std::pair<std::string, Triple>> all = {
      {"bennett", {1, 0, 0}}, {"goldberg", {0, 0, 1}}, {"bricard_joints", {0, 1, 0}}};
  for (const auto& [name, along] : all) {
    SCOPED_TRACE(name);
    const Scene exact = sample(name);
    for (const double error : {3e-12, -1e-11}) {
      SCOPED_TRACE(error);
      Simulator of_exact(prepare(with_error(exact, "C", {}))),
          simulator(prepare(with_error(exact, "C", {error * along[0], error * along[1], error * along[2]})));
      const Trajectory right = of_exact.run(), motion = simulator.run();
      ASSERT_EQ(simulator.report().status.code, Code::ok);
      ASSERT_EQ(motion.columns(), right.columns());
      double largest[3] = {}, difference[3] = {};
      for (std::size_t c = 0; c < motion.columns().size(); ++c) {
        const std::string& column = motion.columns()[c];
        const std::string kind = column.substr(column.rfind('.') + 1);
        const std::size_t d = kind == "acceleration" || kind[0] == 'a' ? 2 : kind == "rate" || kind[0] == 'v' ? 1 : 0;
        for (std::size_t k = 0; k < motion.rows(); ++k) {
          largest[d] = std::max(largest[d], std::abs(right(k, c)));
          difference[d] = std::max(difference[d], std::abs(motion(k, c) - right(k, c)));
        }
      }
      const ErrorFigures& estimated = simulator.report().error;
      EXPECT_GE(difference[0], 1e-3 * *estimated.estimated_position * largest[0]);
      EXPECT_LE(difference[0], 3 * *estimated.estimated_position * largest[0]);
      EXPECT_LE(difference[1], 3 * *estimated.estimated_velocity * largest[1]);
      EXPECT_LE(difference[2], 3 * *estimated.estimated_acceleration * largest[2]);
    }
  }
}

// Two drivers on a mechanism with one freedom.
TEST(RedundantSets, DriversThatContradictALoopAreRefused) {
  const auto driven = [](double second) {
    Scene scene = chain(1, 2);
    SceneBuilder b("two drivers", 2);
    for (const std::string name : {"bar0", "link1", "bar1"}) b.add(Body{.name = name});
    for (const Joint& j : scene.joints()) {
      if (j.name != "M1" && j.name != "G1") b.add(j);
    }
    b.drive("motor", DrivenCoordinate{"A0.angle", Law::polynomial({0, 0.5})});
    b.drive("other", DrivenCoordinate{"A1.angle", Law::polynomial({0, second})});
    return b.time(0, 1, 0.01).build();
  };
  const GroupedSystem s = group_equations(driven(0.6));
  EXPECT_EQ(s.cannot_assemble.rfind("the mechanism cannot move: ", 0), 0u) << s.cannot_assemble;
  EXPECT_NE(s.cannot_assemble.find("driver other"), std::string::npos) << s.cannot_assemble;
  EXPECT_NE(s.cannot_assemble.find("at t = 0.01 s"), std::string::npos) << s.cannot_assemble;
  EXPECT_EQ(look::error(Error::Kind::numerical, [&] { (void)prepare(driven(0.6)); }), s.cannot_assemble);
  EXPECT_EQ(group_equations(driven(0.5)).cannot_assemble, "");
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
  const GroupedSystem s = group_equations(b.time(0, 1, 0.01).build());
  EXPECT_EQ(s.cannot_assemble.rfind("these joints contradict each other: 'A', 'B', 'C', 'D' (", 0), 0u)
      << s.cannot_assemble;
}

}  // namespace
}  // namespace assur
