// Figures of groups by a simulator, compared with closed forms and the true motion.
#include "measure/true_posture.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "assur/simulator.hpp"
#include "numbers.hpp"
#include "plan/preparation.hpp"
#include "simulation/simulator_access.hpp"

namespace assur::measure {
namespace {
constexpr double kSolved = 8 * kEps;  // residual of an equation that counts as solved

// C at distance 1 from A = (0, 0) and from B = (x, 0), which a driver moves: C = (x/2, h), h = sqrt(1 - x^2/4).
Scene dyad(double from, double rate) {
  return SceneBuilder("dyad", 2)
      .fixed_point("A", {0, 0})
      .point("B", {from, 0})
      .point("C", {from / 2, 1})
      .constrain("track", FixedCoordinate{"B.y", 0.0})
      .constrain("left", Distance{"A", "C", 1.0})
      .constrain("right", Distance{"B", "C", 1.0})
      .drive("push", DrivenCoordinate{"B.x", Law::polynomial({from, rate})})
      .time(0, 1, 0.1)
      .build();
}

TEST(Examined, ConditionGrowsAsTheDyadStretches) {
  // The larger row of |J^-1| grows like 1 / 2h. All other factors have limits at x = 2, which is at most 1e-3 away.
  const auto condition = [](double x) {
    Simulator simulator(prepare(dyad(x, -1e-3), {"groups/eigen"}));
    const std::vector<GroupFigures> all = simulator.examine();
    EXPECT_EQ(all.size(), 1u);
    return all.at(0).condition;
  };
  const auto h = [](double x) { return std::sqrt(1 - x * x / 4); };
  const double ratio = condition(1.99999) / condition(1.999);
  EXPECT_NEAR(ratio / (h(1.999) / h(1.99999)), 1, 0.01);
}

class Figures : public testing::TestWithParam<int> {};  // iterations; 0: as many as needed

TEST_P(Figures, DescribeThePosture) {
  const Prepared prepared = prepare(sample("four_bar:loops=2,steps=20"), {"groups/eigen+predict=taylor:0"});
  ASSERT_EQ(preparation(prepared).structure->levels, 2);  // the second level has fixed iterations
  Simulator simulator(prepared, {.iterations = GetParam()});
  std::optional<TruePosture> truth;
  try {
    truth.emplace(simulator.prepared());
  } catch (const Error& no_quad_precision) {
    GTEST_SKIP() << no_quad_precision.what();
  }
  double residual = 0, error = 0;
  const Trajectory motion = simulator.run([&](std::int64_t, std::int64_t) {
    const std::vector<GroupFigures> all = simulator.examine();
    const std::vector<SolvedGroup>& groups = preparation(prepared).structure->groups;
    const double wrong = truth->error(simulator.time(), SimulatorAccess::posture(simulator), groups.back().unknowns);
    EXPECT_LE(all.front().residual, kSolved);
    residual = std::max(residual, all.back().residual);
    error = std::max(error, wrong);
    // The residual of this loop, and the error of the previous loop times a condition. Both are at least a rounding.
    const double bound = 2 * (all.back().residual + kSolved) * all.front().condition;
    EXPECT_LE(wrong, 2 * bound * all.back().condition);
    return false;
  });
  ASSERT_EQ(motion.rows(), 21u);
  EXPECT_EQ(residual <= kSolved, GetParam() == 0);
  EXPECT_EQ(error <= 1e-12, GetParam() == 0);  // roundings; one iteration leaves about the square of 1e-3
}

INSTANTIATE_TEST_SUITE_P(, Figures, testing::Values(0, 1), testing::PrintToStringParamName());

}  // namespace
}  // namespace assur::measure
