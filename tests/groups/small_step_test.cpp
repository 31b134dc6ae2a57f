// The step of a small group in registers equals the step of GroupSolver, and has the same bits by kernels and by
// machine code.
#include "groups/small_step.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "motion/layout.hpp"
#include "plan/preparation.hpp"
#include "program/group_step.hpp"
#include "program/step_rules.hpp"
#include "simulation/same_run.hpp"

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
// inexact prediction.
void expect_the_same_step(const Scene& scene, const std::string& strategy) {
  SCOPED_TRACE(scene.name() + " " + strategy);
  const std::shared_ptr<StepCode> code = step_code();
  const Prepared prepared = prepare(scene, {strategy, {}});
  const GroupedSystem& structure = *preparation(prepared).structure;
  Layout layout = lay_out(preparation(prepared));
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

    const BlockConditions blocks(group_class, solver.lanes());
    ASSERT_TRUE(has_group_step(group_class));
    Workspace work(*structure.system, group_class, solver.lanes());
    const auto kernel = make_small_step(work, blocks);
    const auto coded = code ? make_coded_step(work, blocks, *code) : nullptr;
    ++small;
    State predicted = wanted;
    // A prediction within a tenth of the ball.
    double omega = 1;
    for (const double o : pack.omega) omega = std::max(omega, o);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t lane = i % lanes < static_cast<std::size_t>(pack.used) ? i % lanes : 0;
      predicted.values[0][pack.unknowns + i] += 0.1 / omega * std::cos(static_cast<double>(i / lanes * lanes + lane));
      for (int d : {1, 2}) predicted.values[d][pack.unknowns + i] = 7;
    }
    work.set_inputs(pack, predicted.values[0].data());
    work.evaluate(predicted.values[0].data() + pack.unknowns);
    std::vector<State> found;
    std::vector<SmallStepFigures> figures;
    std::vector<std::vector<double>> iterations;
    for (SmallStep* const step : {kernel.get(), coded.get()}) {
      if (step == nullptr) continue;
      SCOPED_TRACE(step == kernel.get() ? "kernel" : "machine code");
      State& now = found.emplace_back(predicted);
      SmallStepFigures f;
      ASSERT_TRUE(step->run(pack, now.pointers().at, 12, kConverged, f));
      figures.push_back(f);
      iterations.emplace_back(f.iterations, f.iterations + lanes);
      for (const double of_lane : iterations.back()) EXPECT_GE(of_lane, 1);
      for (std::size_t l = 0; l < lanes; ++l) EXPECT_LE(f.ball_used[l], 0.5);
      for (const double residual : {f.position, f.velocity, f.acceleration}) EXPECT_LE(residual, 16 * kEps);
      for (int d : {0, 1, 2}) {
        const double tolerance = kTolerance * largest(wanted.values[d]);
        for (std::size_t i = pack.unknowns; i < pack.unknowns + count; ++i) {
          EXPECT_NEAR(now.values[d][i], wanted.values[d][i], tolerance) << d << " " << i - pack.unknowns;
        }
      }

      // Special cases are refused. The prediction of their lane is unchanged; the other lanes are solved.
      for (const double by : {0.0, 1e6, kNan}) {
        State moved = predicted;
        moved.values[0][pack.unknowns] += by;
        const State before = moved;
        EXPECT_FALSE(step->run(pack, moved.pointers().at, by == 0 ? 0 : 12, kConverged, f));
        for (std::size_t i = 0; i < count; ++i) {
          const std::size_t at = pack.unknowns + i;
          const bool is_refused = by == 0 || i % lanes == 0;
          EXPECT_EQ(f.failed[i % lanes], is_refused ? 1 : 0);
          EXPECT_TRUE(test::same_bits(moved.values[0][at], (is_refused ? before : now).values[0][at]));
        }
      }
    }
    if (found.size() < 2) continue;
    for (int d : {0, 1, 2}) EXPECT_EQ(found[0].values[d], found[1].values[d]) << d;
    EXPECT_EQ(iterations[0], iterations[1]);
    EXPECT_EQ(figures[0].position, figures[1].position);
    EXPECT_EQ(figures[0].velocity, figures[1].velocity);
    EXPECT_EQ(figures[0].acceleration, figures[1].acceleration);
    EXPECT_EQ(figures[0].balls_last, figures[1].balls_last);
  }
  EXPECT_EQ(small, static_cast<int>(layout.packs.size()));
}

TEST(SmallStep, EqualsTheStepOfGroupSolver) {
  for (const char* lanes : {"lanes", "lanes:2", "lanes:4", "lanes:8", "lanes:16"}) {
    for (const char* scene : {"andrews", "four_bar:3", "stewart", "slider_crank", "scissor"}) {
      expect_the_same_step(sample(scene), std::string("irreducible/") + lanes);
    }
  }
}

// Code is made once for a class and a number of lanes.
TEST(SmallStep, SharesMachineCode) {
  PrepareOptions on{.strategy = "irreducible/lanes:8"}, off = on;
  off.machine_code = false;
  const Prepared prepared = prepare(sample("stewart"), on);
  const Preparation& p = preparation(prepared);
  EXPECT_EQ(p.code != nullptr, step_code() != nullptr);
  EXPECT_EQ(preparation(prepare(sample("stewart"), off)).code, nullptr);
  if (!p.code) GTEST_SKIP() << "this processor or this build has no machine code";
  const GroupClass& c = p.structure->classes[0];
  const BlockConditions blocks(c, 8);
  const auto eight = p.code->of(c, blocks.reads(0), 8).executor;
  ASSERT_NE(eight, nullptr);
  EXPECT_EQ(p.code->of(c, blocks.reads(0), 8).executor, eight);
  EXPECT_NE(p.code->of(c, blocks.reads(0), 4).executor, eight);
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
