// The groups of all levels at once: the same motion as level after level, the same limits, and the same state after
// going back.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "backends/allocations.hpp"
#include "errors/conditions.hpp"
#include "files/shipped_files.hpp"
#include "groups/coupling.hpp"
#include "index.hpp"
#include "motion/limited.hpp"
#include "numbers.hpp"
#include "plan/preparation.hpp"
#include "properties/random_chains.hpp"
#include "properties/random_count.hpp"
#include "simulation/towers.hpp"

namespace assur {
namespace {

using test::Draw;
using test::Result;

constexpr const char* kLevels = "irreducible/lanes:8";
constexpr const char* kTogether = "irreducible/lanes:8+together";

// "": the strategy can solve the scene.
std::string refusal(const Scene& scene, const std::string& strategy) {
  try {
    (void)prepare(scene, {strategy, {}});
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), Error::Kind::environment) << e.what();
    return e.what();
  }
  return "";
}

bool solved_level_after_level(const Result& r) {
  return std::any_of(r.report().fallbacks.begin(), r.report().fallbacks.end(),
                     [](const std::string& f) { return f.find("level after level") != f.npos; });
}

// Compares whole runs. 8 eps of the criterion of convergence, with the condition of each posture.
void expect_the_same_run(const Scene& scene, const std::string& with, const std::string& without) {
  SCOPED_TRACE(scene.name() + " " + with);
  const Result levels = test::run(scene, without), together = test::run(scene, with);
  EXPECT_EQ(together.report().status.code, levels.report().status.code);
  const std::vector<Event> expected = test::events(levels.report()), found = test::events(together.report());
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].kind, expected[i].kind);
    EXPECT_EQ(found[i].group, expected[i].group);
  }
  ASSERT_EQ(together.trajectory.rows(), levels.trajectory.rows());
  const std::vector<double> all = test::conditions(scene, levels.trajectory.times(), 5);
  const double residual = test::residual_of(levels.report(), together.report());
  EXPECT_LE(residual, 1e-13);
  const test::Sizes size = test::sizes(levels.trajectory);
  for (std::size_t k = 0; k < std::min(all.size(), levels.trajectory.rows()); ++k) {
    test::expect_same_row(levels.trajectory.row(k), together.trajectory, k, size, all[k], residual);
    if (testing::Test::HasFailure()) return;
  }
}

TEST(Together, MovesSamplesAsLevelsDo) {
  for (const std::string text : {"four_bar:1", "four_bar:3", "four_bar:10", "four_bar:100", "n_four_bar:40", "stewart",
                                 "andrews", "slider_crank", "stewart:platforms=3"}) {
    const Scene whole = sample(text);
    const TimeGrid grid = whole.time();
    const Scene scene = whole.with_time({grid.start, grid.time(std::min<std::int64_t>(grid.steps(), 200)), grid.step});
    for (const std::string lanes : {":4", ":8", ":16"}) {
      expect_the_same_run(scene, "irreducible/lanes" + lanes + "+together", kLevels);
      EXPECT_FALSE(solved_level_after_level(test::run(scene, "irreducible/lanes" + lanes + "+together"))) << text;
    }
    for (const std::string predictor : {"+predict=taylor:2", "+predict=past:3"}) {
      expect_the_same_run(scene, kTogether + predictor, kLevels + predictor);
    }
    if (testing::Test::HasFailure()) return;
  }
}

TEST(Together, NeedsAsManyIterationsInLongChains) {
  const Scene scene = sample("four_bar:100");
  const Result levels = test::run(scene, std::string(kLevels) + "+predict=hermite:5");
  const Result together = test::run(scene, std::string(kTogether) + "+predict=hermite:5");
  ASSERT_TRUE(together.report().status.ok());
  const auto mean = [](const Result& r) {
    return static_cast<double>(r.counters().newton_iterations) / static_cast<double>(r.counters().group_solutions);
  };
  EXPECT_GT(mean(together), 0.9);
  EXPECT_LE(mean(together), mean(levels) + 0.2);
  EXPECT_FALSE(solved_level_after_level(together));
}

TEST(Together, MovesShippedScenesAsLevelsDoOrSaysWhyNot) {
  int moved = 0;
  for (const auto& file : test::shipped_files()) {
    const Scene whole = read_scene(file);
    const TimeGrid grid = whole.time();
    const Scene scene = whole.with_time({grid.start, grid.start + 20 * grid.step, grid.step});
    if (preparation(prepare(scene)).structure->groups.empty()) continue;
    if (const std::string why = refusal(scene, kTogether); !why.empty()) {
      EXPECT_NE(why.find("needs groups of up to 24 unknowns"), why.npos) << why;
      continue;
    }
    ++moved;
    expect_the_same_run(scene, kTogether, kLevels);
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_GE(moved, 3);
}

TEST(Together, MovesRandomMechanismsAsLevelsDo) {
  const int all = test::random_count(120);
  int moved = 0;
  for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(all); ++seed) {
    Draw draw(seed);
    const Scene scene = seed % 2 == 0 ? test::planar_mechanism(draw) : test::spatial_mechanism(draw);
    const std::string with = seed % 3 == 0 ? "irreducible/lanes:16+together" : kTogether;
    if (!refusal(scene, with).empty()) continue;
    ++moved;
    SCOPED_TRACE("seed " + std::to_string(seed));
    expect_the_same_run(scene, with, kLevels);
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_GE(moved, all / 3);
}

// Random dyads, each on an earlier one, whose driver makes a full turn: most reach a limit.
Scene chain_of_dyads(Draw& draw, std::size_t dyads) {
  SceneBuilder b("chain", 2);
  std::vector<test::Placed> moving = {{"B", test::turning_crank(b, draw)}};
  for (std::size_t i = 0; i < dyads; ++i) {
    const std::string k = std::to_string(i);
    const test::Placed on = draw.below(3) == 0 ? draw.of(moving) : moving.back();
    const double direction = draw.real(-3, 3), across = direction + draw.real(1, 2.1), reach = draw.real(1.5, 3);
    const Triple at = {on.at[0] + reach * std::cos(direction), on.at[1] + reach * std::sin(direction), 0};
    b.point("C" + k, at);
    b.constrain("bar" + k, Distance{on.name, "C" + k, std::nullopt});
    const test::Placed second = draw.of(moving);
    if (draw.below(4) == 0 && second.name != on.name) {
      b.constrain("rod" + k, Distance{second.name, "C" + k, std::nullopt});
    } else {
      const double away = draw.real(2, 4);
      b.fixed_point("D" + k, {at[0] - away * std::cos(across), at[1] - away * std::sin(across), 0});
      b.constrain("rod" + k, Distance{"D" + k, "C" + k, std::nullopt});
    }
    moving.push_back({"C" + k, at});
  }
  return b.time(0, 1, 0.005).build();
}

// Points on three spheres, about the three points before them, about points of moving bodies, and about fixed points.
Scene chain_of_tripods(int tripods) {
  SceneBuilder b("tripods", 3);
  b.fixed_point("O", {0, 0, 0}).fixed_point("P", {1, 0, 0}).fixed_point("Q", {0, 1, 0}).point("C0", {0.3, 0.3, 1});
  b.drive("x", DrivenCoordinate{"C0.x", Law::harmonics({{0.02, 3, 0}}, 0.3)});
  b.drive("y", DrivenCoordinate{"C0.y", Law::harmonics({{0.02, 2, 1}}, 0.3)});
  b.drive("z", DrivenCoordinate{"C0.z", Law::harmonics({{0.02, 1, 2}}, 1)});
  std::vector<std::string> points = {"O", "P", "Q", "C0"};
  std::vector<Triple> at = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, 1}};
  for (int k = 1; k <= tripods; ++k) {
    const std::string name = "C" + std::to_string(k);
    const std::size_t last = points.size() - 1;
    const Triple& a = at[last];
    at.push_back({a[0] + 0.4 * std::cos(k), a[1] + 0.4 * std::sin(k), a[2] + 0.5});
    b.point(name, at.back());
    for (std::size_t leg = 0; leg < 3; ++leg) {
      b.constrain(name + "_" + std::to_string(leg), Distance{points[last - leg], name, std::nullopt});
    }
    points.push_back(name);
  }
  return b.time(0, 1, 0.01).build();
}

TEST(Together, MovesTripodsAndLegsAsOtherStepsDo) {
  for (const std::string with : {"irreducible/lanes:4+together", kTogether, "irreducible/lanes:16+together"}) {
    for (const Scene& scene : {chain_of_tripods(10), sample("jansen:4")}) {
      expect_the_same_run(scene, with, "irreducible/eigen");
      EXPECT_FALSE(solved_level_after_level(test::run(scene, with))) << with;
    }
  }
}

// Groups that need pivots.
TEST(Together, MovesTowersAsLevelsDo) {
  for (const int dimension : {2, 3}) {
    const Scene scene = test::tower(dimension, 11, dimension == 2 ? 3 : 1);
    std::int32_t most = 0;
    const Prepared prepared = prepare(scene, {kTogether, {}});
    for (const GroupClass& c : preparation(prepared).structure->classes) most = std::max(most, c.n);
    EXPECT_EQ(most, dimension == 2 ? 4 : 9);
    for (const std::string with : {"irreducible/lanes:4+together", kTogether, "irreducible/lanes:16+together"}) {
      ASSERT_EQ(refusal(scene, with), "");
      expect_the_same_run(scene, with, "irreducible/eigen");
      EXPECT_FALSE(solved_level_after_level(test::run(scene, with))) << with;
    }
  }
}

TEST(Together, EndsWhereLevelsEnd) {
  const int all = test::random_count(60);
  int stopped = 0, moved = 0;
  for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(all); ++seed) {
    Draw draw(seed);
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Scene scene = chain_of_dyads(draw, 1 + draw.below(12));
    ASSERT_EQ(refusal(scene, kTogether), "");
    const Result levels = test::run(scene, kLevels), together = test::run(scene, kTogether);
    EXPECT_EQ(together.report().status.code, levels.report().status.code);
    EXPECT_EQ(together.trajectory.rows(), levels.trajectory.rows());
    EXPECT_NEAR(together.report().reached, levels.report().reached, 1e-6);
    EXPECT_EQ(test::events(together.report()).size(), test::events(levels.report()).size());
    ++(levels.report().status.arrived() ? moved : stopped);
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_GE(stopped, all / 3);
  EXPECT_GE(moved, all / 20);
}

TEST(Together, ReportsTheFoldAndTheAttemptsLevelAfterLevel) {
  const Scene scene = test::limited_four_bar(Law::polynomial({0.5, 1})).time(0, 2, 0.01).build();
  expect_the_same_run(scene, kTogether, kLevels);
  const Result r = test::run(scene, kTogether);
  EXPECT_EQ(r.report().status.code, Code::fold);
  EXPECT_TRUE(solved_level_after_level(r));
}

TEST(Together, PassesChangePointsAndRedundantEquations) {
  for (const std::string text : {"almost_parallelogram:delta=1e-4", "parallelograms:3"}) {
    const Scene scene = sample(text);
    if (refusal(scene, kTogether).empty()) expect_the_same_run(scene, kTogether, kLevels);
  }
}

// An equation that reads two earlier groups: the dyad hangs on a member of a body between two dyads.
TEST(Together, CouplesAGroupToTwoOthers) {
  SceneBuilder b("bridge", 2);
  b.fixed_point("A", {0, 0, 0}).point("M", {0.3, 0, 0});
  b.drive("motor", PointAngle{"A", "M", "", Law::polynomial({0, 1.5})});
  b.fixed_point("D", {2, -0.5, 0}).point("P", {1.2, 0.8, 0});
  b.constrain("mp", Distance{"M", "P", std::nullopt}).constrain("dp", Distance{"D", "P", std::nullopt});
  b.fixed_point("E", {-0.5, 2.5, 0}).point("Q", {0.8, 1.9, 0});
  b.constrain("pq", Distance{"P", "Q", std::nullopt}).constrain("eq", Distance{"E", "Q", std::nullopt});
  Body bridge{"bridge", "", {}, {"P", "Q"}, {}, {}};
  bridge.points.push_back({"R", {0.5, 0.4, 0}});
  b.add(std::move(bridge));
  b.fixed_point("F", {3, 2, 0}).point("S", {2.2, 2.6, 0});
  b.constrain("rs", Distance{"R", "S", std::nullopt}).constrain("fs", Distance{"F", "S", std::nullopt});
  const Scene scene = b.time(0, 2, 0.01).build();
  ASSERT_EQ(refusal(scene, kTogether), "");
  expect_the_same_run(scene, kTogether, kLevels);
  EXPECT_FALSE(solved_level_after_level(test::run(scene, kTogether)));
}

TEST(Together, RepeatsItsMotionAfterGoingBack) {
  const Scene scene = sample("four_bar:20");
  const Prepared prepared = prepare(scene, {kTogether, {}});
  Simulator s(prepared), other(prepared);
  for (int k = 0; k < 30; ++k) ASSERT_TRUE(s.step().arrived());
  const SimulatorState kept = s.save();
  const auto go = [&] {
    std::vector<double> rows;
    for (int k = 0; k < 100; ++k) {
      EXPECT_TRUE(s.step().arrived());
      rows.insert(rows.end(), s.outputs().begin(), s.outputs().end());
    }
    return rows;
  };
  const std::vector<double> first = go();
  s.restore(kept);
  EXPECT_EQ(go(), first);
  other.restore(kept);
  for (int k = 0; k < 100; ++k) ASSERT_TRUE(other.step().arrived());
  EXPECT_TRUE(std::equal(other.outputs().begin(), other.outputs().end(), first.end() - std::ssize(other.outputs())));
}

TEST(Together, FixedIterationsAreSolvedLevelAfterLevel) {
  const Scene scene = sample("four_bar:5");
  const Result r = test::run(scene, kTogether, {.iterations = 2});
  ASSERT_TRUE(r.report().status.ok());
  EXPECT_TRUE(solved_level_after_level(r));
}

TEST(Together, AllocatesNothing) {
  for (const Scene& scene : {sample("four_bar:64"), sample("stewart"), sample("almost_parallelogram:delta=1e-4"),
                             test::tower(2, 11, 3), test::tower(3, 11, 1)}) {
    Simulator s = test::simulator(scene, kTogether);
    for (int k = 1; k <= 2; ++k) ASSERT_TRUE(s.step(scene.time().time(k)).arrived());
    const std::int64_t before = test::allocations();
    for (int k = 3; k <= 60; ++k) ASSERT_TRUE(s.step(scene.time().time(k)).arrived());
    EXPECT_EQ(test::allocations() - before, 0) << scene.name();
  }
}

TEST(Together, IsRefusedWithTheReason) {
  const Scene chain = sample("four_bar:5"), stewart = sample("stewart");
  const auto says = [](const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), text.npos) << text << "\nlacks: " << part;
  };
  says(refusal(stewart, "groups/lanes:8+together"), "group SG_T can be divided further; leave out +together");
  says(refusal(test::tower(3, 2, 6), kTogether),
       "equations that read other groups, but group P2_0+P2_2+P2_4 has 6 of them");
  says(refusal(chain, "irreducible/klu:8+together"), "needs the solver lanes without");
  says(refusal(chain, "irreducible/lanes:8+once+together"), "needs the solver lanes without");
  says(refusal(chain, "irreducible/lanes:2+together"), "takes 4, 8 or 16 lanes");
}

// Every count, against a loop in extended precision. A rounding of a load is at most epsilon times the sum of the
// absolute values that were added up to it, for each of the few operations of a row.
TEST(ChainOfLoads, AddsGainTimesTheLoadBefore) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> number(-1, 1);
  for (const double largest_gain : {0.0, 0.5, 1.0, 3.0}) {
    for (std::int32_t count = 0; count <= 40; ++count) {
      std::vector<double> gains, loads;
      for (std::int32_t i = 0; i < count; ++i) {
        gains.push_back(largest_gain * number(random));
        loads.push_back(number(random));
      }
      const double behind = number(random), before = number(random);
      long double load = before, size = std::abs(before);
      std::vector<long double> expected, sizes;
      for (std::int32_t i = 0; i < count; ++i) {
        load = loads[idx(i)] + static_cast<long double>(gains[idx(i)]) * load;
        size = std::abs(loads[idx(i)]) + std::abs(static_cast<long double>(gains[idx(i)])) * size;
        expected.push_back(load);
        sizes.push_back(size);
      }
      loads.push_back(behind);
      coupling_kernels().chain(gains.data(), before, count, loads.data());
      for (std::int32_t i = 0; i < count; ++i) {
        const auto error = std::abs(static_cast<long double>(loads[idx(i)]) - expected[idx(i)]);
        EXPECT_LE(static_cast<double>(error / sizes[idx(i)]), 4 * (i + 1) * kEps) << i << " of " << count;
      }
      EXPECT_EQ(loads.back(), behind);
    }
  }
}

}  // namespace
}  // namespace assur
