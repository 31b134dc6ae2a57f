#include "parallel/longest_first.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "assur/status.hpp"

namespace assur::test {
namespace {

using Packs = std::vector<std::int32_t>;

Packs of(const Shares& shares, int thread) {
  const auto span = shares.of(thread);
  return {span.begin(), span.end()};
}

// Finds the optimum by trying all assignments.
double optimum(const std::vector<double>& cost, std::vector<double>& load, std::size_t pack = 0) {
  if (pack == cost.size()) return *std::max_element(load.begin(), load.end());
  double best = std::numeric_limits<double>::infinity();
  for (double& l : load) {
    l += cost[pack];
    best = std::min(best, optimum(cost, load, pack + 1));
    l -= cost[pack];
  }
  return best;
}

// Costs are whole numbers, so that sums are exact and the bound holds without a tolerance.
TEST(LongestFirst, IsWithinGrahamsBoundOfTheOptimum) {
  std::mt19937_64 random(7);
  for (int threads = 1; threads <= 4; ++threads) {
    for (int trial = 0; trial < 200; ++trial) {
      std::vector<double> cost(random() % 8);
      for (double& c : cost) c = static_cast<double>(random() % 20);
      std::vector<double> load(static_cast<std::size_t>(threads), 0.0);
      const double best = optimum(cost, load);
      const Shares shares = longest_first(cost, threads);
      EXPECT_GE(shares.makespan, best);
      EXPECT_LE(3 * threads * shares.makespan, (4 * threads - 1) * best);
    }
  }
}

// These are the examples by Graham for two and for three threads.
TEST(LongestFirst, ReachesTheBoundWhereItIsTight) {
  EXPECT_EQ(longest_first(std::vector<double>{3, 3, 2, 2, 2}, 2).makespan, 7);         // best: 6
  EXPECT_EQ(longest_first(std::vector<double>{5, 5, 4, 4, 3, 3, 3}, 3).makespan, 11);  // best: 9
}

TEST(LongestFirst, AssignsEveryPackOnceAndReturnsTheLongestShare) {
  std::mt19937_64 random(8);
  std::vector<double> cost(1000);
  for (double& c : cost) c = static_cast<double>(random() % 1000);
  for (int threads : {1, 2, 7, 64}) {
    const Shares shares = longest_first(cost, threads);
    ASSERT_EQ(shares.start.size(), static_cast<std::size_t>(threads) + 1);
    Packs all = shares.pack;
    std::sort(all.begin(), all.end());
    Packs expected(cost.size());
    std::iota(expected.begin(), expected.end(), 0);
    EXPECT_EQ(all, expected);
    double longest = 0;
    for (int t = 0; t < threads; ++t) {
      double sum = 0;
      for (const std::int32_t pack : shares.of(t)) sum += cost[static_cast<std::size_t>(pack)];
      longest = std::max(longest, sum);
    }
    EXPECT_EQ(shares.makespan, longest);
    EXPECT_EQ(longest_first(cost, threads).pack, shares.pack);
  }
}

TEST(LongestFirst, AssignsEqualPacksInTurn) {
  for (double cost : {1.0, 0.0}) {  // 0: unknown costs
    const Shares shares = longest_first(std::vector<double>(5, cost), 2);
    EXPECT_EQ(of(shares, 0), (Packs{0, 2, 4}));
    EXPECT_EQ(of(shares, 1), (Packs{1, 3}));
  }
}

TEST(LongestFirst, FewerPacksThanThreadsLeaveSomeWithoutWork) {
  const Shares shares = longest_first(std::vector<double>{1, 2}, 3);
  EXPECT_EQ(of(shares, 0), Packs{1});
  EXPECT_EQ(of(shares, 1), Packs{0});
  EXPECT_EQ(of(shares, 2), Packs{});
  EXPECT_EQ(longest_first({}, 2).makespan, 0);
}

TEST(LongestFirst, RefusesInvalidCosts) {
  EXPECT_THROW((void)longest_first(std::vector<double>{1}, 0), Error);
  for (double bad : {-1.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    try {
      (void)longest_first(std::vector<double>{1, bad}, 2);
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).rfind("the cost of pack 1 must be a number >= 0, not ", 0), 0u);
    }
  }
}

}  // namespace
}  // namespace assur::test
