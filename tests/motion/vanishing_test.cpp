// Equations whose terms all vanish, because directions are perpendicular and parallel to the axes. Their residuals are
// rounding errors relative to the factors, not to the vanishing terms.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "equations/lowering.hpp"
#include "equations/residual_scale.hpp"
#include "simulation/run.hpp"

namespace assur {
namespace {

using test::Result;

constexpr double kNearlyZero = 6.123233995736766e-17;  // cos(pi / 2) in double

// A crank about the third axis, with a redundant equation that keeps it in its plane.
Scene crank(const std::string& constraint) {
  return parse_scene(R"({"assur": 1, "name": "mini", "dimension": 3,
    "points": {"A": {"at": [0, 0, 0], "fixed": true}, "B": {"at": [1, 0, 0]}},
    "vectors": {"n": {"at": [0, 0, 1], "fixed": true}}, "constraints": {"flat": )" +
                     constraint + R"(},
    "drivers": {"m": {"angle": ["A", "B"], "axis": "n", "law": {"polynomial": [0, 1]}}},
    "time": {"start": 0, "end": 6.5, "step": 0.1}})");
}

TEST(Vanishing, EquationsOfKnownCoordinatesAreConsistent) {
  for (const std::string constraint : {
           R"j({"dot": ["n", ["A", "B"]], "value": "=cos(pi/2)"})j",
           R"j({"dot": ["n", ["A", "B"]], "value": 0})j",
           R"j({"coordinate": "B.z", "value": 6e-17})j",
       }) {
    const Result r = test::run(crank(constraint));
    EXPECT_EQ(r.report().status.code, Code::ok) << constraint;
    EXPECT_LE(r.report().error.position, 8 * kEps) << constraint;
    const std::size_t last = r.trajectory.rows() - 1;
    EXPECT_NEAR(r.trajectory(last, r.trajectory.index("B.x")), std::cos(6.5), 4 * kEps) << constraint;
  }
}

// A four-bar in the plane z = 0 of space. One equation for each bar keeps it in the plane; one of these equations is
// redundant.
Scene four_bar(double off, double size) {
  const auto at = [&](double x, double y) { return Triple{size * x, size * y, 0}; };
  SceneBuilder b("four_bar", 3);
  b.fixed_point("A", at(0, 0)).fixed_point("D", at(2, 0)).fixed_vector("n", {0, 0, 1});
  b.point("B", at(0.8, 0)).point("C", at(1.6, 1.2));
  b.constrain("coupler", Distance{"B", "C", 1.8 * size}).constrain("rocker", Distance{"D", "C", 1.3 * size});
  b.constrain("rocker_flat", Dot{"n", Direction("D", "C"), 0.0});
  b.constrain("coupler_flat", Dot{"n", Direction("B", "C"), off * size});
  b.constrain("third", Dot{"n", Direction("A", "C"), 0.0});
  b.drive("motor", PointAngle{"A", "B", "n", Law::polynomial({0, 6.283185307179586})});
  return b.measure("rocker_angle", AngleBetween{Direction("A", "D"), Direction("D", "C"), "n"})
      .time(0, 1, 0.01)
      .build();
}

Scene plane_four_bar() {
  SceneBuilder b("four_bar", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("D", {2, 0, 0}).point("B", {0.8, 0, 0}).point("C", {1.6, 1.2, 0});
  b.constrain("coupler", Distance{"B", "C", 1.8}).constrain("rocker", Distance{"D", "C", 1.3});
  b.drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, 6.283185307179586})});
  return b.time(0, 1, 0.01).build();
}

TEST(Vanishing, RedundantPlanesDoNotContradict) {
  const Result plane = test::run(plane_four_bar());
  const std::vector<std::string> strategies = {"auto", "global/eigen", "irreducible/lanes", "groups/eigen+reuse=run"};
  for (const double off : {0.0, kNearlyZero, -3e-16}) {
    for (const double size : {1.0, 0.001953125, 1024.0}) {  // powers of two give the bits of size 1
      for (const std::string& strategy : strategies) {
        const Result r = test::run(four_bar(off, size), strategy);
        ASSERT_EQ(r.report().status.code, Code::ok) << strategy << " " << off << " at " << r.report().reached;
        EXPECT_LE(r.report().error.position, 1e-14) << strategy << " " << off;
        for (std::size_t k = 0; k < r.trajectory.rows(); ++k) {
          for (const std::string c : {"C.x", "C.y"}) {
            EXPECT_NEAR(r.trajectory(k, r.trajectory.index(c)) / size, plane.trajectory(k, plane.trajectory.index(c)),
                        64 * kEps);
          }
        }
      }
    }
  }
}

// The plane of the bars is off by more than rounding errors.
TEST(Vanishing, RefusesLargerViolations) { EXPECT_THROW((void)test::run(four_bar(1e-7, 1)), Error); }

// A planar loop modelled in space, with slightly tilted frames in the guess: the terms of u2 . z become so small that
// their inverses overflow.
TEST(Vanishing, AcceptsSubnormalTerms) {
  const Scene scene = parse_scene(R"(
      {"assur": 1, "name": "upright", "dimension": 3, "points": {"A": {"at": [0.0, 0.0, 0.0], "fixed":
      true}, "D": {"at": [2.0029743597612804, -0.13036061027576884, 0.0], "fixed": true}}, "vectors":
      {"z": {"at": [0.0, 0.0, 1.0], "fixed": true}, "x": {"at": [1.0, 0.0, 0.0], "fixed": true}, "u1":
      {"at": [0.7984332297261308, -0.5987511442869755, 0.0632569749840836]}, "v1": {"at":
      [0.6016659599165765, 0.7973753364395574, -0.04680433223075845]}, "u2": {"at": [-0.5851799848425738,
      0.8079789727098059, 0.06880672204408533]}, "v2": {"at": [-0.7967370935079452, -0.5570922197586061,
      -0.23421840771583463]}}, "bodies": {"body1": {"origin": "A", "frame": ["u1", "v1", "z"], "points":
      {"B": [0.45055003274742994, -0.19963822529420833, 0.0]}, "vectors": {"z1": [0.0, 0.0, 1.0]}},
      "body2": {"origin": "B", "frame": ["u2", "v2", "z1"], "points": {"C": [0.025522905062496548,
      -2.2448370440897167, 0.0]}, "vectors": {"z2": [0.0, 0.0, 1.0]}}}, "constraints": {"c0": {"distance":
      ["D", "C"], "value": 1.4005563193379804}, "c1": {"dot": [["D", "C"], "z"], "value": 0.0}, "c2":
      {"parallel": ["z", "z2"]}}, "drivers": {"motor0": {"angle": ["x", "u1"], "axis": "z", "law":
      {"polynomial": [-0.5988806352722023, -0.7359767250045626, 0.05347068730845995]}}}, "time": {"start":
      0.0, "end": 0.4089600289487134, "step": 0.006816000482478557}}
  )");
  for (const std::string strategy : {"irreducible/eigen", "irreducible/lanes", "groups/eigen"}) {
    SCOPED_TRACE(strategy);
    const Result r = test::run(scene, strategy);
    EXPECT_EQ(r.report().status.code, Code::ok);
    EXPECT_LE(r.report().error.position, 16 * kEps);
  }
}

// The scale vanishes for no directions, and hardly changes for random ones.
TEST(Vanishing, ScalesDoNotVanish) {
  SceneBuilder b("scales", 3);
  b.fixed_point("A", {0, 0, 0}).point("B", {1, 0, 0}).vector("e", {0, 1, 0}).vector("f", {0, 0, 1});
  b.constrain("both", Dot{"e", "f", 0.0}).constrain("one", Dot{"e", Direction("A", "B"), 0.0});
  b.constrain("flat", FixedCoordinate{"B.z", 0.0});
  const System s = lower(std::make_shared<const Scene>(b.time(0, 1, 1).build()), {}, false);
  std::vector<double> q = s.guess;
  for (Index e = 0; e < static_cast<Index>(s.equations.size()); ++e) {
    const std::string name = s.equation_name(e);
    if (name.starts_with("|")) {
      EXPECT_DOUBLE_EQ(residual_scale(s, e, q), size_of_terms(s, e, q)) << name;
      continue;
    }
    EXPECT_EQ(size_of_terms(s, e, q), 0) << name;
    EXPECT_GE(residual_scale(s, e, q), 1) << name;
    EXPECT_LE(residual_scale(s, e, q), 1 + 2 * 2 * kLeastFactor) << name;
  }
}

}  // namespace
}  // namespace assur
