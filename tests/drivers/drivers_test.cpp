// Every kind of driver and body compared with closed forms. Tolerances: a few roundings of numbers of size 1 at
// conditions up to 10. Rates and accelerations are up to 10.
#include <gtest/gtest.h>

#include "plan/preparation.hpp"
#include "simulation/run.hpp"

namespace assur {
namespace {

using test::Result;

constexpr double kValue = 64 * kEps, kRate = 640 * kEps, kAcceleration = 6400 * kEps;

Law swing(double amplitude, double omega, double phase, double offset = 0) {
  return Law::function([=](double t) -> Motion {
    const double s = std::sin(omega * t + phase), c = std::cos(omega * t + phase);
    return {offset + amplitude * s, amplitude * omega * c, -amplitude * omega * omega * s};
  });
}

const std::vector<std::string> kStrategies = {"global/eigen", "groups/eigen", "irreducible/eigen",
                                              "irreducible/eigen+once"};

// Runs `scene` in every formulation; check(trajectory, row, t) for every row.
template <class Check>
void every_row(const Scene& scene, const Check& check) {
  for (const std::string& strategy : kStrategies) {
    SCOPED_TRACE(scene.name() + " " + strategy);
    const Result r = test::run(scene, strategy);
    ASSERT_EQ(r.report().status.code, Code::ok) << "at " << r.report().reached;
    if (r.counters().group_solutions > 0) {
      EXPECT_LE(r.report().error.position, 1e-14);
    } else {
      EXPECT_TRUE(std::isnan(r.report().error.position));
    }
    ASSERT_EQ(r.trajectory.rows(), static_cast<std::size_t>(scene.time().steps()) + 1);
    for (std::size_t k = 0; k < r.trajectory.rows(); ++k) {
      check(r.trajectory, k, r.trajectory.times()[k]);
      if (testing::Test::HasFailure()) return;
    }
  }
}

// Compares the position of a point or vector with its closed form, and its derivatives with central differences of the
// closed form over t - h, t, t + h. The differences have errors of h^2 / 6 times the third derivative and h^2 / 12
// times the fourth, both at most 100 here, and rounding errors of eps / h and 4 eps / h^2.
template <class ClosedForm>
void expect_motion(const Trajectory& trajectory, std::size_t row, double t, const std::string& name, int dimension,
                   const ClosedForm& closed_form) {
  const double h = 1e-4;
  const std::array<double, 3> at = closed_form(t), before = closed_form(t - h), after = closed_form(t + h);
  for (int i = 0; i < dimension; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const std::string axis(1, "xyz"[i]);
    EXPECT_NEAR(trajectory(row, trajectory.index(name + "." + axis)), at[k], kValue) << name << axis << " at " << t;
    EXPECT_NEAR(trajectory(row, trajectory.index(name + ".v" + axis)), (after[k] - before[k]) / (2 * h), 100 * h * h)
        << name << ".v" << axis << " at " << t;
    EXPECT_NEAR(trajectory(row, trajectory.index(name + ".a" + axis)), (after[k] - 2 * at[k] + before[k]) / (h * h),
                1000 * h * h + 8 * kEps / (h * h))
        << name << ".a" << axis << " at " << t;
  }
}

TEST(Drivers, PoseMovesABodyInThePlane) {
  const Law x = swing(0.2, 1, 0.1), y = swing(0.1, 2, 0.3, 0.5), angle = swing(1.5, 1.5, 0);
  SceneBuilder builder("pose2", 2);
  builder.point("O", {0.02, 0.53, 0}).vector("u", {1, 0, 0}).fixed_point("G", {-1, 0, 0});
  builder.add(Body{"plate", "O", {"u"}, {}, {{"P", {0.3, -0.2, 0}}}, {{"d", {0.6, 0.8, 0}}}});
  builder.drive("pose", Pose{"plate", {x, y}, {angle}}).measure("length", MeasuredDistance{"G", "P"});
  builder.time(0, 4, 0.02);
  every_row(builder.build(), [&](const Trajectory& r, std::size_t k, double t) {
    const auto turned = [&](double at, double a, double b) -> std::array<double, 3> {
      const double c = std::cos(angle(at).value), s = std::sin(angle(at).value);
      return {c * a - s * b, s * a + c * b, 0};
    };
    const auto p = [&](double at) -> std::array<double, 3> {
      const auto v = turned(at, 0.3, -0.2);
      return {x(at).value + v[0], y(at).value + v[1], 0};
    };
    expect_motion(r, k, t, "P", 2, p);
    expect_motion(r, k, t, "d", 2, [&](double at) { return turned(at, 0.6, 0.8); });
    EXPECT_NEAR(r(k, r.index("length")), std::hypot(p(t)[0] + 1, p(t)[1]), kValue);
  });
}

// A wrist: the body T turns and moves; its vector e turns relative to its vector d about its vector a.
TEST(Drivers, RelativeAngleTurnsAboutAMovingAxis) {
  const Law psi = swing(1, 1, 0), theta = swing(0.8, 1.3, 0.2), relative = Law::polynomial({0.3, 1.5, -0.2});
  SceneBuilder builder("wrist", 3);
  builder.point("O", {0, 0, 0}).vector("u", {1, 0, 0}).vector("v", {0, 1, 0}).vector("w", {0, 0, 1});
  builder.add(Body{"T", "O", {"u", "v", "w"}, {}, {}, {{"d", {1, 0, 0}}, {"a", {0, 0.6, 0.8}}}});
  builder.vector("e", {std::cos(0.3), 0.8 * std::sin(0.3), -0.6 * std::sin(0.3)});
  builder.constrain("across", Dot{"e", "a", 0.0});
  builder.drive("pose", Pose{"T", {Law(), Law(), Law()}, {psi, theta, Law()}});
  builder.drive("motor", RelativeAngle{"d", "e", "a", relative}).measure("angle", AngleBetween{"d", "e", "a"});
  builder.time(0, 3, 0.01);
  every_row(builder.build(), [&](const Trajectory& r, std::size_t k, double t) {
    expect_motion(r, k, t, "e", 3, [&](double at) -> std::array<double, 3> {
      const double cp = std::cos(psi(at).value), sp = std::sin(psi(at).value);
      const double ct = std::cos(theta(at).value), st = std::sin(theta(at).value);
      // in the frame of T, e = cos d + sin (a x d) with a x d = (0, 0.8, -0.6)
      const double c = std::cos(relative(at).value), s = std::sin(relative(at).value);
      const double ex = c, ey = 0.8 * s, ez = -0.6 * s;
      return {cp * (ct * ex + st * ez) - sp * ey, sp * (ct * ex + st * ez) + cp * ey, -st * ex + ct * ez};
    });
    const Motion m = relative(t);
    EXPECT_NEAR(r(k, r.index("angle")), m.value, kValue);
    EXPECT_NEAR(r(k, r.index("angle.rate")), m.rate, kRate);
    EXPECT_NEAR(r(k, r.index("angle.acceleration")), m.acceleration, kAcceleration);
  });
}

// Two links in the plane, the second driven relative to the first.
TEST(Drivers, RelativeAngleTurnsTheSecondLink) {
  const Law first = Law::polynomial({0.2, 1}), second = swing(2.5, 1, 0.4);
  SceneBuilder builder("arm", 2);
  builder.fixed_point("A", {0, 0, 0}).point("B", {std::cos(0.2), std::sin(0.2), 0});
  const double start = 0.2 + 2.5 * std::sin(0.4);
  builder.point("C", {std::cos(0.2) + 0.7 * std::cos(start), std::sin(0.2) + 0.7 * std::sin(start), 0});
  builder.constrain("forearm", Distance{"B", "C", 0.7});
  builder.drive("shoulder", PointAngle{"A", "B", "", first});
  builder.drive("elbow", RelativeAngle{Direction{"A", "B"}, Direction{"B", "C"}, "", second}).time(0, 6, 0.02);
  every_row(builder.build(), [&](const Trajectory& r, std::size_t k, double t) {
    expect_motion(r, k, t, "C", 2, [&](double at) -> std::array<double, 3> {
      const double a = first(at).value, b = a + second(at).value;
      return {std::cos(a) + 0.7 * std::cos(b), std::sin(a) + 0.7 * std::sin(b), 0};
    });
  });
}

// A flap hinged about x. Its base has three points; members outside their plane need the normal.
TEST(Bodies, BaseOfThreePointsHasANormal) {
  const Law angle = swing(2, 1, 0);
  SceneBuilder builder("flap", 3);
  builder.fixed_point("A", {0, 0, 0})
      .fixed_point("B", {1.5, 0, 0})
      .point("C", {0, 0.8, 0})
      .fixed_vector("x", {1, 0, 0});
  builder.add(Body{"flap", "", {}, {"A", "B", "C"}, {{"M", {0.2, 0.3, 0.5}}}, {{"n", {0, 0.6, 0.8}}}});
  builder.drive("hinge", PointAngle{"A", "C", "x", angle}).time(0, 4, 0.02);
  every_row(builder.build(), [&](const Trajectory& r, std::size_t k, double t) {
    const auto turned = [&](double at, double x, double y, double z) -> std::array<double, 3> {
      const double c = std::cos(angle(at).value), s = std::sin(angle(at).value);
      return {x, c * y - s * z, s * y + c * z};
    };
    expect_motion(r, k, t, "M", 3, [&](double at) { return turned(at, 0.2, 0.3, 0.5); });
    expect_motion(r, k, t, "n", 3, [&](double at) { return turned(at, 0, 0.6, 0.8); });
  });
}

// The flap with unknowns: a rod connects C to a crank about Q, so that the base is solved for.
TEST(Bodies, BaseOfThreePointsIsSolvedInAGroup) {
  const Law angle = swing(-0.5, 1, 1.5707963267948966, 0.5);
  SceneBuilder builder("flap", 3);
  builder.fixed_point("A", {0, 0, 0})
      .fixed_point("B", {1.5, 0, 0})
      .point("C", {0, 0.8, 0})
      .fixed_vector("x", {1, 0, 0});
  builder.fixed_point("Q", {0, 1.6, 0}).point("D", {0, 1.6, 0.8});
  builder.add(Body{"flap", "", {}, {"A", "B", "C"}, {{"M", {0.2, 0.3, 0.5}}}, {}});
  builder.constrain("rod", Distance{"C", "D", {}});
  builder.drive("crank", PointAngle{"Q", "D", "x", angle}).time(0, 6, 0.02);
  every_row(builder.build(), [&](const Trajectory& r, std::size_t k, double) {
    const auto value = [&](const char* column) { return r(k, r.index(column)); };
    // M is rigid with A, B and C, so it keeps its coordinates in the frame of x and C.
    const double cy = value("C.y") / 0.8, cz = value("C.z") / 0.8;
    EXPECT_NEAR(value("C.y") * value("C.y") + value("C.z") * value("C.z"), 0.64, kValue);
    EXPECT_NEAR(value("C.x"), 0, kValue);
    EXPECT_NEAR(value("M.x"), 0.2, kValue);
    EXPECT_NEAR(value("M.y"), 0.3 * cy - 0.5 * cz, kValue);
    EXPECT_NEAR(value("M.z"), 0.3 * cz + 0.5 * cy, kValue);
    EXPECT_NEAR(value("M.vy"), (0.3 * value("C.vy") - 0.5 * value("C.vz")) / 0.8, kRate);
    EXPECT_NEAR(value("M.az"), (0.3 * value("C.az") + 0.5 * value("C.ay")) / 0.8, kAcceleration);
  });
}

TEST(Bodies, Translate) {
  const Law x = swing(0.4, 1, 0), z = Law::polynomial({0.1, 0.2, 0.3});
  SceneBuilder builder("shuttle", 3);
  builder.point("O", {0, 0.5, 0.1});
  builder.add(Body{"shuttle", "O", {}, {}, {{"M", {1, 2, 3}}}, {{"d", {0, 0, 1}}}});
  builder.constrain("level", FixedCoordinate{"O.y", 0.5});
  builder.drive("along", DrivenCoordinate{"O.x", x}).drive("up", DrivenCoordinate{"O.z", z}).time(0, 3, 0.03);
  every_row(builder.build(), [&](const Trajectory& r, std::size_t k, double t) {
    expect_motion(r, k, t, "M", 3, [&](double at) -> std::array<double, 3> {
      return {1 + x(at).value, 2.5, 3 + z(at).value};
    });
  });
}

// Drives both coordinates in a turning plane.
TEST(Drivers, DriveLambdaAndMuInAMovingPlane) {
  const Law lambda = swing(0.3, 1, 0, 1), mu = swing(0.4, 2, 0.5), psi = swing(0.7, 1, 0);
  SceneBuilder builder("table", 3);
  builder.point("O", {0, 0, 0}).vector("u", {1, 0, 0}).vector("v", {0, 1, 0}).vector("w", {0, 0, 1});
  builder.add(Body{"table", "O", {"u", "v", "w"}, {}, {}, {{"d", {1, 0, 0}}, {"e", {0, 0.6, 0.8}}}});
  builder.point("P", {1, 0.6 * 0.4 * std::sin(0.5), 0.8 * 0.4 * std::sin(0.5)});
  builder.constrain("plane", OnPlane{"P", "O", "d", "e"});
  builder.drive("pose", Pose{"table", {Law(), Law(), swing(0.1, 1, 0)}, {psi, Law(), Law()}});
  builder.drive("first", DrivenCoordinate{"plane.lambda", lambda}).drive("second", DrivenCoordinate{"plane.mu", mu});
  builder.measure("moved", MeasuredCoordinate{"plane.mu"}).time(0, 4, 0.02);
  every_row(builder.build(), [&](const Trajectory& r, std::size_t k, double t) {
    expect_motion(r, k, t, "P", 3, [&](double at) -> std::array<double, 3> {
      const double c = std::cos(psi(at).value), s = std::sin(psi(at).value);
      const double x = lambda(at).value, y = 0.6 * mu(at).value, z = 0.8 * mu(at).value;
      return {c * x - s * y, s * x + c * y, z + 0.1 * std::sin(at)};
    });
    EXPECT_NEAR(r(k, r.index("moved")), mu(t).value, kValue);
    EXPECT_NEAR(r(k, r.index("moved.acceleration")), mu(t).acceleration, kAcceleration);
  });
}

// A telescope: P - A = lambda d along a turning unit vector d. Where lambda is zero, the pattern does not change.
TEST(Drivers, DriveTheLambdaOfAParallel) {
  const Law angle = Law::polynomial({0.1, 0.8}), lambda = swing(1, 1, 0.5);
  SceneBuilder builder("telescope", 2);
  const double start = std::sin(0.5);
  builder.fixed_point("A", {0, 0, 0}).point("P", {start * std::cos(0.1), start * std::sin(0.1), 0});
  builder.point("Q", {std::cos(0.1), std::sin(0.1), 0});
  builder.constrain("rod", Parallel{Direction{"A", "Q"}, Direction{"A", "P"}});
  builder.drive("turn", PointAngle{"A", "Q", "", angle}).drive("extend", DrivenCoordinate{"rod.lambda", lambda});
  builder.time(0, 6, 0.02);
  every_row(builder.build(), [&](const Trajectory& r, std::size_t k, double t) {
    expect_motion(r, k, t, "P", 2, [&](double at) -> std::array<double, 3> {
      return {lambda(at).value * std::cos(angle(at).value), lambda(at).value * std::sin(angle(at).value), 0};
    });
  });
}

// ---- callbacks

// |P - Q|^2 = length^2 as a callback on P.x, P.y, Q.x, Q.y.
Callback distance(const std::string& p, const std::string& q, double length) {
  Callback c;
  c.coordinates = {p + ".x", p + ".y", q + ".x", q + ".y"};
  c.equations = 1;
  c.residual = [length](std::span<const double> x, std::span<double> phi) {
    const double dx = x[0] - x[2], dy = x[1] - x[3];
    phi[0] = dx * dx + dy * dy - length * length;
  };
  c.jacobian = [](std::span<const double> x, std::span<double> j) {
    const double dx = x[0] - x[2], dy = x[1] - x[3];
    j[0] = 2 * dx, j[1] = 2 * dy, j[2] = -2 * dx, j[3] = -2 * dy;
  };
  c.curvature = [](std::span<const double>, std::span<const double> v, std::span<double> out) {
    const double dx = v[0] - v[2], dy = v[1] - v[3];
    out[0] = 2 * (dx * dx + dy * dy);
  };
  return c;
}

TEST(Callbacks, ADistanceCallbackEqualsTheConstraint) {
  const Scene built_in = sample("four_bar:loops=2,step=0.005,steps=400");
  SceneBuilder builder("four_bar", 2);
  for (const Point& p : built_in.points()) builder.add(p);
  for (const Constraint& c : built_in.constraints()) {
    const auto& d = *c.as<Distance>();
    if (c.name == "coupler1" || c.name == "rocker2") {
      builder.constrain(c.name, distance(d.p, d.q, *d.value));
    } else {
      builder.add(c);
    }
  }
  for (const Driver& d : built_in.drivers()) builder.add(d);
  for (const Measure& m : built_in.measures()) builder.add(m);
  const Scene by_callback = builder.time(0, 2, 0.005).build();
  for (const std::string& strategy : kStrategies) {
    SCOPED_TRACE(strategy);
    const Result a = test::run(built_in, strategy), b = test::run(by_callback, strategy);
    ASSERT_EQ(b.report().status.code, Code::ok) << "at " << b.report().reached;
    EXPECT_LE(test::difference(a.trajectory, b.trajectory), 1e-13);
    // The residual of a callback is scaled by its derivatives, which costs a few more roundings.
    EXPECT_LE(b.report().error.position, 1e-14);
  }
}

// Two to one: e = (d.x^2 - d.y^2, 2 d.x d.y) turns twice as fast as d.
TEST(Callbacks, CanModelAGear) {
  const Law angle = Law::polynomial({0.1, 2, 0.3});
  Callback gear;
  gear.coordinates = {"D.x", "D.y", "E.x", "E.y"};
  gear.equations = 2;
  gear.residual = [](std::span<const double> x, std::span<double> phi) {
    phi[0] = x[2] - (x[0] * x[0] - x[1] * x[1]);
    phi[1] = x[3] - 2 * x[0] * x[1];
  };
  gear.jacobian = [](std::span<const double> x, std::span<double> j) {
    j[0] = -2 * x[0], j[1] = 2 * x[1], j[2] = 1, j[3] = 0;
    j[4] = -2 * x[1], j[5] = -2 * x[0], j[6] = 0, j[7] = 1;
  };
  gear.curvature = [](std::span<const double>, std::span<const double> v, std::span<double> c) {
    c[0] = -2 * (v[0] * v[0] - v[1] * v[1]);
    c[1] = -4 * v[0] * v[1];
  };
  SceneBuilder builder("gear", 2);
  builder.fixed_point("O", {0, 0, 0}).point("D", {std::cos(0.1), std::sin(0.1), 0});
  builder.point("E", {std::cos(0.2), std::sin(0.2), 0}).fixed_point("F", {3, 0, 0});
  builder.point("G", {2, 1.5, 0}).constrain("gear", gear);
  builder.constrain("EG", Distance{"E", "G", 2.5}).constrain("FG", Distance{"F", "G", 2.0});
  builder.drive("motor", PointAngle{"O", "D", "", angle}).measure("double", AbsoluteAngle{"O", "E"}).time(0, 4, 0.02);
  every_row(builder.build(), [&](const Trajectory& r, std::size_t k, double t) {
    const Motion m = angle(t);
    EXPECT_NEAR(r(k, r.index("double")), 2 * m.value, kValue);
    EXPECT_NEAR(r(k, r.index("double.rate")), 2 * m.rate, kRate);
    EXPECT_NEAR(r(k, r.index("double.acceleration")), 2 * m.acceleration, kAcceleration);
    const double ex = r(k, r.index("E.x")), ey = r(k, r.index("E.y"));
    EXPECT_NEAR(std::hypot(r(k, r.index("G.x")) - ex, r(k, r.index("G.y")) - ey), 2.5, kValue);
  });
}

// ---- redundant equations

// Three equal cranks on one coupler: one rod is redundant; it is checked, not solved.
Scene three_rods(double third) {
  SceneBuilder builder("three_rods", 2);
  const double x = std::cos(1.0), y = std::sin(1.0);
  builder.fixed_point("A", {0, 0, 0}).fixed_point("B", {1, 0, 0}).fixed_point("C", {2, 0, 0});
  builder.point("P", {x, y, 0}).point("R", {x + 2, y, 0});
  builder.add(Body{"coupler", "", {}, {"P", "R"}, {{"Q", {1, 0, 0}}}, {}});
  builder.constrain("crank", Distance{"A", "P", 1.0}).constrain("rocker", Distance{"C", "R", 1.0});
  builder.constrain("third", Distance{"B", "Q", third});
  builder.drive("motor", PointAngle{"A", "P", "", swing(0.9, 1, 0, 1)}).time(0, 6, 0.02);
  return builder.build();
}

TEST(Redundancy, ChecksAThirdParallelRod) {
  every_row(three_rods(1), [&](const Trajectory& r, std::size_t k, double t) {
    const double angle = 1 + 0.9 * std::sin(t);
    EXPECT_NEAR(r(k, r.index("R.x")), 2 + std::cos(angle), 4 * kValue);  // sine between the bars: at least 0.1
    EXPECT_NEAR(r(k, r.index("Q.y")), std::sin(angle), 4 * kValue);
  });
  const Prepared p = prepare(three_rods(1), {"groups/eigen", {}});
  const GroupedSystem& structure = *preparation(p).structure;
  ASSERT_EQ(structure.redundant.size(), 1u);
  EXPECT_TRUE(structure.undetermined.empty());
  ASSERT_EQ(structure.checks.size(), 1u);
  // Every posture also evaluates the checked equation.
  const Result r = test::run(three_rods(1), "groups/eigen");
  std::int64_t unknowns = 0;
  for (const SolvedGroup& g : structure.groups) unknowns += static_cast<std::int64_t>(g.unknowns.size());
  ASSERT_EQ(structure.groups.size(), 1u);
  EXPECT_EQ(r.counters().evaluated_equations,
            unknowns * (r.counters().newton_iterations + r.counters().group_solutions) + r.counters().steps + 1);
}

TEST(Redundancy, AnInconsistentRodIsRefused) {
  try {
    (void)prepare(three_rods(1.01), {"groups/eigen", {}});
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), Error::Kind::numerical);
    EXPECT_NE(std::string(e.what()).find("'third'"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace assur
