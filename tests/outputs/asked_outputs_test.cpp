// Outputs by name, and their columns.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <sstream>

#include "assur/ensemble.hpp"
#include "assur/saved_plan.hpp"
#include "simulation/run.hpp"

namespace assur {
namespace {

constexpr double kPi = std::numbers::pi;

std::string refusal(const Scene& scene, const std::string& output) {
  try {
    (void)scene.with_outputs({output});
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

// A pendulum of length 1 whose angle from +x is 0.5 + 2 t. The driver adds auxiliary unknowns, which are columns, too.
Scene pendulum() {
  return SceneBuilder("pendulum", 2)
      .fixed_point("A", {0, 0})
      .fixed_point("X", {1, 0})
      .point("B", {std::cos(0.5), std::sin(0.5)})
      .constrain("length", Distance{"A", "B", 1.0})
      .drive("motor", RelativeAngle{{"A", "X"}, {"A", "B"}, "", Law::polynomial({0.5, 2})})
      .time(0, 1, 0.25)
      .build();
}

TEST(AskedOutputs, EveryColumnHasItsOwnName) {
  for (const Scene& scene : {sample("slider_crank:steps=4"), sample("stewart:steps=2"), pendulum()}) {
    const test::Result all = test::run(scene.with_outputs({"all"}), "irreducible/eigen");
    const std::vector<std::string>& columns = all.trajectory.columns();
    for (std::size_t c = 0; c < columns.size(); c += 1 + columns.size() / 40) {  // about 40 of the columns
      const test::Result one = test::run(scene.with_outputs({columns[c]}), "irreducible/eigen");
      // The name of a scalar includes its derivatives.
      ASSERT_EQ(one.trajectory.columns().front(), columns[c]);
      EXPECT_LE(one.trajectory.columns().size(), 3u) << columns[c];
      ASSERT_EQ(one.trajectory.rows(), all.trajectory.rows());
      for (std::size_t k = 0; k < all.trajectory.rows(); ++k) {
        const double is = one.trajectory(k, 0), expected = all.trajectory(k, c);
        EXPECT_NEAR(is, expected, 1e-9 * std::max(1.0, std::abs(expected))) << columns[c];
      }
    }
  }
}

TEST(AskedOutputs, ARepeatedColumnStandsOnceAtItsFirstPlace) {
  const auto columns = [](const std::vector<std::string>& outputs) {
    return test::simulator(sample("four_bar").with_outputs(outputs)).columns();
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(columns({"B1.vy"}), (Names{"B1.vy"}));
  EXPECT_EQ(columns({"B1.vy", "B1.x", "B1.vy"}), (Names{"B1.vy", "B1.x"}));
  EXPECT_EQ(columns({"B1.vy", "B1"}), (Names{"B1.vy", "B1.x", "B1.y", "B1.vx", "B1.ax", "B1.ay"}));
  EXPECT_EQ(columns({"B1.position", "B1.x", "B1.y"}), (Names{"B1.x", "B1.y"}));
}

TEST(AskedOutputs, PartsOfBodiesAndDriversCanBeOutputs) {
  const Scene scene = sample("stewart");
  EXPECT_EQ(test::simulator(scene.with_outputs({"P3.z"})).columns(), std::vector<std::string>{"P3.z"});
  const test::Result r = test::run(pendulum().with_outputs({"motor.rho.value"}));
  EXPECT_NEAR(r.trajectory.last("motor.rho"), 1, 8 * kEps);  // rho is |AX| |AB|
}

TEST(AskedOutputs, AreRefusedWithAListOfChoices) {
  EXPECT_EQ(refusal(pendulum(), "Q"), "/outputs/0: there is no point, vector or measure 'Q'; there are: A, X, B");
  EXPECT_EQ(refusal(pendulum(), "B.z"),
            "/outputs/0: 'B' has no part 'z'; expected position, velocity, acceleration, x, y, vx, vy, ax or ay");
  EXPECT_EQ(refusal(pendulum(), "motor.tau"),
            "/outputs/0: 'motor' is a driver; an output is a point, a vector, a body, a measure or a constraint's "
            "lambda or mu");
  EXPECT_EQ(refusal(pendulum(), "motor.rho.position"),
            "/outputs/0: 'motor.rho' has no part 'position'; expected value, rate or acceleration");
  EXPECT_EQ(refusal(pendulum(), "motor.across"),
            "/outputs/0: 'motor' is a driver; an output is a point, a vector, a body, a measure or a constraint's "
            "lambda or mu");
}

TEST(AskedOutputs, AllMeansEverythingAndStandsAlone) {
  EXPECT_TRUE(sample("stewart").with_outputs({"all"}).outputs().empty());
  try {
    (void)pendulum().with_outputs({"all", "B"});
    FAIL();
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(), "/outputs/0: 'all' means everything; write it alone");
  }
  const Scene named = SceneBuilder("named", 2).fixed_point("all", {0, 0}).point("B", {1, 0}).time(0, 1, 1).build();
  EXPECT_EQ(named.with_outputs({"all"}).outputs(), std::vector<std::string>{"all"});  // "all" is a point of this scene
}

TEST(AskedOutputs, RefusesUnknownColumnsWithTheList) {
  const Simulator s = test::simulator(pendulum().with_outputs({"B"}));
  try {
    (void)s.output("B.q");
    FAIL();
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(), "no column 'B.q'; did you mean 'B.x'? There are: B.x, B.y, B.vx, B.vy, B.ax, B.ay");
  }
}

// ---- sums

SceneBuilder wheel(double omega) {
  SceneBuilder b("wheel", 2);
  b.fixed_point("A", {0, 0}).point("B", {2, 0}).drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, omega})});
  b.measure("turn", AbsoluteAngle{"A", "B"}).measure("x", MeasuredCoordinate{"B.x"});
  b.measure("reach", MeasuredDistance{"A", "B"});
  b.time(0, 4, 0.125);
  return b;
}

// The sums pi/2 - 2 turn and 1 + x - 3 reach over six turns, compared with closed forms and with the reference.
TEST(Sums, AreExactInAllDerivatives) {
  const double omega = 3 * kPi;
  const Scene scene = wheel(omega)
                          .measure("camber", Combination{{{"turn", -2.0}}, kPi / 2})
                          .measure("gap", Combination{{{"x", 1.0}, {"reach", -3.0}}, 1})
                          .output("camber")
                          .output("gap")
                          .build();
  for (const std::string strategy : {"groups/eigen", "irreducible/eigen+chunks=4", "irreducible/lanes:4+chunks=4"}) {
    const Prepared prepared = prepare(scene, {strategy});
    Simulator simulator(prepared);
    const Trajectory run = simulator.run();
    ASSERT_TRUE(simulator.report().status.ok());
    EXPECT_EQ(run.columns(),
              (std::vector<std::string>{"turn", "turn.rate", "turn.acceleration", "camber", "camber.rate",
                                        "camber.acceleration", "x", "x.rate", "x.acceleration", "reach", "reach.rate",
                                        "reach.acceleration", "gap", "gap.rate", "gap.acceleration"}));
    for (std::size_t k = 0; k < run.rows(); ++k) {
      const double t = run.times()[k], phi = omega * t;
      const auto at = [&](const char* column) { return run(k, run.index(column)); };
      EXPECT_NEAR(at("camber"), kPi / 2 - 2 * phi, 1e-13 * (1 + phi)) << strategy << " at " << t;
      EXPECT_NEAR(at("camber.rate"), -2 * omega, 1e-12) << strategy;
      EXPECT_NEAR(at("camber.acceleration"), 0, 1e-10) << strategy;
      EXPECT_NEAR(at("gap"), 1 + 2 * std::cos(phi) - 6, 1e-12) << strategy;
      EXPECT_NEAR(at("gap.rate"), -2 * omega * std::sin(phi), 1e-11) << strategy;
      EXPECT_NEAR(at("gap.acceleration"), -2 * omega * omega * std::cos(phi), 1e-10) << strategy;
    }
    if (strategy != "groups/eigen") continue;
    try {
      EXPECT_LE(forward_error(prepared, run).position, 1e-14);
      EXPECT_LE(forward_error(prepared, run).acceleration, 1e-12);
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), Error::Kind::environment) << e.what();  // no quad precision in this build
    }
  }
}

TEST(Sums, ComputeOnlyTheirTerms) {
  const Scene scene = wheel(1).measure("camber", Combination{{{"turn", -2.0}}, 1}).build();
  EXPECT_EQ(test::simulator(scene.with_outputs({"camber.rate", "turn.value"})).columns(),
            (std::vector<std::string>{"turn.rate", "camber.rate", "turn"}));
  const std::vector<std::string> all = test::simulator(scene).columns();
  EXPECT_EQ(all.back(), "camber.acceleration");
}

TEST(Sums, AreEqualInSavedPlansAndEnsembles) {
  const Scene scene = wheel(3 * kPi).measure("camber", Combination{{{"turn", -2.0}}, kPi / 2}).output("camber").build();
  const Prepared prepared = prepare(scene, {"groups/eigen"});
  const Trajectory run = Simulator(prepared).run();
  std::stringstream file;
  save_plan(file, prepared);
  EXPECT_EQ(Simulator(load_plan(file)).run().values(), run.values());
  Ensemble ensemble(5, [&](std::size_t) { return prepared; });
  const EnsembleTrajectory together = ensemble.run();
  for (std::size_t k = 0; k < run.rows(); ++k) {
    for (std::size_t c = 0; c < run.columns().size(); ++c) {
      EXPECT_NEAR(together(4, k, c), run(k, c), 1e-11) << run.columns()[c];
    }
  }
}

TEST(Sums, RefuseInvalidTerms) {
  const auto refused = [](Combination sum) {
    try {
      const Scene scene =
          wheel(1).measure("half", Combination{{{"turn", 0.5}}, 0}).measure("s", std::move(sum)).build();
      (void)prepare(scene);
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_EQ(refused({}), "/measures/s/sum: a sum needs at least one measure");
  EXPECT_EQ(refused({{{"turn", 1.0}, {"x", 1.0}}, 0}),
            "/measures/s/sum: 'turn' is in rad, 'x' in m; all measures of a sum must have the same unit");
  EXPECT_EQ(refused({{{"half", 1.0}}, 0}),
            "/measures/s/sum/0/0: 'half' is a sum itself; name the measures that it is made of");
  EXPECT_EQ(refused({{{"turn", 0.0}}, 0}),
            "/measures/s/sum/0/1: the factor is 0; a finite number other than 0 is wanted");
  EXPECT_EQ(refused({{{"torn", 1.0}}, 0}), "/measures/s/sum/0/0: there is no measure 'torn'; did you mean 'turn'?");
  EXPECT_EQ(refused({{{"turn", 1.0}}, NAN}), "/measures/s/constant: the value is nan; a finite number is wanted");
}

// ---- postures without derivatives

// B passes through A, where the distance between them has a kink.
TEST(Kinks, EventNamesTheOutputWithoutDerivative) {
  const Scene scene = SceneBuilder("through", 2)
                          .fixed_point("A", {0, 0})
                          .point("B", {1, 0})
                          .constrain("y", FixedCoordinate{"B.y", 0})
                          .drive("motor", DrivenCoordinate{"B.x", Law::polynomial({1, -1})})
                          .measure("gap", MeasuredDistance{"A", "B"})
                          .output("gap")
                          .time(0, 2, 0.5)
                          .build();
  const test::Result r = test::run(scene, "groups/eigen");
  ASSERT_FALSE(r.report().events.empty());
  EXPECT_EQ(r.report().events[0].detail,
            "there is no gap.rate, gap.acceleration: an angle without a sign has no derivatives at 0 and pi, a "
            "distance none at 0");
}

}  // namespace
}  // namespace assur
