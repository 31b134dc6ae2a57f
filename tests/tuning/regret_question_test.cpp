// The contest for one question. Times depend on the machine, so the tests check properties that hold for every answer.
#include "tuning/regret_question.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace assur::tuning {
namespace {

TEST(PairedMedians, ASlowPassDoesNotChangeRatios) {
  const std::vector<std::vector<double>> seconds = {{3, 2, 1}, {3.3, 1.8, 1}, {6, 4, 2}};
  const std::vector<double> all = paired_medians(seconds);
  ASSERT_EQ(all.size(), 3u);
  EXPECT_DOUBLE_EQ(all[0], 3);
  EXPECT_DOUBLE_EQ(all[1], 2);
  EXPECT_DOUBLE_EQ(all[2], 1);
  EXPECT_TRUE(paired_medians({}).empty());
}

// A runner without a turn in a pass is not the fastest of that pass.
TEST(PairedMedians, MissingTurnsCountAsSlow) {
  const std::vector<double> all = paired_medians({{0.5, 1}, {HUGE_VAL, 1}, {HUGE_VAL, 1}});
  EXPECT_EQ(all[0], HUGE_VAL);
  EXPECT_EQ(all[1], 1);
}

TEST(Contest, CombinesAllPasses) {
  const QuestionOptions quick{.quick = true, .seconds = 0.5};
  std::optional<Contest> contest = Contest::open({"slider_crank", {}, 1}, quick);
  ASSERT_TRUE(contest);
  ASSERT_TRUE(contest->race());
  const std::size_t once = contest->answer().chosen.rounds;
  ASSERT_TRUE(contest->race());
  const Answer answer = contest->answer();
  EXPECT_GT(once, 0u);
  EXPECT_GT(answer.chosen.rounds, once);
  EXPECT_GE(answer.regret(), 0);
  EXPECT_LE(answer.best.seconds, answer.chosen.seconds);
  EXPECT_EQ(answer.again.strategy, answer.chosen.strategy);
  EXPECT_LT(answer.chosen.error, 1e-9);
  EXPECT_FALSE(answer.uniform.empty());
}

TEST(Contest, IgnoresStoppedPasses) {
  QuestionOptions how{.quick = true, .seconds = 0.5};
  bool stopped = false;
  how.instruments.stop = [&] { return stopped; };
  std::optional<Contest> contest = Contest::open({"slider_crank", {}, 1}, how);
  ASSERT_TRUE(contest);
  ASSERT_TRUE(contest->race());
  const std::size_t once = contest->answer().chosen.rounds;
  stopped = true;
  EXPECT_FALSE(contest->race());
  EXPECT_EQ(contest->answer().chosen.rounds, once);
  EXPECT_FALSE(Contest::open({"slider_crank", {}, 1}, how));
}

}  // namespace
}  // namespace assur::tuning
