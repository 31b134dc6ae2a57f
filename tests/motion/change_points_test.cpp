// Rows of the time grid on change points: positions, velocities and accelerations of the smooth continuation.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "assur/ensemble.hpp"
#include "motion/two_sided_limit.hpp"
#include "simulation/run.hpp"

namespace assur {
namespace {

constexpr double kHalfTurn = std::numbers::pi;

Law turning(double first, double rate = kTurn) { return Law::polynomial({first, rate}); }

// Ground `ground`, crank and rocker `crank`. The branches cross where the crank is in line with the ground.
Scene parallelogram(const Law& law, double step, double end = 1, double ground = 3, double crank = 1) {
  const double first = law(0).value;
  const Triple B = {crank * std::cos(first), crank * std::sin(first), 0};
  SceneBuilder b("parallelogram", 2);
  b.fixed_point("O", {0, 0, 0}).fixed_point("D", {ground, 0, 0}).point("B", B);
  b.point("C", {B[0] + ground, B[1], 0});
  b.constrain("crank", Distance{"O", "B", crank}).constrain("coupler", Distance{"B", "C", ground});
  b.constrain("rocker", Distance{"D", "C", crank});
  b.drive("motor", PointAngle{"O", "B", "", law});
  b.measure("rocker_angle", AbsoluteAngle{"D", "C"});
  return b.time(0, end, step).build();
}

// Crank and rod of one length, as joints. C = 2 length cos(angle): on the other branch C rests in O.
Scene slider_crank(double first, double step, double end) {
  const double length = 0.7;
  SceneBuilder b("slider_crank", 2);
  b.fixed_point("O", {0, 0, 0}).point("B", {length * std::cos(first), length * std::sin(first), 0});
  b.point("C", {2 * length * std::cos(first), 0, 0}).fixed_vector("rail", {0, 1, 0});
  b.constrain("crank", Distance{"O", "B", length}).constrain("rod", Distance{"B", "C", length});
  b.constrain("guide", Dot{Direction("O", "C"), "rail", 0});
  b.drive("motor", PointAngle{"O", "B", "", turning(first, kHalfTurn / 2)});
  return b.time(0, end, step).build();
}

// The largest errors of C against B + (ground, 0), over the largest values.
struct Errors {
  double position = 0, velocity = 0, acceleration = 0;
};

Errors errors_of(const std::vector<std::string>& columns, std::span<const double> row, double ground, double rate) {
  const auto at = [&](const std::string& name) {
    return row[static_cast<std::size_t>(std::find(columns.begin(), columns.end(), name) - columns.begin())];
  };
  Errors e;
  e.position = std::hypot(at("C.x") - at("B.x") - ground, at("C.y") - at("B.y")) / (ground + 1);
  e.velocity = std::hypot(at("C.vx") - at("B.vx"), at("C.vy") - at("B.vy")) / rate;
  e.acceleration = std::hypot(at("C.ax") - at("B.ax"), at("C.ay") - at("B.ay")) / (rate * rate);
  return e;
}

Errors worst(const Trajectory& t, double ground, double rate) {
  Errors worst;
  for (std::size_t k = 0; k < t.rows(); ++k) {
    const Errors e = errors_of(t.columns(), t.row(k), ground, rate);
    worst.position = std::max(worst.position, e.position);
    worst.velocity = std::max(worst.velocity, e.velocity);
    worst.acceleration = std::max(worst.acceleration, e.acceleration);
  }
  return worst;
}

std::vector<std::string> strategies() {
  return {"groups/eigen",
          "irreducible/lanes",
          "global/" + test::sparse() + "+once",
          "irreducible/eigen+predict=past:3",
          "groups/eigen+reuse=run",
          "irreducible/eigen+predict=taylor:0",
          "irreducible/lanes+predict=hermite:5"};
}

void expect_change_points(const Report& report, const std::vector<double>& times, double step) {
  const std::vector<Event> events = test::events(report);
  ASSERT_EQ(events.size(), times.size());
  for (std::size_t i = 0; i < events.size(); ++i) {
    EXPECT_EQ(events[i].kind, Code::change_point_passed);
    EXPECT_LE(std::min(events[i].time, events[i].until), times[i]);
    EXPECT_GE(std::max(events[i].time, events[i].until), times[i]);
    EXPECT_LE(std::abs(events[i].until - events[i].time), step / 128);
  }
}

// A polynomial of degree 15 is the limit itself; its sides alone agree with it.
TEST(TwoSidedLimit, IsExactForPolynomials) {
  for (const double reach : {0.25, -3.0}) {
    std::array<double, TwoSidedLimit::kSamples> values{}, rates{};
    for (std::size_t k = 0; k < values.size(); ++k) {
      const std::size_t place = k % kLimitPlaces.size();
      const double x = (k < kLimitPlaces.size() ? -1 : 1) * kLimitPlaces[place] * reach;
      values[k] = 2 - 3 * x + x * x / 2 + 4 * x * x * x + std::pow(x / reach, 11);
      rates[k] = -3 + x + 12 * x * x + 11 * std::pow(x / reach, 10) / reach;
    }
    const TwoSidedLimit::Limit limit = TwoSidedLimit(reach).of(values, rates);
    const std::array expected = {2.0, -3.0, 1.0, 24.0};
    double unit = 1;
    for (std::size_t d = 0; d < 4; ++d, unit /= std::abs(reach)) {
      EXPECT_NEAR(limit.value[d], expected[d], 1e-10 * std::max(1.0, unit)) << d;
      if (d == 3) continue;
      EXPECT_LE(limit.error[d], 1e-10 * std::max(1.0, unit)) << d;
      EXPECT_LE(limit.gap[d], 1e-7 * std::max(1.0, unit)) << d;
    }
  }
}

// Another tool's first example: a full turn from a quarter turn on, in 100 steps. The rows at 0.25 and 0.75 are the two
// change points.
TEST(ChangePoints, HaveTheRowsOfTheSmoothContinuation) {
  for (const std::string& strategy : strategies()) {
    for (const double step : {0.01, 0.05, 0.25, 0.001}) {
      SCOPED_TRACE(strategy + " dt " + std::to_string(step));
      const test::Result r = test::run(parallelogram(turning(kHalfTurn / 2), step), strategy);
      const Report& report = r.report();
      // Rows 2 pi / 1000 rad beside a change point are in doubt: their errors are eps / sigma^3.
      EXPECT_TRUE(step < 0.01 ? report.status.arrived() : report.status.ok());
      EXPECT_EQ(r.trajectory.rows(), static_cast<std::size_t>(std::round(1 / step)) + 1);
      expect_change_points(report, {0.25, 0.75}, step);
      const Errors e = worst(r.trajectory, 3, kTurn);
      EXPECT_LE(e.position, 1e-12);
      EXPECT_LE(e.velocity, 1e-10);
      EXPECT_LE(e.acceleration, 1e-7);
      EXPECT_LE(e.position, 3 * report.error.estimated_position.value());
      EXPECT_LE(e.velocity, 3 * report.error.estimated_velocity.value());
      EXPECT_LE(e.acceleration, 3 * report.error.estimated_acceleration.value());
      const std::size_t angle = r.trajectory.index("rocker_angle");
      for (std::size_t k = 0; k < r.trajectory.rows(); ++k) {
        EXPECT_NEAR(r.trajectory(k, angle), kHalfTurn / 2 + kTurn * r.trajectory.times()[k], 1e-11) << k;
        EXPECT_NEAR(r.trajectory(k, angle + 1), kTurn, 1e-9) << k;
      }
    }
  }
}

TEST(ChangePoints, OfAnIsoscelesSliderCrank) {
  for (const std::string& strategy : strategies()) {
    SCOPED_TRACE(strategy);
    const double first = kHalfTurn / 4, rate = kHalfTurn / 2, size = 1.4;
    const test::Result r = test::run(slider_crank(first, 0.1, 3), strategy);
    EXPECT_EQ(r.report().status.code, Code::ok);
    expect_change_points(r.report(), {0.5, 2.5}, 0.1);
    const Trajectory& t = r.trajectory;
    ASSERT_EQ(t.rows(), 31u);
    const std::size_t x = t.index("C.x"), vx = t.index("C.vx"), ax = t.index("C.ax");
    for (std::size_t k = 0; k < t.rows(); ++k) {
      const double angle = first + rate * t.times()[k];
      EXPECT_NEAR(t(k, x), size * std::cos(angle), 1e-13) << k;
      EXPECT_NEAR(t(k, vx), -rate * size * std::sin(angle), 1e-11) << k;
      EXPECT_NEAR(t(k, ax), -rate * rate * size * std::cos(angle), 1e-9) << k;
    }
  }
}

// Rows at random small distances before and behind the change points, with laws of every kind.
TEST(ChangePoints, HaveRowsBesideThemWithHonestEstimates) {
  int arrived = 0, sure = 0, all = 0;
  for (const double beside :
       {0.0, 1e-15, 1e-12, -1e-12, 1e-9, -1e-9, 1e-7, -1e-7, 1e-6, -1e-6, 1e-5, -1e-5, 1e-4, -1e-4, 1e-3, -1e-3}) {
    for (const double step : {0.01, 0.05, 0.125}) {
      for (const Law& law :
           {turning(kHalfTurn - 0.25 * kTurn + beside), turning(kHalfTurn + 0.25 * kTurn + beside, -kTurn),
            Law::polynomial({kHalfTurn - 1.25 + beside, 3, 8}),
            Law::harmonics({{1.5, 0.5, 0.1}}, kHalfTurn - 1.5 * std::sin(0.25 * kHalfTurn + 0.1) + beside)}) {
        SCOPED_TRACE(std::to_string(beside * 1e6) + "e-6 dt " + std::to_string(step));
        const test::Result r = test::run(parallelogram(law, step, 0.5, 2, 0.8), "irreducible/eigen");
        ++all;
        const Report& report = r.report();
        arrived += report.status.arrived() ? 1 : 0;
        EXPECT_TRUE(report.status.arrived() || report.status.code == Code::branch_unknown);
        const Errors e = worst(r.trajectory, 2, 1);
        const double fastest = std::abs(r.trajectory.rows() > 0 ? law(0.25).rate : 1);
        if (!report.status.ok()) continue;  // a row that steps reach, so close that rounding spoils its rates
        ++sure;
        EXPECT_LE(e.position, 3 * report.error.estimated_position.value());
        EXPECT_LE(e.velocity / fastest, 10 * report.error.estimated_velocity.value());
        EXPECT_LE(e.acceleration / (fastest * fastest), 10 * report.error.estimated_acceleration.value());
      }
    }
  }
  EXPECT_GE(arrived, all - all / 20);
  EXPECT_GE(sure, all / 2);
}

// Eight rhombi in series, all singular together in a row.
TEST(ChangePoints, OfManyGroupsInOneRow) {
  for (const std::string strategy : {"groups/eigen", "irreducible/lanes:4", "global/eigen"}) {
    SCOPED_TRACE(strategy);
    const Scene rhombi = sample("n_four_bar", {{"loops", 8}, {"swing", 2}, {"steps", 12}});
    const double first = std::asin(kHalfTurn / 4);  // of pi/2 + 2 sin(t)
    const std::vector<double> times = {0, first / 2, first, (first + kHalfTurn / 2) / 2, kHalfTurn / 2};
    Simulator s = test::simulator(rhombi, strategy);
    const Trajectory t = s.run(times);
    EXPECT_TRUE(s.report().status.arrived()) << s.report().reached;
    ASSERT_EQ(t.rows(), times.size());
    for (std::size_t k = 0; k < t.rows(); ++k) {
      const double angle = kHalfTurn / 2 + 2 * std::sin(times[k]);
      for (int i = 0; i <= 8; ++i) {
        const std::size_t x = t.index("B" + std::to_string(i) + ".x");
        EXPECT_NEAR(t(k, x), i + std::cos(angle), 1e-10) << k << " " << i;
        EXPECT_NEAR(t(k, x + 1), std::sin(angle), 1e-10) << k << " " << i;
      }
    }
  }
}

// The end of a run, a step back, a saved state, and a way back on the same branch.
TEST(ChangePoints, AreLeftInBothDirections) {
  Simulator s = test::simulator(parallelogram(turning(kHalfTurn / 2), 0.05), "irreducible/eigen");
  const auto expect_right = [&] {
    const Errors e = errors_of(s.columns(), s.outputs(), 3, kTurn);
    EXPECT_LE(e.position, 1e-13) << s.time();
    EXPECT_LE(e.velocity, 1e-11) << s.time();
    EXPECT_LE(e.acceleration, 1e-9) << s.time();
  };
  for (const double t : {0.1, 0.2, 0.25, 0.2, 0.1, 0.25, 0.3}) {
    ASSERT_TRUE(s.step(t).ok()) << t;
    expect_right();
  }
  s.reset();
  ASSERT_TRUE(s.step(0.2).ok());
  ASSERT_TRUE(s.step(0.25).ok());
  const std::vector<double> here(s.outputs().begin(), s.outputs().end());
  const SimulatorState saved = s.save();
  ASSERT_TRUE(s.step(0.3).ok());
  const std::vector<double> next(s.outputs().begin(), s.outputs().end());
  s.restore(saved);
  EXPECT_EQ(std::vector<double>(s.outputs().begin(), s.outputs().end()), here);
  ASSERT_TRUE(s.step(0.3).ok());
  EXPECT_EQ(std::vector<double>(s.outputs().begin(), s.outputs().end()), next);
}

// No linear system gives the slopes there.
TEST(ChangePoints, HaveNoJacobianOfTheOutputs) {
  Simulator s = test::simulator(parallelogram(turning(kHalfTurn / 2), 0.05), "irreducible/eigen", {}, {"motor"});
  s.set("motor", kHalfTurn, 6, 0);
  ASSERT_TRUE(s.step(0.25).ok());
  EXPECT_LE(errors_of(s.columns(), s.outputs(), 3, kTurn).acceleration, 1e-9);
  EXPECT_EQ(s.jacobian().status.code, Code::singular);
  s.set("motor", kHalfTurn + 0.3, 6, 0);
  ASSERT_TRUE(s.step(0.3).ok());
  EXPECT_LE(errors_of(s.columns(), s.outputs(), 3, kTurn).acceleration, 1e-9);
  EXPECT_TRUE(s.jacobian().status.ok());
}

// A driver that comes to rest there says nothing about the branch.
TEST(ChangePoints, OfDriversAtRestAreUndecidable) {
  Simulator s = test::simulator(parallelogram(turning(kHalfTurn / 2), 0.05), "irreducible/eigen", {}, {"motor"});
  s.set("motor", kHalfTurn);
  EXPECT_EQ(s.step(0.25).code, Code::branch_unknown);
}

// Runs in chunks, in lanes and as rows for a sink have the rows of the plain run.
TEST(ChangePoints, AreTheSameInChunksEnsemblesAndStreams) {
  const Scene scene = parallelogram(turning(kHalfTurn / 2), 0.0125);
  const test::Result plain = test::run(scene, "groups/eigen");
  ASSERT_TRUE(plain.report().status.ok());
  const auto expect_same = [&](std::span<const double> a, std::span<const double> b, std::size_t k) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t c = 0; c < a.size(); ++c) EXPECT_NEAR(a[c], b[c], 1e-9 * (1 + std::abs(b[c]))) << k << " " << c;
  };
  for (const int chunks : {2, 4, 7}) {
    SCOPED_TRACE(chunks);
    Simulator s(prepare(scene, {"groups/eigen:4+chunks=" + std::to_string(chunks) + " 1x1"}));
    const Trajectory t = s.run();
    EXPECT_TRUE(s.report().status.arrived());
    ASSERT_EQ(t.rows(), plain.trajectory.rows());
    for (std::size_t k = 0; k < t.rows(); ++k) expect_same(t.row(k), plain.trajectory.row(k), k);
    EXPECT_EQ(test::events(s.report()).size(), 2u);
  }

  const std::size_t members = 6;
  const auto member = [&](std::size_t i) {
    // Members 0 and 3 have rows on their change points.
    return prepare(parallelogram(turning(kHalfTurn / 2 + (i % 3 == 0 ? 0 : 0.01 * static_cast<double>(i))), 0.0125),
                   {"groups/eigen:4"});
  };
  Ensemble ensemble(members, member);
  const EnsembleTrajectory all = ensemble.run();
  for (const std::size_t i : {0u, 3u}) {
    EXPECT_TRUE(ensemble.outcomes()[i].status.ok());
    ASSERT_EQ(all.rows(i), plain.trajectory.rows());
    for (std::size_t k = 0; k < all.rows(i); ++k) expect_same(all.row(i, k), plain.trajectory.row(k), k);
    EXPECT_EQ(ensemble.outcomes()[i].events.size(), 2u);
  }
  for (const std::size_t i : {1u, 2u, 4u, 5u}) EXPECT_EQ(all.rows(i), plain.trajectory.rows());

  Simulator s(prepare(scene, {"groups/eigen"}));
  std::vector<double> streamed;
  s.stream({},
           [&](const MemberRows& rows) { streamed.insert(streamed.end(), rows.values.begin(), rows.values.end()); });
  ASSERT_EQ(streamed.size(), plain.trajectory.rows() * plain.trajectory.columns().size());
  for (std::size_t k = 0; k < plain.trajectory.rows(); ++k) {
    expect_same(std::span(streamed).subspan(k * plain.trajectory.columns().size(), plain.trajectory.columns().size()),
                plain.trajectory.row(k), k);
  }
}

// A row exactly at a fold: the motion ends there.
TEST(ChangePoints, AreNoFolds) {
  const double longest = std::sqrt(2.6);
  SceneBuilder b("fold", 2);
  b.fixed_point("O", {0, 0, 0}).fixed_point("A", {2, 0, 0}).point("P", {0.6, 0.8, 0});
  b.constrain("circle", Distance{"O", "P", 1});
  b.drive("push", DrivenDistance{"A", "P", Law::polynomial({longest, 1 - longest})});
  const Scene scene = b.time(0, 2, 0.125).build();
  for (const std::string& strategy : strategies()) {
    SCOPED_TRACE(strategy);
    const test::Result r = test::run(scene, strategy);
    EXPECT_EQ(r.report().status.code, Code::fold);
    ASSERT_FALSE(r.report().events.empty());
    EXPECT_NEAR(r.report().events.back().time, 1, 1e-8);
    EXPECT_GE(r.report().events.back().until, 1);
    for (const Event& e : r.report().events) EXPECT_NE(e.kind, Code::change_point_passed);
  }
}

}  // namespace
}  // namespace assur
