// Laws and callbacks of the program with wrong derivatives: prepare() refuses them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "backends/allocations.hpp"
#include "motion/fan.hpp"
#include "simulation/run.hpp"

namespace assur {
namespace {

constexpr double kOff = 1e-3;

// Relative errors of the derivatives.
struct Fault {
  double jacobian = 0, curvature = 0;
};

struct Calls {
  std::int64_t residual = 0, jacobian = 0, curvature = 0;
  [[nodiscard]] std::int64_t all() const { return residual + jacobian + curvature; }
};

// A callback with two rows: |C - B| = 1.8 and |C - D| = 1.3.
Callback two_lengths(const Fault& fault, std::shared_ptr<Calls> calls = std::make_shared<Calls>()) {
  Callback c;
  c.coordinates = {"C.x", "C.y", "B.x", "B.y"};
  c.equations = 2;
  c.residual = [calls](std::span<const double> x, std::span<double> phi) {
    ++calls->residual;
    phi[0] = (x[0] - x[2]) * (x[0] - x[2]) + (x[1] - x[3]) * (x[1] - x[3]) - 1.8 * 1.8;
    phi[1] = (x[0] - 2) * (x[0] - 2) + x[1] * x[1] - 1.3 * 1.3;
  };
  c.jacobian = [fault, calls](std::span<const double> x, std::span<double> j) {
    ++calls->jacobian;
    const double a[8] = {
        2 * (x[0] - x[2]), 2 * (x[1] - x[3]), -2 * (x[0] - x[2]), -2 * (x[1] - x[3]), 2 * (x[0] - 2), 2 * x[1], 0, 0};
    std::copy(a, a + 8, j.begin());
    j[5] *= 1 + fault.jacobian;
  };
  c.curvature = [fault, calls](std::span<const double>, std::span<const double> v, std::span<double> out) {
    ++calls->curvature;
    const auto square = [](double a) { return a * a; };
    out[0] = 2 * (square(v[0] - v[2]) + square(v[1] - v[3]));
    out[1] = 2 * (square(v[0]) + square(v[1]));
    out[0] *= 1 + fault.curvature;
  };
  return c;
}

SceneBuilder& four_bar(SceneBuilder& b, Callback lengths, Law motor = Law::polynomial({0, 2})) {
  return b.fixed_point("A", {0, 0, 0})
      .fixed_point("D", {2, 0, 0})
      .point("B", {0.8, 0, 0})
      .point("C", {1.6, 1.2, 0})
      .constrain("lengths", std::move(lengths))
      .constrain("crank", Distance{"A", "B", 0.8})
      .drive("motor", PointAngle{"A", "B", "", std::move(motor)});
}

Scene scene_of(Callback lengths, Law motor = Law::polynomial({0, 2}), double end = 3) {
  SceneBuilder b("two_lengths", 2);
  return four_bar(b, std::move(lengths), std::move(motor)).time(0, end, 0.01).build();
}

std::string refusal(const Scene& scene, PrepareOptions options = {}) {
  try {
    (void)prepare(scene, options);
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), Error::Kind::input);
    return e.what();
  }
  return "";
}

TEST(FunctionCheck, AWrongJacobianAtTheStartIsBadInput) {
  for (const std::string strategy : {"global/eigen", "groups/eigen", "irreducible/eigen"}) {
    const std::string what = refusal(scene_of(two_lengths({.jacobian = kOff})), {.strategy = strategy});
    EXPECT_EQ(what.rfind("/constraints/lengths: jacobian[row 1, C.y] is ", 0), 0u) << what;
  }
  EXPECT_EQ(refusal(scene_of(two_lengths({}))), "");
}

// Derivatives with respect to fixed points are not used.
TEST(FunctionCheck, DerivativesByConstantsAreOptional) {
  Callback c = test::distance_by_callback("C", "D", 1.3);
  c.jacobian = [](std::span<const double> x, std::span<double> j) {
    j[0] = 2 * (x[0] - x[2]), j[1] = 2 * (x[1] - x[3]), j[2] = j[3] = 0;
  };
  SceneBuilder b("left_out", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("D", {2, 0, 0}).point("B", {0.8, 0, 0}).point("C", {1.6, 1.2, 0});
  b.constrain("crank", Distance{"A", "B", 0.8}).constrain("coupler", Distance{"B", "C", 1.8}).constrain("rocker", c);
  b.drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, 2})}).time(0, 1, 0.01);
  for (const std::string strategy : {"global/eigen", "irreducible/eigen"}) {
    Simulator s = test::simulator(b.build(), strategy);
    (void)s.run();
    EXPECT_TRUE(s.report().status.ok());
  }
}

// The guess is too rough to be a posture, so the assembly needs the Jacobian. The error names the wrong Jacobian, too.
TEST(FunctionCheck, NamesAJacobianThatPreventsTheAssembly) {
  Callback c = two_lengths({});
  c.jacobian = [](std::span<const double>, std::span<double> j) { std::fill(j.begin(), j.end(), 1.0); };
  try {
    (void)prepare(scene_of(c), {.strategy = "global/eigen"});
    ADD_FAILURE() << "a Jacobian of ones was accepted";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("/constraints/lengths: jacobian[row "), std::string::npos) << e.what();
  }
}

// Only accelerations need it.
TEST(FunctionCheck, AWrongCurvatureIsBadInput) {
  const Scene scene = scene_of(two_lengths({.curvature = kOff}));
  const std::string what = refusal(scene);
  EXPECT_EQ(what.rfind("/constraints/lengths: curvature[row 0] is ", 0), 0u) << what;
  EXPECT_EQ(refusal(scene.with_outputs({"C.velocity"})), "");
}

TEST(FunctionCheck, AToleranceAllowsApproximations) {
  Callback c = two_lengths({.jacobian = kOff});
  c.tolerance = 2e-3;
  EXPECT_EQ(refusal(scene_of(c)), "");
}

TEST(FunctionCheck, ARunNeedsNoCalls) {
  const auto calls_of = [](double tolerance) {
    auto calls = std::make_shared<Calls>();
    Callback c = two_lengths({}, calls);
    c.tolerance = tolerance;
    std::int64_t asked = 0;
    const Law law = Law::function([&](double t) { return ++asked, Motion{2 * t, 2, 0}; }, tolerance);
    Simulator s = test::simulator(scene_of(std::move(c), law), "global/eigen");
    const std::int64_t before = calls->all() + asked;
    EXPECT_EQ(s.run().rows(), 301u);
    EXPECT_TRUE(s.report().status.ok());
    return calls->all() + asked - before;
  };
  EXPECT_EQ(calls_of(kDerivativeTolerance), calls_of(std::numeric_limits<double>::infinity()));
}

TEST(FunctionCheck, AllocatesNothing) {
  const Scene scene = scene_of(two_lengths({}), Law::function([](double t) { return Motion{2 * t, 2, 0}; }));
  Simulator s = test::simulator(scene, "global/eigen");
  for (int k = 1; k <= 2; ++k) ASSERT_TRUE(s.step(scene.time().time(k)).ok());
  const std::int64_t before = test::allocations();
  bool ok = true;
  for (int k = 3; k <= 150; ++k) ok = s.step(scene.time().time(k)).ok() && ok;
  EXPECT_EQ(test::allocations(), before);
  EXPECT_TRUE(ok);
}

// ---- laws

// The law t + t^2, with a wrong rate and acceleration from a time on.
Law law_off(double rate, double acceleration, double from) {
  return Law::function([=](double t) {
    const bool wrong = t >= from;
    return Motion{t + t * t, (1 + 2 * t) * (wrong ? 1 + rate : 1), 2 * (wrong ? 1 + acceleration : 1)};
  });
}

Scene with_law(Law law) { return test::Fan("law", 0, std::move(law)).dyad(2, 1.8, 1.3).build(3, 0.01); }

TEST(FunctionCheck, AWrongLawAtTheStartIsBadInput) {
  EXPECT_EQ(refusal(with_law(law_off(kOff, 0, 0))).rfind("/drivers/motor/law: the rate at t = 0.0038", 0), 0u);
  EXPECT_EQ(refusal(with_law(law_off(0, kOff, 0))).rfind("/drivers/motor/law: the acceleration at t = 0.0038", 0), 0u);
  EXPECT_EQ(refusal(with_law(law_off(0, 0, 0))), "");
  EXPECT_NE(refusal(with_law(Law::function([n = 0](double t) mutable {
              return Motion{t + 1e-3 * (n++ % 2), 1, 0};
            }))).find("when it is called again"),
            std::string::npos);
}

TEST(FunctionCheck, PositionsNeedNoRatesOfLaws) {
  const Scene scene = with_law(Law::function([](double t) { return Motion{t, 0, 0}; }));
  EXPECT_NE(refusal(scene), "");
  const Scene positions = scene.with_outputs({"C0.position"});
  Simulator s = test::simulator(positions, "irreducible/eigen");
  (void)s.run();
  EXPECT_TRUE(s.report().status.ok());
}

TEST(FunctionCheck, ALawThatBecomesWrongIsBadInput) {
  for (const bool rate : {true, false}) {
    const std::string what = refusal(with_law(law_off(rate ? kOff : 0, rate ? 0 : kOff, 1.0)));
    const std::string expected =
        rate ? "/drivers/motor/law: the rate at t = 1." : "/drivers/motor/law: the acceleration at t = 1.";
    EXPECT_EQ(what.rfind(expected, 0), 0u) << what;
  }
}

// The outputs are driven coordinates, so that no equation would show the error.
TEST(FunctionCheck, ANaNRateEndsTheRun) {
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    for (const bool rate : {true, false}) {
      const Law law = Law::function(
          [=](double t) {
            const bool now = t > 0.505;
            return Motion{t, now && rate ? bad : 1, now && !rate ? bad : 0};
          },
          HUGE_VAL);
      SceneBuilder b("slide", 2);
      b.point("P", {0, 1, 0}).drive("x", DrivenCoordinate{"P.x", law});
      b.drive("y", DrivenCoordinate{"P.y", Law::constant(1)}).time(0, 1, 0.01);
      Simulator s = test::simulator(b.build());
      const Trajectory t = s.run();
      EXPECT_EQ(s.report().status.code, Code::not_finite);
      EXPECT_EQ(t.times().back(), 0.5);
    }
  }
}

TEST(FunctionCheck, AcceptsAFarDeadline) {
  for (const double seconds : {3e10, 1e300, HUGE_VAL}) {
    Simulator s = test::simulator(sample("four_bar:steps=5"), "global/eigen", {.seconds = seconds});
    (void)s.run();
    EXPECT_TRUE(s.report().status.ok()) << seconds;
  }
}

TEST(FunctionCheck, NamesANaNResidualAtTheStart) {
  Callback c = two_lengths({});
  c.residual = [](std::span<const double>, std::span<double> phi) { phi[0] = phi[1] = std::nan(""); };
  try {
    (void)prepare(scene_of(c));
    ADD_FAILURE() << "no number was accepted";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("/constraints/lengths: residual[row 0] is "), std::string::npos) << e.what();
  }
}

// The rate of a command need not be the derivative of its values.
TEST(FunctionCheck, DoesNotCheckCommands) {
  Simulator s(prepare(with_law(law_off(kOff, 0, 0.5)), {.strategy = "global/eigen", .controlled = {"motor"}}));
  for (int k = 1; k <= 100; ++k) {
    s.set("motor", 0.02 * k, 7, 0);
    EXPECT_TRUE(s.step().arrived()) << k;
  }
}

}  // namespace
}  // namespace assur
