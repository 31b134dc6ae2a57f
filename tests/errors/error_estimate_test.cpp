// The estimated error compared with the true error in quad precision.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "assur/ensemble.hpp"
#include "motion/fan.hpp"
#include "properties/near_singular.hpp"
#include "properties/random_count.hpp"
#include "runs/ensembles.hpp"
#include "simulation/run.hpp"

namespace assur {
namespace {

using test::Result;

ForwardError estimated(const Report& report) {
  return {report.error.estimated_position.value(), report.error.estimated_velocity.value(),
          report.error.estimated_acceleration.value()};
}

double worst(const ForwardError& e) { return std::max({e.position, e.velocity, e.acceleration}); }

const std::vector<std::string>& moving_samples() {
  static const std::vector<std::string> kSamples = {"stewart:steps=100",
                                                    "andrews",
                                                    "slider_crank",
                                                    "four_bar:20",
                                                    "n_four_bar:10",
                                                    "rings:legs=2,n=24,steps=100",
                                                    "almost_parallelogram:delta=1e-3",
                                                    "hexapod"};
  return kSamples;
}

// Roundings are half as large as their bounds and rarely all of one sign, so the estimate is larger than the error.
// Numbers such as 1 and 2, which are exact, increase the ratio.
TEST(ErrorEstimate, IsNearTheTruth) {
  for (const std::string& text : moving_samples()) {
    for (const std::string strategy : {"irreducible/eigen", "groups/eigen:4+once", "global/eigen+float",
                                       "irreducible/lanes:8", "groups/eigen+reuse=run+predict=past:3"}) {
      SCOPED_TRACE(text + " " + strategy);
      const Scene scene = sample(text);
      const Result r = test::run(scene, strategy);
      ASSERT_TRUE(r.report().status.ok());
      const ForwardError truth = forward_error(r.simulator.prepared(), r.trajectory), guess = estimated(r.report());
      for (const auto figure : {&ForwardError::position, &ForwardError::velocity, &ForwardError::acceleration}) {
        EXPECT_LE(truth.*figure, 4 * guess.*figure);
        EXPECT_LE(guess.*figure, 1000 * std::max(truth.*figure, kEps));
      }
    }
  }
}

// Fixed numbers of iterations leave residuals, which the estimate includes.
TEST(ErrorEstimate, SeesTheResidualOfNewtonsMethod) {
  for (const std::string strategy : {"groups/eigen+predict=taylor:0", "irreducible/lanes:4+predict=taylor:1"}) {
    const Result r = test::run(sample("stewart:steps=50"), strategy, {.iterations = 1});
    const ForwardError truth = forward_error(r.simulator.prepared(), r.trajectory), guess = estimated(r.report());
    EXPECT_GT(truth.position, 1e-12);
    EXPECT_LE(truth.position, 4 * guess.position);
    EXPECT_LE(guess.position, 100 * truth.position);
    EXPECT_LE(truth.acceleration, 4 * guess.acceleration);
  }
}

// Two bars at rest, nearly in line, and optionally a crank that turns about their joint.
Scene standing_bars(double missed, bool crank) {
  const double coupler = 1.1, rocker = 0.7, ground = (coupler + rocker) * (1 - missed);
  const double along = (coupler * coupler - rocker * rocker + ground * ground) / (2 * ground);
  SceneBuilder b("standing", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("D", {ground, 0, 0});
  b.point("C", {along, std::sqrt(coupler * coupler - along * along), 0});
  b.constrain("coupler", Distance{"A", "C", coupler}).constrain("rocker", Distance{"C", "D", rocker});
  if (crank) {
    b.point("E", {along + 0.5, 0, 0}).constrain("crank", Distance{"C", "E", 0.5});
    b.drive("motor", PointAngle{"C", "E", "", Law::polynomial({0, 1})});
  }
  return b.time(0, 1, 0.25).build();
}

constexpr double kBetween = 4e-10;  // between the errors at `missed` = 1e-11 and 1e-12

TEST(ErrorEstimate, CoversMechanismsAtRest) {
  for (const bool crank : {false, true}) {
    for (double missed = 0.1; missed > 1e-13; missed /= 10) {
      SCOPED_TRACE(std::to_string(std::log10(missed)) + (crank ? ", with a crank" : ""));
      const Prepared p = prepare(standing_bars(missed, crank), {.strategy = "irreducible/eigen", .accuracy = kBetween});
      Simulator s(p);
      const Trajectory rows = s.run();
      const ForwardError truth = forward_error(p, rows), guess = estimated(s.report());
      EXPECT_LE(truth.position, 4 * guess.position);
      EXPECT_LE(guess.position, 20 * kEps / std::sqrt(missed));
      EXPECT_EQ(s.report().status.code, missed < 5e-12 ? Code::inaccurate : Code::ok) << guess.position;
    }
  }
  const Result gough = test::run(sample("gough"), "irreducible/eigen");
  const double truth = forward_error(gough.simulator.prepared(), gough.trajectory).position;
  EXPECT_LE(truth, 4 * estimated(gough.report()).position);
  EXPECT_LE(estimated(gough.report()).position, 1000 * truth);
}

TEST(ErrorEstimate, IsEqualForAllThreads) {
  const Scene scene = sample("rings:legs=6,n=24,steps=20");
  const Result one = test::run(scene, "groups/eigen"), two = test::run(scene, "groups/eigen 2x1");
  EXPECT_EQ(worst(estimated(one.report())), worst(estimated(two.report())));
}

TEST(ErrorEstimate, DoesNotChangeTheMotion) {
  // The error is measured in every step, or hardly ever.
  const Scene scene = sample("stewart:steps=40");
  const Result seldom = test::run(scene, "groups/eigen");
  Simulator often = test::simulator(scene, "groups/eigen");
  for (std::size_t k = 0; k < seldom.trajectory.rows(); ++k) {
    ASSERT_TRUE(often.step(scene.time().time(static_cast<std::int64_t>(k))).ok());
    (void)often.examine();
    const auto row = seldom.trajectory.row(k);
    ASSERT_TRUE(std::equal(row.begin(), row.end(), often.outputs().begin())) << k;
  }
}

// For random mechanisms, near the origin and up to 1e7 lengths from it, 99 of 100 errors are at most three times the
// estimate, and no doubt is unfounded.
TEST(ErrorEstimate, IsHonestForRandomMechanisms) {
  test::Draw draw(11);
  const std::vector<std::string> strategies = {"irreducible/eigen", "global/eigen", "irreducible/lanes",
                                               "groups/" + test::sparse()};
  std::vector<double> ratios;
  int runs = 0, doubted = 0, needless = 0;
  const int all = test::random_count(200);
  for (int i = 0; i < all; ++i) {
    const double far = draw.below(3) == 0 ? 0 : std::pow(10, draw.real(0, 7));
    Triple origin;
    for (Number& x : origin) x = far * draw.real(-1, 1);
    const Scene scene = draw.maybe() ? test::planar_mechanism(draw, origin) : test::spatial_mechanism(draw, origin);
    try {
      const Prepared p = prepare(scene, {.strategy = draw.of(strategies)});
      Simulator s(p);
      const Trajectory rows = s.run();
      if (!s.report().status.arrived()) continue;
      const ForwardError truth = forward_error(p, rows), guess = estimated(s.report());
      ++runs;
      for (const auto figure : {&ForwardError::position, &ForwardError::velocity, &ForwardError::acceleration}) {
        ratios.push_back(truth.*figure / guess.*figure);
      }
      if (s.report().status.ok()) continue;
      ++doubted;
      needless += worst(truth) < kDoubtfulError / 10 ? 1 : 0;
    } catch (const Error& e) {
      EXPECT_NE(e.kind(), Error::Kind::input) << e.what();
    }
  }
  std::sort(ratios.begin(), ratios.end());
  const auto quantile = [&](double share) {
    return ratios[static_cast<std::size_t>(share * static_cast<double>(ratios.size() - 1))];
  };
  std::printf(
      "%d runs: true over estimated error 1 %%: %.2g, median %.2g, 90 %%: %.2g, 99 %%: %.2g, largest %.2g; "
      "%d in doubt, %d of them without reason\n",
      runs, quantile(0.01), quantile(0.5), quantile(0.9), quantile(0.99), quantile(1), doubted, needless);
  ASSERT_GT(runs, all * 9 / 10);
  EXPECT_LE(quantile(0.99), 3);
  EXPECT_GE(quantile(0.5), 0.03);
  EXPECT_LE(needless, all / 1000);
}

// ---- the required accuracy

TEST(Accuracy, IsReached) {
  for (const std::string& text : moving_samples()) {
    for (const std::string strategy : {"irreducible/eigen", "groups/eigen+once", "irreducible/lanes:8"}) {
      const std::int64_t all = test::run(sample(text), strategy).counters().newton_iterations;
      for (const double asked : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
        SCOPED_TRACE(text + " " + strategy + " " + std::to_string(std::log10(asked)));
        const Prepared p = prepare(sample(text), {.strategy = strategy, .accuracy = asked});
        Simulator s(p);
        const Trajectory rows = s.run();
        ASSERT_TRUE(s.report().status.arrived());
        if (asked >= 1e-10) {
          EXPECT_TRUE(s.report().status.ok());
        }
        EXPECT_LE(worst(forward_error(p, rows)), asked);
        EXPECT_LE(s.report().counters.newton_iterations, all);
      }
    }
  }
}

// Redundant equations hold only as accurately as the other equations are solved.
TEST(Accuracy, IsReachedWithRedundantEquations) {
  for (const std::string text : {"bricard:steps=200", "parallelograms:3", "parallelograms:5"}) {
    for (const std::string strategy : {"irreducible/eigen", "irreducible/lanes:8", "global/eigen"}) {
      for (const double asked : {1e-4, 1e-6, 1e-8, 1e-10}) {
        SCOPED_TRACE(text + " " + strategy + " " + std::to_string(std::log10(asked)));
        const Prepared p = prepare(sample(text), {.strategy = strategy, .accuracy = asked});
        Simulator s(p);
        const Trajectory rows = s.run();
        EXPECT_TRUE(s.report().status.ok()) << name(s.report().status.code);
        EXPECT_EQ(rows.rows(), static_cast<std::size_t>(p.time().steps()) + 1);
        EXPECT_LE(worst(forward_error(p, rows)), asked);
      }
    }
  }
}

TEST(Accuracy, LowerAccuracySavesWork) {
  const auto iterations = [](double asked) {
    Simulator s(prepare(sample("stewart:steps=100"), {.strategy = "irreducible/eigen", .accuracy = asked}));
    s.run();
    return s.report().counters.newton_iterations;
  };
  EXPECT_LT(2 * iterations(1e-6), iterations(1e-12));
}

TEST(Accuracy, ReportsUnreachableAccuracy) {
  const Prepared p = prepare(sample("four_bar:20"), {.strategy = "irreducible/eigen", .accuracy = 1e-15});
  Simulator s(p);
  const Trajectory rows = s.run();
  EXPECT_EQ(rows.rows(), 1001u);
  EXPECT_EQ(s.report().status.code, Code::inaccurate);
  ASSERT_FALSE(s.report().events.empty());
  const Event& e = s.report().events.front();
  EXPECT_EQ(e.kind, Code::inaccurate);
  EXPECT_GT(e.figure, 1e-15);
  EXPECT_FALSE(e.group.empty());
  EXPECT_GT(s.report().error.estimated_position.value(), 1e-15);
  EXPECT_THROW((void)prepare(sample("stewart"), {.accuracy = -1}), Error);
  EXPECT_THROW((void)prepare(sample("stewart"), {.accuracy = std::nan("")}), Error);
}

// A doubt stays with the run, even if later steps are accurate.
TEST(Accuracy, KeepsADoubtUntilItIsMeasuredAgain) {
  const Scene scene = sample("almost_parallelogram:delta=1e-12,step=0.01,steps=100");
  Simulator s = test::simulator(scene, "global/eigen+predict=taylor:2");
  Status worst, last;
  for (std::int64_t k = 0; k <= 100; ++k) {
    last = s.step(scene.time().time(k));
    ASSERT_TRUE(last.arrived());
    if (worst.ok()) worst = last;
  }
  EXPECT_TRUE(last.ok());
  EXPECT_EQ(worst.code, Code::inaccurate);
  EXPECT_EQ(s.report().status.code, Code::inaccurate);
  ASSERT_EQ(s.report().events.size(), 2u);  // twice in a turn a row lies on the most singular posture
  s.reset();
  EXPECT_TRUE(s.report().status.ok());
}

// Errors measured by examine() count as well: if they exceed the required accuracy, the status says so.
TEST(Accuracy, ExaminedErrorsCount) {
  const Scene scene = sample("almost_parallelogram:delta=1e-9,step=0.01,steps=100");
  Simulator s(prepare(scene, {.strategy = "global/eigen+predict=taylor:2", .accuracy = 1e-8}));
  bool doubted = false;
  for (std::int64_t k = 0; k <= 100; ++k) {
    ASSERT_TRUE(s.step(scene.time().time(k)).arrived());
    (void)s.examine();
    if (worst(estimated(s.report())) > 1e-8) {
      ASSERT_EQ(s.report().status.code, Code::inaccurate) << k;
      doubted = true;
    }
  }
  EXPECT_TRUE(doubted);
}

// ---- ensembles and chunks

// The doubt of a member does not depend on its neighbours.
TEST(Accuracy, AppliesToEachMemberOfAnEnsemble) {
  const std::vector<std::string> deltas = {"1e-3", "1e-12", "1e-2", "1e-4", "1e-12"};
  const auto member = [&](std::size_t i) {
    const Scene scene = sample("almost_parallelogram:delta=" + deltas[i] + ",step=0.01,steps=100");
    return prepare(scene, {.strategy = "global/eigen:4+predict=taylor:2"});
  };
  Ensemble e(deltas.size(), member);
  (void)e.run();
  double estimated_position = 0;
  for (std::size_t i = 0; i < deltas.size(); ++i) {
    SCOPED_TRACE(deltas[i]);
    Simulator lone(member(i));
    lone.run();
    const Ensemble::Outcome& o = e.outcomes()[i];
    EXPECT_EQ(o.status.code, deltas[i] == "1e-12" ? Code::inaccurate : Code::ok);
    EXPECT_EQ(o.status.code, lone.report().status.code);
    ASSERT_EQ(o.events.size(), lone.report().events.size());
    for (std::size_t n = 0; n < o.events.size(); ++n) {
      const Event &mine = o.events[n], &theirs = lone.report().events[n];
      EXPECT_EQ(mine.kind, Code::inaccurate);
      EXPECT_EQ(mine.group, theirs.group);
      EXPECT_EQ(mine.time, theirs.time);
      EXPECT_EQ(mine.until, theirs.until);
    }
    estimated_position = std::max(estimated_position, lone.report().error.estimated_position.value());
  }
  EXPECT_EQ(e.report().status.code, Code::inaccurate);
  EXPECT_EQ(e.report().status.where, Place::member(1));
  // Each lane draws its own random signs, so the estimates differ.
  EXPECT_LE(e.report().error.estimated_position.value(), 10 * estimated_position);
  EXPECT_GE(e.report().error.estimated_position.value(), 0.1 * estimated_position);
}

// A measurement costs as much as several steps, so a lasting doubt is not measured in every step.
TEST(Accuracy, DoesNotMeasureALastingDoubtInEachStep) {
  const auto calls = [](double accuracy) {
    const auto count = std::make_shared<int>(0);
    Callback rocker = test::distance_by_callback("D", "C", 1.3);
    rocker.curvature = [count, curvature = rocker.curvature](auto x, auto rate, auto c) {
      ++*count;
      curvature(x, rate, c);
    };
    Simulator s(prepare(test::with_callback(1.3, rocker), {.strategy = "irreducible/eigen", .accuracy = accuracy}));
    *count = 0;
    const Trajectory rows = s.run();
    EXPECT_EQ(rows.rows(), 101u);
    EXPECT_EQ(s.report().status.code, accuracy > 0 ? Code::inaccurate : Code::ok);
    EXPECT_EQ(s.report().events.size(), accuracy > 0 ? 1u : 0u);
    return *count;
  };
  EXPECT_LE(calls(1e-18), 1.2 * calls(0));
}

TEST(Accuracy, HandlesMembersAtRest) {
  const std::vector<double> missed = {0.1, 1e-13, 1e-3};
  Ensemble e(missed.size(), [&](std::size_t i) {
    return prepare(standing_bars(missed[i], false), {.strategy = "irreducible/eigen:4", .accuracy = kBetween});
  });
  (void)e.run();
  for (std::size_t i = 0; i < missed.size(); ++i) {
    const Ensemble::Outcome& o = e.outcomes()[i];
    EXPECT_EQ(o.status.code, missed[i] < 1e-12 ? Code::inaccurate : Code::ok) << missed[i];
    EXPECT_EQ(o.events.empty(), o.status.ok());
  }
}

TEST(Accuracy, AppliesToChunks) {
  for (const std::string delta : {"1e-3", "1e-12"}) {
    const Scene scene = sample("almost_parallelogram:delta=" + delta + ",step=0.01,steps=100");
    const Result one = test::run(scene, "global/eigen"), chunks = test::run(scene, "global/eigen:4+chunks=4");
    EXPECT_EQ(chunks.report().status.code, one.report().status.code);
    ASSERT_EQ(chunks.report().events.size(), one.report().events.size());
    for (std::size_t n = 0; n < one.report().events.size(); ++n) {
      EXPECT_EQ(chunks.report().events[n].time, one.report().events[n].time);
    }
    const ForwardError mine = estimated(chunks.report()), theirs = estimated(one.report());
    EXPECT_LE(mine.position, 10 * theirs.position);
    EXPECT_GE(mine.position, 0.1 * theirs.position);
  }
}

TEST(Accuracy, KeepsTheErrorsOfChunks) {
  const Scene scene = sample("almost_parallelogram:delta=1e-12,step=0.01,steps=100");
  Result r = test::run(scene, "global/eigen:4+chunks=4");
  const ForwardError before = estimated(r.report());
  EXPECT_GT(worst(before), kDoubtfulError);
  ASSERT_TRUE(r.simulator.step(1.01).arrived());
  ASSERT_TRUE(r.simulator.step(1.02).arrived());
  EXPECT_GE(worst(estimated(r.report())), worst(before));
  EXPECT_EQ(r.report().status.code, Code::inaccurate);
}

// ---- unmeasured figures

// Velocities at rest have no error, even in bad postures. C of the slider is at a distance s from the posture where the
// rod is perpendicular to the rail; its acceleration is known to about eps / s^2.
TEST(ErrorEstimate, HandlesAStartAtRest) {
  for (const double missed : {0.5, 1e-11}) {
    SCOPED_TRACE(missed);
    const double rod = 1 + missed, across = std::numbers::pi / 2;
    SceneBuilder b("slider", 2);
    b.fixed_point("A", {0, 0, 0}).fixed_vector("rail", {1, 0, 0});
    b.point("B", {0, 1, 0}).point("C", {std::sqrt((rod - 1) * (rod + 1)), 0, 0});
    b.constrain("rod", Distance{"B", "C", rod}).constrain("line", OnLine{"C", "A", "rail"});
    b.constrain("crank", Distance{"A", "B", 1.0});
    b.drive("motor", PointAngle{"A", "B", "", Law::polynomial({across, 0})}).output("C").time(0, 1, 0.01);
    Simulator s(prepare(b.build(), {.strategy = "irreducible/eigen", .controlled = {"motor"}}));
    for (int k = 0; k < 4; ++k) ASSERT_TRUE(s.step().ok());
    EXPECT_EQ(s.report().error.estimated_velocity, 0);
    s.set("motor", across, 1.0);
    const Status moving = s.step();
    ASSERT_TRUE(moving.arrived());
    const auto angle = static_cast<long double>(across), square = static_cast<long double>(rod) * rod;
    const long double sine = std::sin(angle), cosine = std::cos(angle), root = std::sqrt(square - sine * sine);
    const long double rate = -sine - sine * cosine / root;
    const long double acceleration =
        -cosine - (cosine * cosine - sine * sine) / root - sine * sine * cosine * cosine / (root * root * root);
    const double off = static_cast<double>(std::abs(s.output("C.ax") - acceleration) / acceleration);
    EXPECT_LE(std::abs(s.output("C.vx") - static_cast<double>(rate)), 4 * s.report().error.estimated_velocity.value());
    EXPECT_LE(off, 4 * s.report().error.estimated_acceleration.value());
    EXPECT_GE(s.report().error.estimated_acceleration, kEps / missed / 100);
    EXPECT_EQ(moving.ok(), missed > 0.1);
  }
}

TEST(ErrorFigures, AreUnknownWithoutMeasurements) {
  const Scene scene = sample("stewart:steps=10").with_outputs({"handle1.value"});
  for (const std::string strategy : {"groups/eigen+predict=past:3", "irreducible/lanes:8+predict=past:3"}) {
    const Result r = test::run(scene, strategy);
    const ErrorFigures& error = r.report().error;
    EXPECT_LE(error.position, 1e-14);
    EXPECT_EQ(error.residual(), error.position);
    EXPECT_TRUE(std::isnan(error.velocity));
    EXPECT_TRUE(std::isnan(error.acceleration));
    EXPECT_TRUE(error.estimated_position.has_value());
    EXPECT_FALSE(error.estimated_velocity.has_value());
    EXPECT_FALSE(error.estimated_acceleration.has_value());
    const ForwardError truth = forward_error(r.simulator.prepared(), r.trajectory);
    EXPECT_LE(truth.position, 1e-14);
    EXPECT_TRUE(std::isnan(truth.velocity));
    EXPECT_TRUE(std::isnan(truth.acceleration));
  }
  // Nothing is solved if everything is driven.
  SceneBuilder b("driven", 2);
  b.fixed_point("A", {0, 0, 0}).point("B", {1, 0, 0});
  b.constrain("length", Distance{"A", "B", 1.0}).drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, 1})});
  const Result driven = test::run(b.output("B").time(0, 1, 0.1).build());
  if (driven.counters().group_solutions == 0) {
    EXPECT_TRUE(std::isnan(driven.report().error.position));
  }
  EXPECT_TRUE(std::isnan(ErrorFigures{}.residual()));
}

TEST(ErrorFigures, MergeKnownFigures) {
  ErrorFigures a, b;
  a.velocity = 2;
  b.velocity = 1;
  b.acceleration = 3;
  a.merge(b);
  EXPECT_TRUE(std::isnan(a.position));
  EXPECT_EQ(a.velocity, 2);
  EXPECT_EQ(a.acceleration, 3);
  b.merge(ErrorFigures{});
  EXPECT_EQ(b.velocity, 1);
  EXPECT_EQ(b.residual(), 3);
}

// ---- no doubts for regular scenes, doubts for singular ones

TEST(Doubt, IsRarelyUnfounded) {
  test::Draw draw(1);
  int doubted = 0;
  const int all = test::random_count(200);
  for (int i = 0; i < all; ++i) {
    const Scene scene = draw.maybe() ? test::planar_mechanism(draw) : test::spatial_mechanism(draw);
    Simulator s(test::prepare_in_turn(scene, i));
    (void)s.run();
    doubted += s.report().status.code == Code::inaccurate ? 1 : 0;
  }
  std::printf("%d of %d regular scenes in doubt\n", doubted, all);
  EXPECT_LE(doubted, all / 100) << "of " << all;
}

// Before its first doubt, a motion is right to 1e-6.
TEST(Doubt, ComesBeforeAnyWrongResult) {
  test::Draw draw(2);
  int clean = 0, doubted = 0, stopped = 0, refused = 0, unknown = 0;
  double largest = 0;
  const int all = test::random_count(200);
  for (int i = 0; i < all; ++i) {
    const Scene scene = test::near_singular(draw);
    SCOPED_TRACE(std::to_string(i));
    try {
      const Prepared p = test::prepare_in_turn(scene, i);
      Simulator s(p);
      Trajectory rows = s.run();
      const Report& r = s.report();
      (r.status.ok() ? clean : r.status.arrived() ? doubted : stopped) += 1;
      std::size_t sure = rows.rows();
      for (const Event& e : r.events) {
        // A doubt applies to the whole bracket of its event.
        while (sure > 0 && rows.times()[sure - 1] > e.time) --sure;
      }
      if (sure == 0) continue;
      const std::vector<double> times(rows.times().begin(), rows.times().begin() + static_cast<std::ptrdiff_t>(sure));
      if (sure < rows.rows()) rows = s.run(times);
      double error = 0;
      try {
        error = worst(forward_error(p, rows));
      } catch (const Error&) {
        ++unknown;  // the reference fails for this motion
        continue;
      }
      largest = std::max(largest, error);
      EXPECT_LE(error, 1e-6) << scene.name();
    } catch (const Error&) {
      ++refused;
    }
  }
  std::printf(
      "%d scenes: clean %d, doubted %d, stopped %d, refused %d, without a yardstick %d; largest error of what was "
      "not in doubt %.1e\n",
      all, clean, doubted, stopped, refused, unknown, largest);
  EXPECT_GT(clean, all / 10);
  EXPECT_LT(unknown, all / 20);
}

// The rates of drivers that rest for a moment are rounding errors, which must not serve as a scale for other rates.
TEST(ErrorEstimate, HandlesDriversThatReverseAtTheStart) {
  SceneBuilder builder("swing", 2);
  builder.fixed_point("A", {0, 0, 0}).fixed_point("D", {2, 0, 0}).point("B", {0.5, 0.8, 0}).point("C", {1.6, 1.2, 0});
  builder.constrain("crank", Distance{"A", "B", 1.0}).constrain("coupler", Distance{"B", "C", 1.8});
  builder.constrain("rocker", Distance{"D", "C", 1.3});
  builder.drive("motor", PointAngle{"A", "B", "", Law::harmonics({{1, 1, 0}})});
  const test::Result r = test::run(builder.time(0.25, 0.5, 0.025).build());
  EXPECT_EQ(r.report().status.code, Code::ok) << r.report().status.figure;
}

}  // namespace
}  // namespace assur
