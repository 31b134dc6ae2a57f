// Predictors have their theoretical orders and do not change the result. Also steps in any direction, and repeated
// runs.
#include <gtest/gtest.h>

#include <functional>

#include "backends/allocations.hpp"
#include "motion/predictor.hpp"
#include "simulation/run.hpp"

namespace assur {
namespace {

using test::Result;

const std::vector<std::string> kPredictors = {"taylor:0", "taylor:1", "taylor:2", "hermite:5", "past:0",
                                              "past:1",   "past:2",   "past:3",   "past:4",    "past:5"};

// B1 of the crank-rocker at the times newest, newest - h, ...: x and y with their derivatives.
std::vector<std::array<Motion, 2>> postures(double newest, double h, int count) {
  Simulator s = test::simulator(sample("four_bar"));
  std::vector<std::array<Motion, 2>> out;
  for (int i = count - 1; i >= 0; --i) {
    EXPECT_TRUE(s.step(newest - i * h).ok());
    out.insert(out.begin(), {Motion{s.output("B1.x"), s.output("B1.vx"), s.output("B1.ax")},
                             Motion{s.output("B1.y"), s.output("B1.vy"), s.output("B1.ay")}});
  }
  return out;
}

double error_of_prediction(const Predictor& predictor, double h) {
  const double now = 0.3;
  const int count = postures_read(predictor);
  const auto known = postures(now, h, count);
  std::vector<double> times;
  for (int i = 0; i < count; ++i) times.push_back(now - i * h);
  const PredictionWeights w = prediction_weights(predictor, times, now + h);
  EXPECT_EQ(w.postures, count);
  const auto next = postures(now + h, h, 1)[0];
  double worst = 0;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    double sum = 0;
    for (std::size_t p = 0; p < static_cast<std::size_t>(count); ++p) {
      const Motion& m = known[p][axis];
      sum += w.weight[p][0] * m.value + w.weight[p][1] * m.rate + w.weight[p][2] * m.acceleration;
    }
    worst = std::max(worst, std::abs(sum - next[axis].value));
  }
  return worst;
}

// The error is c h^k (1 + O(h)). Steps of 2.9 and 1.4 degrees of the crank show the order k to a few per cent.
TEST(Predictor, HasItsTheoreticalOrder) {
  for (const std::string& text : kPredictors) {
    const Predictor predictor = parse_strategy("groups/eigen+predict=" + text).run.predictor;
    const double order = predictor.kind == Predictor::Kind::hermite ? 6 : predictor.order + 1;
    const double coarse = error_of_prediction(predictor, 0.008), fine = error_of_prediction(predictor, 0.004);
    EXPECT_NEAR(std::log2(coarse / fine), order, 0.35) << text << ": " << coarse << ", " << fine;
    EXPECT_GT(fine, 64 * kEps) << text;  // not a rounding error
  }
}

TEST(Predictor, WeightsReproduceTheLastPosture) {
  const std::vector<double> times = {0.3, 0.29, 0.27, 0.26, 0.2, 0.1};
  for (const std::string& text : kPredictors) {
    const Predictor predictor = parse_strategy("groups/eigen+predict=" + text).run.predictor;
    const PredictionWeights w =
        prediction_weights(predictor, {times.data(), static_cast<std::size_t>(postures_read(predictor))}, 0.3);
    for (std::size_t p = 0; p < kMostPostures; ++p) {
      for (std::size_t d = 0; d < 3; ++d) {
        EXPECT_EQ(w.weight[p][d], p + d == 0 ? 1 : 0) << text;
      }
    }
  }
}

// Postures too near to the last one are left out, because extrapolation would amplify their errors.
TEST(Predictor, OmitsPosturesThatAreTooClose) {
  const std::vector<double> near = {0.3, 0.3 - 1e-9};
  const PredictionWeights hermite = prediction_weights({Predictor::Kind::hermite, 5}, near, 0.31);
  EXPECT_EQ(hermite.postures, 1);
  EXPECT_NEAR(hermite.weight[0][2], 0.01 * 0.01 / 2, 0.01 * kEps);  // as in a Taylor series; 0.31 - 0.3 is rounded
  EXPECT_EQ(prediction_weights({Predictor::Kind::past, 1}, near, 0.31).postures, 1);
  const std::vector<double> far = {0.3, 0.29};
  EXPECT_EQ(prediction_weights({Predictor::Kind::past, 1}, far, 0.31).postures, 2);
}

TEST(Predictor, KeepsTheWeightsOfEqualSteps) {
  for (const std::string& text : kPredictors) {
    SCOPED_TRACE(text);
    const Predictor predictor = parse_strategy("groups/eigen+predict=" + text).run.predictor;
    const auto count = static_cast<std::size_t>(postures_read(predictor));
    const auto grid = [&](int newest, double step) {
      std::vector<double> times;
      for (std::size_t i = 0; i < count; ++i) times.push_back((newest - static_cast<int>(i)) * step);
      return times;
    };
    WeightsOfEqualSteps kept;
    const auto same = [](const PredictionWeights& a, const PredictionWeights& b) {
      return a.postures == b.postures && a.weight == b.weight;
    };
    const PredictionWeights first = kept.at(predictor, grid(10, 0.01), 11 * 0.01);
    EXPECT_TRUE(same(first, prediction_weights(predictor, grid(10, 0.01), 11 * 0.01)));
    // Times of a grid are rounded, so that steps differ in their last bits. The weights must not differ.
    EXPECT_TRUE(same(kept.at(predictor, grid(3000, 0.01), 3001 * 0.01), first));
    EXPECT_TRUE(
        same(kept.at(predictor, grid(10, 0.02), 11 * 0.02), prediction_weights(predictor, grid(10, 0.02), 0.22)));
    const double off = 11 * 0.01 + 1e-11;  // 1e-9 of a step
    EXPECT_TRUE(same(kept.at(predictor, grid(10, 0.01), off), prediction_weights(predictor, grid(10, 0.01), off)));
    const std::vector<double> one = {0.1};  // fewer postures, the same last step
    EXPECT_TRUE(same(kept.at(predictor, one, off), prediction_weights(predictor, one, off)));
  }
}

// Newton's method ends at the same posture for every prediction, up to residuals of 8 eps times the worst condition of
// the turn. The sine between coupler and rocker is at least 0.44, and the errors of ten loops add up. The errors
// of rates grow with the square of the condition.
TEST(Predictor, DoesNotChangeTheResult) {
  const Scene scene = sample("four_bar:loops=10,step=0.002,steps=500");
  const Result reference = test::run(scene, "groups/eigen");
  const double tolerance = 10 * 2 * 8 * kEps / (0.44 * 0.44) * 16;
  std::int64_t before = 0;
  for (const std::string& text : kPredictors) {
    SCOPED_TRACE(text);
    const Result r = test::run(scene, "groups/eigen+predict=" + text);
    ASSERT_TRUE(r.report().status.ok());
    EXPECT_LE(test::difference(reference.trajectory, r.trajectory), tolerance);
    EXPECT_LE(r.report().error.position, 1e-14);
    // A higher order of the same kind never takes more corrections here.
    if (text != "taylor:0" && text != "hermite:5" && text != "past:0") {
      EXPECT_LE(r.counters().newton_iterations, before);
    }
    before = r.counters().newton_iterations;
  }
  EXPECT_LT(test::run(scene, "groups/eigen+predict=hermite:5").counters().newton_iterations,
            test::run(scene, "groups/eigen+predict=taylor:0").counters().newton_iterations / 2);
}

TEST(Predictor, AutomaticUsesAvailableDerivatives) {
  const auto chosen = [](const Scene& scene) { return prepare(scene, {"groups/eigen", {}}).plan().run.predictor; };
  const Scene stewart = sample("stewart");
  EXPECT_EQ(chosen(stewart), (Predictor{Predictor::Kind::hermite, 5}));
  EXPECT_EQ(chosen(stewart.with_outputs({"handle1.value"})), (Predictor{Predictor::Kind::past, 5}));
  EXPECT_EQ(chosen(stewart.with_outputs({"handle1.rate"})), (Predictor{Predictor::Kind::past, 5}));
  // Only some unknowns of a group need accelerations; a predictor that uses all would read zeros.
  EXPECT_EQ(chosen(stewart.with_outputs({"B1"})), (Predictor{Predictor::Kind::past, 5}));
}

// Predictions are so good that one correction for each step suffices, whatever the outputs are.
TEST(Predictor, PredictsEquallyWellForFewOutputs) {
  for (const char* output : {"B1", "handle1", "e1", "d1"}) {
    const Result r = test::run(sample("stewart").with_outputs({output}), "groups/eigen");
    ASSERT_TRUE(r.report().status.ok()) << output;
    EXPECT_LE(r.counters().newton_iterations, r.counters().group_solutions + 20) << output;
  }
}

TEST(Once, TakesOneFactorizationPerStepAndGroup) {
  for (const std::string text :
       {"stewart:steps=300", "rings:legs=3,n=24,steps=200", "four_bar:loops=5,step=0.002,steps=300"}) {
    for (const std::string formulation : {"global", "groups", "irreducible"}) {
      for (const std::string& solver : test::solvers()) {
        SCOPED_TRACE(text + " " + formulation + "/" + solver);
        const Scene scene = sample(text);
        const Result once = test::run(scene, formulation + "/" + solver + "+once");
        const Result fresh = test::run(scene, formulation + "/" + solver);
        ASSERT_TRUE(once.report().status.ok());
        EXPECT_EQ(once.counters().factorizations, once.counters().group_solutions);
        EXPECT_EQ(fresh.counters().factorizations,
                  fresh.counters().newton_iterations + fresh.counters().group_solutions);
        EXPECT_LE(once.report().error.position, 1e-14);
        EXPECT_LE(once.report().error.velocity, 1e-14);
        EXPECT_LE(once.report().error.acceleration, 1e-14);
        // Both solve to a backward error of a few eps; conditions are at most 23, errors of five loops add up, and
        // accelerations include the error of the velocities.
        EXPECT_LE(test::difference(fresh.trajectory, once.trajectory), 5 * 2 * 8 * 23 * 23 * kEps);
      }
    }
  }
}

TEST(Steps, GoBackwards) {
  const Scene scene = sample("four_bar:loops=3");
  for (const std::string predictor : {"taylor:2", "hermite:5", "past:4"}) {
    Simulator s = test::simulator(scene, "groups/eigen+predict=" + predictor);
    for (const double t : {0.01, 0.02, 0.03}) ASSERT_TRUE(s.step(t).ok());
    const double x = s.output("B3.x"), v = s.output("B3.vx"), a = s.output("B3.ax");
    for (const double t : {0.1, 0.25, 0.2, 0.1, 0.02, -0.1, 0.01, 0.03}) {
      ASSERT_TRUE(s.step(t).ok()) << predictor << " to " << t;
      EXPECT_EQ(s.time(), t);
    }
    // Residuals of 8 eps of coordinates up to 10 m, divided by sines of at least 0.44, in each of three loops.
    const double tolerance = 3 * 2 * 8 * 10 * kEps / (0.44 * 0.44);
    EXPECT_NEAR(s.output("B3.x"), x, tolerance) << predictor;
    EXPECT_NEAR(s.output("B3.vx"), v, tolerance * std::abs(6.3)) << predictor;
    EXPECT_NEAR(s.output("B3.ax"), a, tolerance * 6.3 * 6.3 * 4) << predictor;
  }
}

TEST(Steps, ToThePresentTimeDoNothing) {
  Simulator s = test::simulator(sample("four_bar"));
  ASSERT_TRUE(s.step(0.01).ok());
  const std::vector<double> before(s.outputs().begin(), s.outputs().end());
  const Counters counters = s.report().counters;
  ASSERT_TRUE(s.step(0.01).ok());
  EXPECT_EQ(std::vector<double>(s.outputs().begin(), s.outputs().end()), before);
  EXPECT_EQ(s.report().counters.evaluated_equations, counters.evaluated_equations);
}

TEST(Runs, RepeatBitwise) {
  for (const std::string text : {"stewart:steps=100", "almost_parallelogram:delta=1e-8", "andrews"}) {
    for (const std::string& solver : test::solvers()) {
      Simulator s = test::simulator(sample(text), "groups/" + solver);
      const Trajectory first = s.run();
      const Counters counters = s.report().counters;
      const Trajectory second = s.run();
      EXPECT_EQ(first.values(), second.values()) << text;
      EXPECT_EQ(s.report().counters.newton_iterations, counters.newton_iterations) << text;
      EXPECT_EQ(s.report().counters.substeps, counters.substeps) << text;
      EXPECT_EQ(test::simulator(sample(text), "groups/" + solver).run().values(), first.values()) << text;
    }
  }
}

// The constructor and reset() start the motion, and a run does so again only if anything has happened since.
TEST(Runs, ANewSimulatorStartsOnce) {
  const Scene scene = sample("four_bar:loops=5,steps=20");
  const auto prepared = prepare(scene, {"auto", {scene.drivers().front().name}});
  const Trajectory expected = Simulator(prepared).run();
  Simulator untouched(prepared);
  const std::int64_t before = test::allocations();
  untouched.reset();
  EXPECT_EQ(test::allocations(), before);
  untouched.reset();  // makes its solvers anew
  EXPECT_GT(test::allocations(), before);
  Simulator returned(prepared);
  (void)returned.run();
  returned.reset();
  const std::int64_t afterwards = test::allocations();
  returned.reset();
  EXPECT_EQ(test::allocations(), afterwards);
  const std::function<void(Simulator&)> touches[] = {
      [](Simulator& s) { (void)s.step(0.01); },
      [](Simulator& s) { (void)s.step(); },
      [](Simulator& s) { s.set(s.driver(s.drivers().front()), 1); },
      [](Simulator& s) { (void)s.save(); },
      [](Simulator& s) { s.restore(s.save()); },
      [](Simulator& s) { s.retreat(); },
      [](Simulator& s) { (void)s.jacobian(); },
      [](Simulator& s) { (void)s.examine(); },
      [](Simulator& s) { (void)s.run(); },
  };
  for (const auto& touch : touches) {
    Simulator s(prepared);
    for (const bool is_returned : {false, true}) {
      if (is_returned) s.reset();
      touch(s);
      EXPECT_EQ(s.run().values(), expected.values());
      EXPECT_EQ(s.report().counters.steps, 20);
    }
  }
}

TEST(Runs, ResetReturnsToTheStart) {
  Simulator s = test::simulator(sample("almost_parallelogram:delta=0,step=0.0033,steps=303"), "groups/eigen");
  const std::vector<double> start(s.outputs().begin(), s.outputs().end());
  const Counters counters = s.report().counters;
  (void)s.run();
  EXPECT_FALSE(s.report().events.empty());
  EXPECT_NE(std::vector<double>(s.outputs().begin(), s.outputs().end()), start);
  s.reset();
  EXPECT_EQ(s.time(), 0);
  EXPECT_EQ(std::vector<double>(s.outputs().begin(), s.outputs().end()), start);
  EXPECT_TRUE(s.report().events.empty());
  EXPECT_TRUE(s.report().status.ok());
  EXPECT_EQ(s.report().counters.newton_iterations, counters.newton_iterations);
  EXPECT_EQ(s.report().counters.steps, 0);
}

}  // namespace
}  // namespace assur
