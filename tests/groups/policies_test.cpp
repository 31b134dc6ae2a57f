// Policies of factorisation: for each iteration, for a step, for many steps, in float.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "errors/conditions.hpp"
#include "plan/preparation.hpp"

namespace assur {
namespace {

using test::Result;

// Positions have residuals of 8 eps, derivatives normwise residuals of 32 eps. The condition of a group (23 for a leg,
// 16 for a ring) amplifies them once, for accelerations twice. Two runs differ by at most twice this error.
constexpr double kTolerance = 2 * 32 * 23 * 23 * kEps;

// Work after the start posture, for each group and step.
struct Work {
  double factorizations, iterations;
};
Work work(const Result& r) {
  const auto groups = static_cast<double>(preparation(r.simulator.prepared()).structure->groups.size());
  const double solutions = groups * static_cast<double>(r.counters().steps + r.counters().substeps);
  return {(static_cast<double>(r.counters().factorizations) - groups) / solutions,
          static_cast<double>(r.counters().newton_iterations) / solutions};
}

struct Policy {
  const char* options;
  double least, most;  // factorisations for each group and step
};

// With the last posture as prediction, a step needs several iterations.
TEST(Policies, DetermineTheFactorisationsOfAStep) {
  const Scene scene = sample("stewart:steps=40");
  for (const std::string& solver : test::solvers()) {
    const Result reference = test::run(scene, "groups/" + solver + "+predict=taylor:0");
    ASSERT_TRUE(reference.report().status.ok());
    const double iterations = work(reference).iterations;
    ASSERT_GT(iterations, 1.5);
    EXPECT_NEAR(work(reference).factorizations, iterations + 1, 1e-9);
    for (const Policy& policy :
         {Policy{"+reuse=step", 1.9, 2.1}, Policy{"+reuse=run", 0.9, 1.1}, Policy{"+once", 0.9, 1.1},
          Policy{"+reuse=step+once", 0.9, 1.1}, Policy{"+reuse=run+once", 0.001, 0.5}}) {
      SCOPED_TRACE(solver + policy.options);
      const Result r = test::run(scene, "groups/" + solver + policy.options + "+predict=taylor:0");
      ASSERT_TRUE(r.report().status.ok());
      EXPECT_GE(work(r).factorizations, policy.least);
      EXPECT_LE(work(r).factorizations, policy.most);
      EXPECT_LE(test::difference(reference.trajectory, r.trajectory), kTolerance);
      EXPECT_LE(r.report().error.position, 1e-14);
      EXPECT_LE(r.report().error.velocity, 32 * kEps);
      EXPECT_LE(r.report().error.acceleration, 32 * kEps);
    }
  }
}

// The outputs of four_bar and stewart need the accelerations of all groups.
TEST(Policies, SeparateTakesOneFactorisationMoreForTheAcceleration) {
  std::vector<std::string> solvers = test::solvers();
  solvers.emplace_back("lanes:8");
  for (const char* text : {"stewart:steps=40", "four_bar:5"}) {
    const Scene scene = sample(text);
    const std::vector<double> conditions = test::conditions(scene, test::grid_of(scene), 10);
    const double condition = *std::max_element(conditions.begin(), conditions.end());
    for (const std::string& solver : solvers) {
      for (const std::string options : {"", "+reuse=step", "+reuse=run"}) {
        SCOPED_TRACE(text + (" " + solver) + options);
        const Result shared = test::run(scene, "groups/" + solver + options);
        const Result separate = test::run(scene, "groups/" + solver + options + "+separate");
        ASSERT_TRUE(shared.report().status.ok() && separate.report().status.ok());
        const Counters &a = shared.counters(), &b = separate.counters();
        const auto groups =
            static_cast<std::int64_t>(preparation(shared.simulator.prepared()).structure->groups.size());
        const std::int64_t more = groups * (a.steps + a.substeps + 1);  // and the start
        // Factorisations of Newton's method are not compared, because small steps round differently and may take
        // another iteration.
        EXPECT_EQ(b.factorizations - b.newton_iterations, a.factorizations - a.newton_iterations + more);
        EXPECT_LE(test::difference(shared.trajectory, separate.trajectory), 2 * 32 * condition * condition * kEps);
      }
    }
  }
}

TEST(Policies, SeparateHasNoEffectWithoutAccelerations) {
  const Scene scene = sample("stewart:steps=40").with_outputs({"handle1.value", "handle2.value"});
  for (const std::string predictor : {"+predict=past:3", "+predict=taylor:1"}) {
    const Result shared = test::run(scene, "groups/eigen" + predictor);
    const Result separate = test::run(scene, "groups/eigen+separate" + predictor);
    ASSERT_TRUE(shared.report().status.ok() && separate.report().status.ok());
    EXPECT_TRUE(std::isnan(separate.report().error.acceleration));  // never measured
    EXPECT_EQ(separate.counters().factorizations, shared.counters().factorizations);
    EXPECT_EQ(separate.trajectory.values(), shared.trajectory.values());
  }
}

TEST(Policies, KeepFactorsOnlyWhileCorrectionsContract) {
  const Result small = test::run(sample("rings:legs=6,n=24,steps=200,step=0.01"), "groups/eigen+reuse=run+once");
  const Result large = test::run(sample("rings:legs=6,n=24,steps=200,step=0.1"), "groups/eigen+reuse=run+once");
  ASSERT_TRUE(small.report().status.ok() && large.report().status.ok());
  EXPECT_LT(2 * work(small).factorizations, work(large).factorizations);
}

TEST(Policies, RunsRepeatBitwise) {
  for (const std::string& solver : test::solvers()) {
    for (const std::string options : {"+reuse=run", "+reuse=run+once", "+once", "+refine"}) {
      Simulator s = test::simulator(sample("stewart:steps=50"), "groups/" + solver + options);
      const Trajectory first = s.run(), second = s.run();
      EXPECT_EQ(test::difference(first, second), 0) << solver << options;
    }
  }
}

TEST(Policies, RefinementIsCounted) {
  const Result r = test::run(sample("stewart:steps=50"), "groups/eigen+refine");
  ASSERT_TRUE(r.report().status.ok());
  EXPECT_GT(r.report().effort.refined, 0);
  EXPECT_EQ(r.report().effort.in_double, 0);
  EXPECT_TRUE(r.report().fallbacks.empty());
  EXPECT_LE(r.report().error.acceleration,
            test::run(sample("stewart:steps=50"), "groups/eigen").report().error.acceleration);
}

TEST(Policies, FloatReachesTheAccuracyOfDouble) {
  for (const Backend& backend : backends()) {
    if (!backend.single || !backend.why_not({}, {}).empty()) continue;
    for (const std::string text : {"stewart:steps=100", "four_bar:5"}) {
      for (const std::string lanes : {"", ":8", ":16"}) {
        SCOPED_TRACE(text + " " + std::string(backend.id) + lanes);
        const Result reference = test::run(sample(text), "groups/eigen");
        const Result r = test::run(sample(text), "groups/" + std::string(backend.id) + lanes + "+float");
        ASSERT_TRUE(r.report().status.ok());
        EXPECT_LE(test::difference(reference.trajectory, r.trajectory), kTolerance);
        EXPECT_LE(r.report().error.position, 1e-14);
        EXPECT_GT(r.report().effort.refined, 0);
        EXPECT_EQ(r.report().effort.in_double, 0);
      }
    }
  }
}

std::string refusal(const std::string& strategy) {
  try {
    (void)prepare(sample("four_bar:1"), {strategy, {}});
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::environment);
    return error.what();
  }
  return "no error";
}

TEST(Policies, RefuseMissingFeaturesOfABackend) {
  if (test::sparse() != "klu") GTEST_SKIP() << "no KLU";
  EXPECT_EQ(refusal("groups/klu+float"), "backend klu cannot run here: it has no float version; leave out +float");
}

}  // namespace
}  // namespace assur
