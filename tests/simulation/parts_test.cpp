#include "side_by_side/parts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "assur/assur.hpp"
#include "index.hpp"

namespace assur {
namespace {

constexpr int kRows = 40;
// Rounding of two runs with other pivots, relative to lengths, rates and accelerations of about 1 to 40.
constexpr double kRounding = 1e-12;

void expect_same(double a, double b, const std::string& column) {
  EXPECT_NEAR(a, b, kRounding * std::max(1.0, std::abs(b))) << column;
}

Trajectory step_by_step(Simulator& simulator, const std::vector<double>& times) {
  return simulator.run(times, [](std::int64_t, std::int64_t) { return true; });
}

std::vector<double> first_times(const Scene& scene, int rows) {
  std::vector<double> times;
  for (int k = 0; k < rows; ++k) times.push_back(scene.time().time(k));
  return times;
}

// Each part alone moves as it does in the whole mechanism, and each column and unknown belongs to one part.
void expect_parts_of(const Scene& scene, const std::string& strategy) {
  const Prepared whole = prepare(scene, {strategy, {}});
  const std::vector<double> times = first_times(scene, kRows);
  Simulator all(whole);
  const Trajectory motion = step_by_step(all, times);
  Parts parts(whole, 300);
  ASSERT_GT(parts.count(), 1u) << strategy;
  std::size_t columns = 0, groups = 0;
  for (std::size_t p = 0; p < parts.count(); ++p) {
    Part part = parts.cut(p);
    groups += part.prepared.structure->groups.size();
    Simulator alone(std::move(part.prepared));
    const Trajectory moves = step_by_step(alone, times);
    ASSERT_EQ(moves.rows(), motion.rows());
    for (const auto& c : part.columns) {
      columns += c.count;
      for (std::size_t i = 0; i < c.count; ++i) {
        const std::string& name = motion.columns()[c.to + i];
        ASSERT_EQ(moves.columns()[c.from + i], name);
        expect_same(moves.last(name), motion.last(name), name);
      }
    }
  }
  EXPECT_EQ(columns, motion.columns().size());
  EXPECT_EQ(groups, whole.structure->groups.size());
}

TEST(Parts, MoveAsInTheWholeMechanism) {
  const Scene platforms = sample("stewart:platforms=16");
  for (const char* strategy : {"groups/lanes:4", "irreducible/lanes:4", "irreducible/lanes:4+together"}) {
    expect_parts_of(platforms, strategy);
  }
  std::vector<std::string> some;
  for (int p = 1; p <= 16; ++p) some.push_back((p % 2 == 0 ? "B1_" : "handle2_") + std::to_string(p));
  for (const char* column : {"B2_3.vx", "B2_3.y", "B5_16.acceleration"}) some.emplace_back(column);
  expect_parts_of(platforms.with_outputs(some), "groups/lanes:4");
}

TEST(Parts, AConnectedMechanismHasNone) {
  for (const char* connected : {"stewart", "four_bar:10", "rings:legs=8,n=30"}) {
    EXPECT_EQ(Parts(prepare(sample(connected), {"groups/lanes:4", {}}), 10).count(), 0u) << connected;
  }
}

TEST(Parts, DriversOfTheProgramForbidThem) {
  EXPECT_EQ(Parts(prepare(sample("stewart:platforms=16"), {"groups/lanes:4", {"pose_1"}}), 300).count(), 0u);
}

// 52,000 unknowns: the run takes part after part.
TEST(Parts, ALongRunTakesThemOneByOne) {
  const Scene scene = sample("stewart:platforms=512");
  const Prepared prepared = prepare(scene, {"groups/lanes:8", {}});
  const std::vector<double> times = first_times(scene, 4);
  Simulator whole(prepared), parted(prepared);
  const Trajectory expected = step_by_step(whole, times), motion = parted.run(times);
  ASSERT_EQ(motion.times(), expected.times());
  ASSERT_EQ(motion.columns(), expected.columns());
  double worst = 0;
  for (std::size_t r = 0; r < motion.rows(); ++r) {
    for (std::size_t c = 0; c < motion.columns().size(); ++c) {
      const double b = expected.row(r)[c];
      worst = std::max(worst, std::abs(motion.row(r)[c] - b) / std::max(1.0, std::abs(b)));
    }
  }
  EXPECT_LT(worst, kRounding);
  const Report &a = parted.report(), &b = whole.report();
  EXPECT_EQ(a.status.code, b.status.code);
  EXPECT_EQ(a.reached, b.reached);
  EXPECT_EQ(a.counters.steps, b.counters.steps);
  EXPECT_EQ(a.counters.group_solutions, b.counters.group_solutions);
  EXPECT_EQ(a.counters.stored_values, b.counters.stored_values);
  EXPECT_LT(a.error.residual(), 1e-14);
  // It goes on from there.
  const double next = scene.time().time(4);
  ASSERT_TRUE(parted.step(next).ok());
  ASSERT_TRUE(whole.step(next).ok());
  expect_same(parted.output("handle1_512"), whole.output("handle1_512"), "handle1_512");
}

// A step that must be divided: the run begins anew, and says so.
TEST(Parts, ARunThatIsRefusedIsReported) {
  const Scene scene = sample("stewart:platforms=512");
  const Prepared prepared = prepare(scene, {"groups/lanes:8", {}});
  const std::vector<double> times = {0, scene.time().time(1), scene.time().time(1) + 1};
  Simulator whole(prepared), parted(prepared);
  const Trajectory expected = step_by_step(whole, times), motion = parted.run(times);
  ASSERT_TRUE(whole.report().status.ok());
  EXPECT_TRUE(motion.values() == expected.values());
  const std::vector<std::string>& fallbacks = parted.report().fallbacks;
  EXPECT_TRUE(std::any_of(fallbacks.begin(), fallbacks.end(), [](const std::string& line) {
    return line.starts_with("not run in independent parts: a step had to be divided");
  }));
  EXPECT_EQ(parted.report().counters.steps, 2);
}

TEST(Parts, TheMotionIsBitwiseEqualForEveryNumberOfThreads) {
  const Scene scene = sample("stewart:platforms=512");
  const std::vector<double> times = first_times(scene, 3);
  RowValues expected;
  for (const std::string threads : {"1x1", "2x1", "3x1"}) {
    const Prepared prepared = prepare(scene, {.strategy = "groups/lanes:8 " + threads, .budget = ThreadBudget{3}});
    Simulator simulator(prepared);
    const Trajectory motion = simulator.run(times);
    ASSERT_EQ(motion.rows(), times.size());
    if (expected.empty()) expected = motion.values();
    EXPECT_TRUE(motion.values() == expected) << threads;
    EXPECT_TRUE(simulator.report().status.ok());
  }
}

}  // namespace
}  // namespace assur
