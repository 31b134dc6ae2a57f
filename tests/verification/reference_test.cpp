// The reference in quad: its motion compared with closed forms and independent equations, and the errors it reports.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "errors/deviation.hpp"
#include "plan/preparation.hpp"
#include "references/planar.hpp"
#include "references/stewart.hpp"
#include "references/tables.hpp"
#include "verification/reference_motion.hpp"

namespace assur {
namespace {

using namespace references;  // NOLINT: the whole file is about them
using test::Deviation;

// The reference stops after a correction below 1e-22 of the posture. Accelerations (up to 40 1/s^2 times the lengths)
// amplify the remaining error. Doubles cannot reach this accuracy.
constexpr double kExact = 1e-20;

Vec<QuadJet> place(const ReferenceMotion& motion, const std::string& name) {
  const System& s = motion.system();
  const Item& item = s.item(name);
  Vec<QuadJet> out{};
  for (std::size_t k = 0; k < static_cast<std::size_t>(item.components); ++k) {
    const auto of = [&](std::size_t d) { return form_value<Quad>(s, item.form[k], motion.state().q[d]); };
    out[k] = QuadJet{of(0), of(1), of(2)} * Quad(s.unit(item.dimension));
  }
  return out;
}

double magnitude(const QuadJet& x) {
  return std::max({std::abs(static_cast<double>(x.value)), std::abs(static_cast<double>(x.rate)),
                   std::abs(static_cast<double>(x.acceleration))});
}

void expect_on(const Posture<QuadJet>& closed_form, const ReferenceMotion& motion) {
  ASSERT_FALSE(closed_form.empty());
  for (const auto& [name, at] : closed_form) {
    const Vec<QuadJet> off = place(motion, name) - at;
    for (const QuadJet& x : off) EXPECT_LE(magnitude(x), kExact) << name << " at t = " << motion.state().time;
  }
}

// Every equation of the scene and its two derivatives hold.
void expect_satisfied(const Scene& scene, const ReferenceMotion& motion) {
  Posture<QuadJet> posture = at_guess<QuadJet>(scene);
  for (const Point& p : scene.points()) posture[p.name] = place(motion, p.name);
  for (const Vector& v : scene.vectors()) posture[v.name] = place(motion, v.name);
  Equations<QuadJet> equations(scene, posture);
  equations.drive([&](const Law& law) { return evaluate<Quad>(law, Quad(motion.state().time)); });
  ASSERT_FALSE(equations.left().empty());
  for (const Left<QuadJet>& left : equations.left()) {
    EXPECT_LE(magnitude(left.value), 100 * kExact) << left.equation << " at t = " << motion.state().time;
  }
}

// ---- the motion

TEST(ReferenceMotion, FollowsTheFourBarChainThroughFullTurns) {
  for (const char* strategy : {"global/eigen", "irreducible/eigen"}) {
    ReferenceMotion motion(prepare(sample("four_bar:3"), {strategy, {}}));
    for (const double t : {0.0, 0.01, 0.02, 0.5, 0.4, 1.25, 2.0}) {  // large steps, forwards and backwards
      motion.advance(t);
      expect_on(four_bar_chain(3, t), motion);
    }
  }
}

TEST(ReferenceMotion, FollowsTheSliderCrank) {
  ReferenceMotion motion(prepare(sample("slider_crank:offset=0.02")));
  for (const double t : {0.0, 0.3, 0.77}) {
    motion.advance(t);
    expect_on(slider_crank(0.02, t), motion);
  }
}

TEST(ReferenceMotion, FollowsTheStewartPlatformInEveryFormulation) {
  const Scene scene = sample("stewart");
  for (const char* strategy : {"global/eigen", "groups/eigen", "irreducible/eigen"}) {
    ReferenceMotion motion(prepare(scene, {strategy, {}}));
    for (const double t : {0.0, 0.01, 3.3}) {
      motion.advance(t);
      expect_on(stewart(scene, t), motion);
      expect_satisfied(scene, motion);
    }
  }
}

// Within a step of 0.01 s the motion passes a posture where the wrong branch is 1e-4 m away.
TEST(ReferenceMotion, StaysOnTheBranchOfTheAlmostParallelogram) {
  ReferenceMotion motion(prepare(sample("almost_parallelogram:delta=1e-8")));
  for (int k = 0; k <= 100; ++k) motion.advance(0.01 * k);
  const Vec<QuadJet> off = place(motion, "B1") - almost_parallelogram(1e-8, 1.0).at("B1");
  for (const QuadJet& x : off) EXPECT_LE(std::abs(static_cast<double>(x.value)), 1e-15);  // 1e-22 * condition
}

TEST(ReferenceMotion, SatisfiesTheEquationsOfAndrewsSqueezer) {
  const Scene scene = sample("andrews");
  ReferenceMotion motion(prepare(scene));
  for (std::int64_t k = 0; k <= 72; k += 8) {
    motion.advance(scene.time().time(k));
    expect_satisfied(scene, motion);
  }
}

TEST(ReferenceMotion, SatisfiesTheEquationsOfEveryGoughPosture) {
  for (const GoughRow& row : read_gough()) {
    const Scene scene = sample("gough:posture=" + std::to_string(row.posture));
    expect_satisfied(scene, ReferenceMotion(prepare(scene)));
  }
}

// The lengths of the rings stay as they are at the start, where they are rounded once.
TEST(ReferenceMotion, KeepsTheLengthsOfRings) {
  const Scene scene = sample("rings:legs=2,n=240");  // sparse blocks
  ReferenceMotion motion(prepare(scene));
  const auto square = [&](const Constraint& c) {
    const auto& link = *c.as<Distance>();
    const Vec<QuadJet> d = place(motion, link.q) - place(motion, link.p);
    return dot(d, d);
  };
  std::vector<QuadJet> start;
  for (const Constraint& c : scene.constraints()) start.push_back(square(c));
  motion.advance(0.7);
  for (std::size_t i = 0; i < start.size(); ++i) {
    QuadJet now = square(scene.constraints()[i]);
    now.value = now.value - start[i].value;
    EXPECT_LE(magnitude(now), 100 * kExact) << scene.constraints()[i].name;
  }
}

// One redundant equation is not solved, but it holds as exactly as the others.
TEST(ReferenceMotion, LeavesOutRedundantEquations) {
  const Scene scene = sample("bricard:middle=0,swing=0.5");
  const Prepared prepared = prepare(scene);
  ASSERT_EQ(preparation(prepared).structure->checks.size(), 1U);
  ReferenceMotion motion(prepared);
  motion.advance(1.3);
  for (int i = 0; i < 6; ++i) {
    const Vec<QuadJet> rod = place(motion, "P" + std::to_string((i + 1) % 6)) - place(motion, "P" + std::to_string(i));
    EXPECT_LE(magnitude(dot(rod, rod) - QuadJet{1}), 100 * kExact) << "rod " << i;
    const Vec<QuadJet> axis = place(motion, "u" + std::to_string(i));
    EXPECT_LE(magnitude(dot(rod, axis)), 100 * kExact) << "rod " << i;
  }
}

TEST(ReferenceMotion, NamesTheTimeOfAFailure) {
  // Coupler and rocker only reach the end of the crank up to x = 2.1.
  const Scene scene = SceneBuilder("stretched", 2)
                          .fixed_point("A", {0, 0, 0})
                          .point("P", {1, 0, 0})
                          .point("Q", {0.5, 0.8, 0})
                          .constrain("near", Distance{"A", "Q", 1.0})
                          .constrain("far", Distance{"Q", "P", 1.1})
                          .drive("slide", DrivenCoordinate{"P.x", Law::polynomial({1, 1})})
                          .drive("level", DrivenCoordinate{"P.y", Law::constant(0)})
                          .time(0, 1, 0.1)
                          .build();
  ReferenceMotion motion(prepare(scene));
  try {
    motion.advance(1.2);
    FAIL() << "there is no posture at x = 2.2";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::numerical);
    EXPECT_NE(std::string(error.what()).find("Q.x"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("t = 1."), std::string::npos) << error.what();
  }
}

// ---- the figures

// Both figures use the same norms, except for rates of nearly resting outputs, so they agree up to a factor of two.
void expect_about(const ForwardError& figures, const Motion& deviation) {
  const auto about = [](double a, double b) { return a <= 2 * b && b <= 2 * a; };
  EXPECT_TRUE(about(figures.position, deviation.value)) << figures.position << " for " << deviation.value;
  EXPECT_TRUE(about(figures.velocity, deviation.rate)) << figures.velocity << " for " << deviation.rate;
  EXPECT_TRUE(about(figures.acceleration, deviation.acceleration))
      << figures.acceleration << " for " << deviation.acceleration;
}

Motion deviation(const Prepared& prepared, const Trajectory& trajectory,
                 const std::function<Posture<QuadJet>(double)>& closed_form) {
  Deviation out(trajectory, preparation(prepared).structure->system->unit(1));
  for (std::size_t k = 0; k < trajectory.rows(); ++k) {
    for (const auto& [name, at] : closed_form(trajectory.times()[k])) {
      if (name.find('.') == std::string::npos) out.add(k, name, at);
    }
  }
  return out.worst();
}

TEST(ForwardError, AgreesWithTheClosedFormOfAFourBarChain) {
  for (const std::string& solver : test::solvers()) {
    const Prepared prepared = prepare(sample("four_bar:3"), {"groups/" + solver, {}});
    const Trajectory trajectory = Simulator(prepared).run();
    expect_about(forward_error(prepared, trajectory),
                 deviation(prepared, trajectory, [](double t) { return four_bar_chain(3, t); }));
  }
}

// tEnd2 = 1 of the paper with a predictor that is too inaccurate for a single iteration.
TEST(ForwardError, FindsTheErrorOfTooFewIterations) {
  const Scene scene = sample("stewart").with_time({0, 0.5, 0.01});
  const Prepared prepared = prepare(scene, {"groups/eigen+predict=taylor:0", {}});
  StepSettings settings;
  settings.iterations = 1;
  const Trajectory trajectory = Simulator(prepared, settings).run();
  const ForwardError found = forward_error(prepared, trajectory);
  EXPECT_GT(found.position, 1e-7);
  expect_about(found, deviation(prepared, trajectory, [&](double t) { return stewart(scene, t); }));
}

// A trajectory of another mechanism with the same columns: the slider is off by 0.02 m.
TEST(ForwardError, ReportsTheErrorOfAnotherMotion) {
  const Prepared prepared = prepare(sample("slider_crank:offset=0.03").with_outputs({"C"}));
  const Trajectory other = test::run(sample("slider_crank:offset=0.01").with_outputs({"C"})).trajectory;
  expect_about(forward_error(prepared, other),
               deviation(prepared, other, [](double t) { return slider_crank(0.03, t); }));
}

// A mirrored guess starts the same four-bar in its other assembly mode.
TEST(ForwardError, ReportsTheErrorOfAnotherBranch) {
  const auto four_bar = [](double side) {
    return SceneBuilder("four_bar", 2)
        .fixed_point("A", {0, 0, 0})
        .fixed_point("D", {2, 0, 0})
        .point("B", {0.8, 0, 0})
        .point("C", {1.6, 1.2 * side, 0})
        .constrain("coupler", Distance{"B", "C", 1.8})
        .constrain("rocker", Distance{"D", "C", 1.3})
        .drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, 6.25})})
        .output("C.position")
        .time(0, 1, 0.01)
        .build();
  };
  const Prepared above = prepare(four_bar(1));
  const Trajectory below = test::run(four_bar(-1)).trajectory;
  const ForwardError found = forward_error(above, below);
  EXPECT_GT(found.position,
            1.0);  // C is up to 1.3 m above, and as far below: at most twice its largest coordinate
  EXPECT_LE(found.position, 2.0);
  EXPECT_TRUE(std::isnan(found.velocity));  // the columns have no velocities
  EXPECT_TRUE(std::isnan(found.acceleration));
}

TEST(ForwardError, HandlesTimesFarApart) {
  const Prepared prepared = prepare(sample("stewart"));
  Simulator simulator(prepared);
  const std::vector<double> times = {1.5, 4.0, 4.001, 9.0};
  const ForwardError found = forward_error(prepared, simulator.run(times));
  EXPECT_LE(found.position, 1e-13);
  EXPECT_LE(found.velocity, 1e-12);
  EXPECT_LE(found.acceleration, 1e-11);
}

// The bounds that this library promises for a thousand steps of the paper's platform.
TEST(ForwardError, IsSmallForTheStewartPlatformWithEverySolver) {
  for (const std::string& solver : test::solvers()) {
    for (const char* formulation : {"global/", "groups/", "irreducible/"}) {
      const Prepared prepared = prepare(sample("stewart"), {formulation + solver, {}});
      const Trajectory trajectory = Simulator(prepared).run();
      ASSERT_EQ(trajectory.rows(), 1001U);
      const ForwardError found = forward_error(prepared, trajectory);
      EXPECT_LE(found.position, 1e-13) << formulation << solver;
      EXPECT_LE(found.velocity, 1e-12) << formulation << solver;
      EXPECT_LE(found.acceleration, 1e-11) << formulation << solver;
      EXPECT_GT(found.position, 1e-17) << "no result in double is exact";
    }
  }
}

// The backward error is eight roundings. The condition (5 to 16 for every ring) counts twice, because the terminal
// passes its error on to the legs.
TEST(ForwardError, OfRingsFollowsTheirCondition) {
  const Prepared prepared = prepare(sample("rings:legs=3,n=12").with_time({0, 1, 0.01}));
  const ForwardError found = forward_error(prepared, Simulator(prepared).run());
  EXPECT_LE(found.position, 8 * kEps * 16 * 17);
}

TEST(ForwardError, OfGoughPosturesFollowsTheirCondition) {
  for (const GoughRow& row : read_gough()) {
    const Prepared prepared = prepare(sample("gough:posture=" + std::to_string(row.posture)));
    const ForwardError found = forward_error(prepared, Simulator(prepared).run());
    EXPECT_LE(found.position, row.condition * 1e-15) << "posture " << row.posture;
    EXPECT_EQ(found.velocity, 0) << "nothing moves";
  }
}

// A callback computes in double. The circle is written as a callback, and as a constraint of the library.
TEST(ForwardError, HandlesCallbacks) {
  Callback circle;
  circle.coordinates = {"P.x", "P.y"};
  circle.equations = 1;
  circle.residual = [](std::span<const double> x, std::span<double> phi) { phi[0] = x[0] * x[0] + x[1] * x[1] - 1; };
  circle.jacobian = [](std::span<const double> x, std::span<double> j) {
    j[0] = 2 * x[0];
    j[1] = 2 * x[1];
  };
  circle.curvature = [](std::span<const double>, std::span<const double> rate, std::span<double> c) {
    c[0] = 2 * (rate[0] * rate[0] + rate[1] * rate[1]);
  };
  const auto swing = Law::harmonics({{0.6, 1.0, 0}});
  const Scene scene = SceneBuilder("circle", 2)
                          .point("P", {1, 0, 0})
                          .constrain("circle", circle)
                          .drive("lift", DrivenCoordinate{"P.y", swing})
                          .time(0, 1, 0.01)
                          .build();
  ReferenceMotion motion(prepare(scene));
  motion.advance(0.3);
  const QuadJet y = evaluate<Quad>(swing, Quad(0.3));
  const QuadJet off = place(motion, "P")[0] - sqrt(QuadJet{1} - y * y);
  // Two roundings of the residual are divided by its derivative 2x >= 1.6. The acceleration amplifies them by the
  // square of the driver's 2 pi 1/s.
  EXPECT_LE(magnitude(off), 2 * kEps * std::pow(2 * std::numbers::pi, 2));

  const Prepared prepared = prepare(scene);
  EXPECT_LE(forward_error(prepared, Simulator(prepared).run()).position, 8 * kEps);
}

// An angle that starts with another number of turns is not an error.
TEST(ForwardError, HandlesAnglesOverManyTurns) {
  const Scene scene = sample("andrews").with_outputs({"beta"});
  const TimeGrid grid = scene.time();
  const Prepared prepared = prepare(scene.with_time({0, 200 * grid.step, grid.step}));
  const Trajectory trajectory = Simulator(prepared).run();
  ASSERT_GT(trajectory.last("beta"), 17.0);  // rad; 200 rows are 200 / 72 turns
  EXPECT_LE(forward_error(prepared, trajectory).position, kEps);
}

TEST(ForwardError, RefusesIncomparableTrajectories) {
  const Prepared prepared = prepare(sample("four_bar:1"));
  const auto message = [&](const Trajectory& trajectory) -> std::string {
    try {
      (void)forward_error(prepared, trajectory);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), Error::Kind::input);
      return error.what();
    }
    return "no error";
  };
  EXPECT_NE(message(test::run(sample("four_bar:2")).trajectory)
                .find("the columns of the trajectory are not those of the scene"),
            std::string::npos);
  EXPECT_NE(message(Simulator(prepared).run(std::vector<double>{})).find("no row"), std::string::npos);
}

}  // namespace
}  // namespace assur
