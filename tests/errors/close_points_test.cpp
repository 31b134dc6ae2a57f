// Measures of points that pass close to each other divide by their distance; the estimated errors include this loss.
#include <gtest/gtest.h>

#include <random>

#include "numbers.hpp"
#include "simulation/run.hpp"

namespace assur {
namespace {

constexpr double kBeyond = 3;       // largest ratio of an error to its estimate
constexpr double kMeasured = 1e-9;  // smaller errors are not compared with their estimates

void expect_covered(const Scene& scene, const std::string& strategy) {
  const test::Result r = test::run(scene, strategy);
  ASSERT_TRUE(r.report().status.arrived());
  const ForwardError error = forward_error(r.simulator.prepared(), r.trajectory);
  const ErrorFigures& estimated = r.report().error;
  const double worst = std::max({error.position, error.velocity, error.acceleration});
  if (r.report().status.ok()) {
    EXPECT_LE(worst, kDoubtfulError);
  }
  EXPECT_LE(error.position, std::max(kMeasured, kBeyond * estimated.estimated_position.value()));
  EXPECT_LE(error.velocity, std::max(kMeasured, kBeyond * estimated.estimated_velocity.value()));
  EXPECT_LE(error.acceleration, std::max(kMeasured, kBeyond * estimated.estimated_acceleration.value()));
}

// At t = 1 the slider is 1e-6 from a point of its own line, and all derivatives of the direction are rounding errors.
TEST(ClosePoints, HandleASliderThatPassesAPoint) {
  SceneBuilder builder("slider", 2);
  builder.fixed_point("A", {0, 0, 0}).fixed_point("F", {1.0789035682494987, 1.438538090999332, 0});
  builder.fixed_vector("along", {0.6, 0.8, 0});
  builder.point("B", {0.5, 0, 0}).point("C", {0.95, 1.22, 0});
  builder.constrain("rod", Distance{"B", "C", 1.3}).constrain("line", OnLine{"C", "A", "along"});
  builder.drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, 1})});
  builder.measure("sight", AbsoluteAngle{"F", "C"}).output("sight").time(0, 2, 0.01);
  const Scene scene = builder.build();
  expect_covered(scene, "irreducible/lanes");
  expect_covered(scene, "groups/eigen:4+chunks=4");
  EXPECT_EQ(test::run(scene).report().status.code, Code::inaccurate);
}

// The slider passes through the point at t = 0.856, where the sense of rotation of the direction is undecidable.
TEST(ClosePoints, ReportDoubtfulTurnsIfTheyMeet) {
  const Scene scene = parse_scene(R"({"assur": 1, "name": "close", "dimension": 2,
    "points": {"A": {"at": [0, 0], "fixed": true}, "B": {"at": [0.5, 0]}, "C": {"at": [1.07, 1.43]},
               "F": {"at": [1.0789035682494987, 1.438538090999332], "fixed": true}},
    "vectors": {"d": {"at": [0.6, 0.8], "fixed": true}},
    "constraints": {"crank": {"distance": ["A", "B"], "value": 0.5}, "rod": {"distance": ["B", "C"], "value": 1.3},
                    "slide": {"on_line": ["C", "A", "d"]}},
    "drivers": {"motor": {"angle": ["A", "B"], "law": {"polynomial": [0, 1]}}},
    "measures": {"q": {"angle": ["F", "C"]}}, "outputs": ["q"], "time": {"start": 0, "end": 0.95, "step": 0.01}})");
  for (const std::string strategy : {"groups/eigen", "global/eigen+reuse=run", "irreducible/lanes", "groups/eigen:4"}) {
    SCOPED_TRACE(strategy);
    const test::Result r = test::run(scene, strategy);
    ASSERT_TRUE(r.report().status.arrived());
    EXPECT_GE(r.report().error.estimated_position, kTurn);
    const std::vector<Event>& events = r.report().events;
    ASSERT_FALSE(events.empty());
    EXPECT_EQ(events[0].kind, Code::inaccurate);
    EXPECT_GE(events[0].figure, kTurn);
    EXPECT_LT(events[0].time, 0.856);
    EXPECT_GT(events[0].until, 0.856);
    const std::size_t last = r.trajectory.rows() - 1;
    EXPECT_NEAR(std::abs(r.trajectory(last, 0) - r.trajectory(0, 0)), kTurn / 2, 1e-9);
  }
}

// Joint C of a four-bar passes a fixed point, or its coupler passes a direction, at a distance of 1e-3 to 1e-9.
TEST(ClosePoints, HandleRandomFourBars) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    const auto draw = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    const double crank = 1, coupler = draw(1.9, 2.4), rocker = draw(1.3, 1.8), ground = 2;
    const double side = draw(0, 1) < 0.5 ? -1 : 1;
    const auto at = [&](double phi, Triple& b, Triple& c) {
      b = {crank * std::cos(phi), crank * std::sin(phi), 0};
      const double dx = ground - b[0], dy = -b[1], length = std::hypot(dx, dy);
      const double along = (coupler * coupler - rocker * rocker + length * length) / (2 * length);
      const double across = side * std::sqrt(coupler * coupler - along * along);
      c = {b[0] + (along * dx - across * dy) / length, b[1] + (along * dy + across * dx) / length, 0};
    };
    const double phi = draw(-3, 3), step = std::exp(draw(std::log(0.003), std::log(0.1)));
    const int steps = static_cast<int>(1.4 / step);
    const double pass = (static_cast<int>(draw(1, steps)) + (draw(0, 1) < 0.5 ? 0 : draw(-0.5, 0.5))) * step;
    const double apart = std::pow(10, draw(-9, -3)), direction = draw(0, 6.28);
    Triple b, c, pass_b, pass_c;
    at(phi, b, c);
    at(phi + pass, pass_b, pass_c);
    const bool in_space = seed % 3 == 0;
    SceneBuilder builder("four_bar", in_space ? 3 : 2);
    builder.fixed_point("A", {0, 0, 0}).fixed_point("D", {ground, 0, 0}).point("B", b).point("C", c);
    builder.fixed_point("F", {pass_c[0] + apart * std::cos(direction), pass_c[1] + apart * std::sin(direction), 0});
    builder.constrain("BC", Distance{"B", "C", coupler}).constrain("CD", Distance{"C", "D", rocker});
    if (in_space) {
      builder.fixed_vector("n", {0, 0, 1}).constrain("flat", FixedCoordinate{"C.z", 0});
      const double dx = pass_c[0] - pass_b[0], dy = pass_c[1] - pass_b[1];
      builder.fixed_vector("e", {side * dx, side * dy, apart});
      builder.drive("motor", PointAngle{"A", "B", "n", Law::polynomial({0, 1})});
      builder.measure("sight", AngleBetween{"e", Direction("B", "C"), ""});
    } else {
      builder.drive("motor", PointAngle{"A", "B", "", Law::polynomial({phi, 1})});
      if (seed % 3 == 1) builder.measure("sight", AngleBetween{Direction("F", "C"), Direction("F", "D"), ""});
      if (seed % 3 == 2) builder.measure("sight", MeasuredDistance{"F", "C"});
    }
    expect_covered(builder.output("sight").time(0, step * steps, step).build(),
                   seed % 2 == 0 ? "groups/eigen" : "irreducible/lanes");
  }
}

}  // namespace
}  // namespace assur
