// Groups solved in lanes give the same results.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

#include "evaluation/lane_array.hpp"
#include "motion/layout.hpp"
#include "motion/state.hpp"
#include "plan/preparation.hpp"
#include "simulation/run.hpp"

namespace assur {
namespace {

using test::Result;

// One lane and several lanes have different elimination orders, because pivots are chosen for all lanes together.
// Results differ by the errors of both: residuals of 8 eps times the condition of a group, for accelerations its
// square.
constexpr double tolerance(double condition) { return 2 * 8 * condition * condition * kEps; }

constexpr double kLeg = 23, kRing = 7;  // largest over smallest singular value; ring of n = 24

void expect_the_same_motion(const Scene& scene, const std::string& formulation, const std::vector<std::string>& solvers,
                            double condition = kLeg) {
  const Result one = test::run(scene, formulation + "/eigen");
  ASSERT_TRUE(one.report().status.ok());
  for (const std::string& solver : solvers) {
    SCOPED_TRACE(scene.name() + " " + formulation + "/" + solver);
    const Result r = test::run(scene, formulation + "/" + solver);
    ASSERT_EQ(r.report().status.code, Code::ok);
    EXPECT_LE(test::difference(one.trajectory, r.trajectory), tolerance(condition));
    EXPECT_LE(r.report().error.position, 1e-14);
    // Counters include group instances, but not idle lanes. If one lane rejects a step, the whole pack is solved again.
    EXPECT_EQ(r.counters().steps, one.counters().steps);
    const auto groups = static_cast<std::int64_t>(preparation(r.simulator.prepared()).structure->groups.size());
    EXPECT_LE(r.counters().group_solutions,
              groups * (1 + r.counters().steps + r.counters().substeps + r.counters().rejected));
    EXPECT_GE(r.counters().group_solutions, groups * (1 + r.counters().steps + r.counters().substeps));
    EXPECT_EQ(r.counters().factorizations, r.counters().newton_iterations + r.counters().group_solutions);
  }
}

std::vector<std::string> with_lanes() {
  std::vector<std::string> out;
  for (const std::string& solver : test::solvers()) {
    for (const char* lanes : {":2", ":4", ":8", ":16"}) out.push_back(solver + lanes);
  }
  return out;
}

// A vector that crosses a cache line takes twice as long to read.
TEST(Lanes, DoNotCrossACacheLine) {
  for (const char* strategy : {"groups/eigen", "irreducible/eigen:4", "irreducible/eigen:16"}) {
    for (const char* scene : {"stewart:legs=11", "andrews"}) {
      const Layout layout = lay_out(preparation(prepare(sample(scene), {strategy})));
      State values;
      values.resize(layout.first_unknown, layout.size, {});
      const State& state = values;
      for (const Pack& pack : layout.packs) {
        const auto lanes =
            static_cast<std::size_t>(layout.solvers[static_cast<std::size_t>(pack.group_class)]->lanes());
        const std::size_t bytes = std::min(kLineBytes, lanes * sizeof(double));
        for (const double* array :
             {state.at(0) + pack.unknowns, state.at(2) + pack.unknowns, pack.anchor.data(), pack.coefficients.data()}) {
          EXPECT_EQ(reinterpret_cast<std::uintptr_t>(array) % bytes, 0U) << scene << ' ' << strategy;
        }
      }
    }
  }
}

// Six legs fill the lanes of their packs, or leave idle lanes.
TEST(Lanes, SolveLegsOfThePlatform) {
  expect_the_same_motion(sample("stewart:steps=200"), "groups", with_lanes());
  expect_the_same_motion(sample("stewart:steps=200"), "irreducible", with_lanes());
  expect_the_same_motion(sample("stewart:steps=100"), "global", {"eigen:4", test::sparse() + ":4"});
}

TEST(Lanes, SolveManyGroupsOfAClass) {
  expect_the_same_motion(sample("stewart:legs=11,steps=100"), "groups", with_lanes());
  expect_the_same_motion(sample("rings:legs=5,n=24,steps=100"), "groups", with_lanes(), kRing);
  expect_the_same_motion(sample("andrews"), "groups", with_lanes());
}

TEST(Lanes, SolveWithOnceAndWithPositionsOnly) {
  const Scene handles = sample("stewart:steps=200").with_outputs({"handle1.value", "handle2.value", "handle6.value"});
  const Result one = test::run(handles, "groups/eigen");
  for (const std::string& solver : with_lanes()) {
    for (const std::string option : {"", "+once"}) {
      const Result r = test::run(handles, "groups/" + solver + option);
      ASSERT_TRUE(r.report().status.ok()) << solver;
      EXPECT_LE(test::difference(one.trajectory, r.trajectory), tolerance(kLeg)) << solver << option;
    }
  }
}

}  // namespace
}  // namespace assur
