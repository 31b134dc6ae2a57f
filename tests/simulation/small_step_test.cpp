// The fused step of a small group equals the step of GroupSolver.
#include "group/small_step.hpp"
#include "group/coded_step.hpp"
#include "program/step_rules.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "path/layout.hpp"
#include "simulation/run.hpp"

namespace assur {
namespace {

// Both are within 8 eps of the same posture, times the largest condition of a group, 23 (legs of the platform). The
// errors of rates grow with the square of the condition.
constexpr double kTolerance = 2 * 8 * 23 * 23 * kEps;

struct State {
  std::vector<double> values[3];

  explicit State(std::size_t size)
      : values{std::vector<double>(size), std::vector<double>(size), std::vector<double>(size)} {}

  struct Pointers {
    double* at[3];
  };
  Pointers pointers() { return {{values[0].data(), values[1].data(), values[2].data()}}; }
};

double largest(const std::vector<double>& v) {
  double size = 1;
  for (const double x : v) size = std::max(size, std::abs(x));
  return size;
}

// Computes the start posture with random rates of all moving inputs, first by GroupSolver, then as a small step from an
// inexact prediction. code: null, or the small step is machine code.
void expect_the_same_step(const Scene& scene, const std::string& strategy, StepCode* code) {
  SCOPED_TRACE(scene.name() + " " + strategy + (code != nullptr ? ", machine code" : ""));
  const Prepared prepared = prepare(scene, {strategy, {}});
  const Structure& structure = *prepared.structure;
  Layout layout = lay_out(prepared);
  State wanted(layout.size);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-1, 1);
  for (std::size_t c = 0; c < layout.address.size(); ++c) {
    if (layout.address[c] >= 0) wanted.values[0][static_cast<std::size_t>(layout.address[c])] = structure.start[c];
  }
  int small = 0;
  for (Pack& pack : layout.packs) {
    const auto c = static_cast<std::size_t>(pack.group_class);
    const GroupClass& group_class = structure.classes[c];
    GroupSolver& solver = *layout.solvers[c];
    const std::size_t lanes = static_cast<std::size_t>(solver.lanes());
    const std::size_t count = static_cast<std::size_t>(group_class.n) * lanes;
    for (std::size_t i = 0; i < static_cast<std::size_t>(group_class.n); ++i) {  // idle lanes repeat lane 0
      for (std::size_t l = static_cast<std::size_t>(pack.used); l < lanes; ++l) {
        wanted.values[0][pack.unknowns + i * lanes + l] = wanted.values[0][pack.unknowns + i * lanes];
      }
    }
    for (std::size_t i = 0; i < pack.inputs.size(); ++i) {
      const auto at = static_cast<std::size_t>(pack.inputs[i]);
      if (at >= layout.first_unknown || group_class.input_moves[i / lanes] == 0) continue;
      for (int d : {1, 2}) wanted.values[d][at] = number(random);
    }
    Counters counters;
    StepErrors errors;
    Attempt attempt;
    attempt.branch = Attempt::Branch::start;
    ASSERT_TRUE(solver.solve(pack, wanted.pointers().at, attempt, counters, errors).ok());

    const BlockConditions blocks(group_class, solver.program(), solver.lanes());
    Workspace work(*structure.system, group_class, structure.pattern(pack.group_class), solver.lanes());
    std::unique_ptr<SmallStep> step;
    if (code != nullptr) {
      step =
          std::make_unique<CodedStep>(work, code->of(group_class, solver.program(), blocks.reads(0), solver.lanes()));
    } else {
      step = make_small_step(group_class, solver.program(), blocks, solver.lanes());
    }
    if (!step) continue;
    ++small;
    State found = wanted;
    // A prediction within a tenth of the ball.
    double omega = 1;
    for (const double o : pack.omega) omega = std::max(omega, o);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t lane = i % lanes < static_cast<std::size_t>(pack.used) ? i % lanes : 0;
      found.values[0][pack.unknowns + i] += 0.1 / omega * std::cos(static_cast<double>(i / lanes * lanes + lane));
      for (int d : {1, 2}) found.values[d][pack.unknowns + i] = 7;
    }
    work.set_inputs(pack, found.values[0].data());
    work.evaluate(found.values[0].data() + pack.unknowns);
    step->choose_pivots(pack, found.values[0].data());
    State moved = found;
    SmallStepFigures figures;
    ASSERT_TRUE(step->run(pack, found.pointers().at, 12, kConverged, figures));
    EXPECT_GE(figures.iterations, 1);
    EXPECT_LE(figures.ball_used, 0.5);
    for (const double residual : {figures.position, figures.velocity, figures.acceleration}) {
      EXPECT_LE(residual, 16 * kEps);
    }
    for (int d : {0, 1, 2}) {
      const double tolerance = kTolerance * largest(wanted.values[d]);
      for (std::size_t i = pack.unknowns; i < pack.unknowns + count; ++i) {
        EXPECT_NEAR(found.values[d][i], wanted.values[d][i], tolerance) << d << " " << i - pack.unknowns;
      }
    }

    // Special cases are refused, and the prediction is unchanged.
    const State before = moved;
    EXPECT_FALSE(step->run(pack, moved.pointers().at, 0, kConverged, figures));
    moved.values[0][pack.unknowns] += 1e6;
    EXPECT_FALSE(step->run(pack, moved.pointers().at, 12, kConverged, figures));
    moved.values[0][pack.unknowns] = std::nan("");
    EXPECT_FALSE(step->run(pack, moved.pointers().at, 12, kConverged, figures));
    moved.values[0][pack.unknowns] = before.values[0][pack.unknowns];
    EXPECT_EQ(moved.values[0], before.values[0]);
  }
  EXPECT_EQ(small, static_cast<int>(layout.packs.size()));
}

TEST(SmallStep, EqualsTheStepOfGroupSolver) {
  const std::shared_ptr<StepCode> code = step_code();
  for (StepCode* const one : {static_cast<StepCode*>(nullptr), code.get()}) {
    for (const char* lanes : {"lanes", "lanes:2", "lanes:4", "lanes:8"}) {
      expect_the_same_step(sample("stewart"), std::string("irreducible/") + lanes, one);
      expect_the_same_step(sample("andrews"), std::string("irreducible/") + lanes, one);
    }
    expect_the_same_step(sample("four_bar:3"), "irreducible/lanes", one);
    expect_the_same_step(sample("slider_crank"), "irreducible/lanes", one);
    if (one != nullptr) expect_the_same_step(sample("stewart:platforms=3"), "irreducible/lanes:16", one);
  }
}

// Code is made once for a class and a number of lanes, and only where it is asked for.
TEST(SmallStep, SharesMachineCode) {
  PrepareOptions off{.strategy = "irreducible/lanes:8"}, on = off;
  on.machine_code = true;
  const Prepared p = prepare(sample("stewart"), on);
  EXPECT_EQ(p.code, step_code());
  EXPECT_EQ(prepare(sample("stewart"), off).code, nullptr);
  if (!p.code) GTEST_SKIP() << "this processor or this build has no machine code";
  const GroupClass& c = p.structure->classes[0];
  const Program program = compile(c, p.structure->pattern(0));
  const BlockConditions blocks(c, program, 8);
  const auto eight = p.code->of(c, program, blocks.reads(0), 8);
  ASSERT_NE(eight, nullptr);
  EXPECT_EQ(p.code->of(c, program, blocks.reads(0), 8), eight);
  EXPECT_NE(p.code->of(c, program, blocks.reads(0), 4), eight);
  const Trajectory with = Simulator(p).run(), without = Simulator(prepare(sample("stewart"), off)).run();
  EXPECT_LE(test::difference(with, without), kTolerance);
}

TEST(SmallStep, GivesTheSameMotion) {
  for (const char* scene : {"stewart:steps=200", "andrews", "four_bar:5", "slider_crank"}) {
    for (const char* lanes : {"lanes", "lanes:4", "lanes:8"}) {
      SCOPED_TRACE(std::string(scene) + " " + lanes);
      const test::Result one = test::run(sample(scene), "irreducible/eigen");
      const test::Result small = test::run(sample(scene), std::string("irreducible/") + lanes);
      ASSERT_EQ(small.report().status.code, one.report().status.code);
      EXPECT_LE(test::difference(one.trajectory, small.trajectory), kTolerance);
      EXPECT_EQ(small.counters().steps, one.counters().steps);
      EXPECT_EQ(small.counters().factorizations, small.counters().newton_iterations + small.counters().group_solutions);
      // A second run is bitwise equal.
      Simulator again = test::simulator(sample(scene), std::string("irreducible/") + lanes);
      (void)again.run();
      EXPECT_EQ(again.run().values(), small.trajectory.values());
    }
  }
}

}  // namespace
}  // namespace assur
