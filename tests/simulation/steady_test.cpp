// Steps allocate nothing.
#include <gtest/gtest.h>

#include "backends/allocations.hpp"
#include "simulation/run.hpp"

namespace assur {
namespace {

using test::allocations;

constexpr int kWarm = 2, kSteps = 50;

// Allocations of `kSteps` steps after the first two.
template <class Step>
std::int64_t allocations_of(const Step& step) {
  bool ok = true;
  for (int k = 1; k <= kWarm; ++k) ok = step(k).arrived() && ok;
  const std::int64_t before = allocations();
  for (int k = kWarm + 1; k <= kWarm + kSteps; ++k) ok = step(k).arrived() && ok;
  const std::int64_t count = allocations() - before;
  EXPECT_TRUE(ok);
  return count;
}

std::int64_t allocations_of_steps(const Scene& scene, const std::string& strategy) {
  Simulator s = test::simulator(scene, strategy);
  return allocations_of([&](int k) { return s.step(scene.time().time(k)); });
}

TEST(Steady, TheCounterCountsAllocations) {
  const std::int64_t before = allocations();
  const std::vector<double> memory(100, 1.0);
  EXPECT_EQ(memory.front(), 1.0);
  EXPECT_GE(allocations(), before + 1);
}

TEST(Steady, StepsOfEveryFormulationAllocateNothing) {
  for (const std::string& solver : test::solvers()) {
    for (const std::string formulation : {"global", "groups", "irreducible"}) {
      for (const std::string option : {"", "+once", "+predict=taylor:2", "+predict=past:5"}) {
        const std::string strategy = formulation + "/" + solver + option;
        EXPECT_EQ(allocations_of_steps(sample("stewart"), strategy), 0) << strategy;
      }
    }
    for (const std::string text : {"rings:legs=6,n=120", "four_bar:64", "slider_crank"}) {
      EXPECT_EQ(allocations_of_steps(sample(text), "groups/" + solver), 0) << text << " " << solver;
    }
    EXPECT_EQ(allocations_of_steps(sample("stewart"), "groups/" + solver + ":8"), 0) << solver << ":8";
  }
}

TEST(Steady, PositionsOnlyAllocateNothing) {
  const Scene handles = sample("stewart").with_outputs({"handle1.value", "handle4.value"});
  for (const std::string& solver : test::solvers()) {
    for (const std::string formulation : {"global", "groups", "irreducible"}) {
      EXPECT_EQ(allocations_of_steps(handles, formulation + "/" + solver), 0) << formulation << "/" << solver;
    }
  }
}

TEST(Steady, RejectedStepsAllocateNothing) {
  // Steps of 3.6 degrees close to the change point are halved.
  const Scene scene = sample("almost_parallelogram:delta=1e-4");
  for (const std::string& solver : test::solvers()) {
    Simulator s = test::simulator(scene, "groups/" + solver);
    const std::int64_t count = allocations_of([&](int k) { return s.step(scene.time().time(k)); });
    EXPECT_GT(s.report().counters.rejected, 0);
    EXPECT_EQ(count, 0) << solver;
  }
}

TEST(Steady, SmallStepsAllocateNothing) {
  for (const std::string scene : {"stewart", "four_bar:8"}) {
    Simulator s = test::simulator(sample(scene), "irreducible/lanes:8");
    EXPECT_EQ(allocations_of([&](int) { return s.step(); }), 0) << scene;
  }
}

TEST(Steady, ControlAllocatesNothing) {
  for (const std::string& solver : test::solvers()) {
    for (const std::string formulation : {"global", "groups", "irreducible"}) {
      Simulator s =
          test::simulator(sample("stewart"), formulation + "/" + solver, {.iterations = 1, .seconds = 10}, {"pose"});
      const std::int64_t count = allocations_of([&](int k) {
        s.set("pose.x", 0.001 * k, 0.1, 0);
        s.set("pose.psi", 0.15 * 0.479425538604203, 0, 0);
        return s.step();
      });
      EXPECT_EQ(count, 0) << formulation << "/" << solver;
    }
    Simulator s = test::simulator(sample("four_bar:64"), "groups/" + solver, {}, {"motor"});
    const std::int64_t count = allocations_of([&](int k) {
      s.set("motor", 0.005 * k, 5, 0);
      return s.step();
    });
    EXPECT_EQ(count, 0) << solver;
  }
}

}  // namespace
}  // namespace assur
