// Order and number of runs in a race, on a clock that only the test advances.
#include "measure/race.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <set>
#include <utility>

#include "measure/laboratory.hpp"
#include "median.hpp"

namespace assur::measure {
namespace {

class RaceTest : public testing::Test {
 protected:
  Timed& enter(double seconds, int share = 1, int heat = 0) {
    work_.push_back(std::make_unique<Timed>(laboratory_, seconds));
    Runner runner;
    runner.work = work_.back().get();
    runner.share = share;
    runner.heat = heat;
    runners_.push_back(runner);
    return *work_.back();
  }
  RaceFigures hold(const RaceRules& rules = {}) { return race(runners_, rules, laboratory_.instruments()); }

  Laboratory laboratory_;
  std::vector<std::unique_ptr<Timed>> work_;
  std::vector<Runner> runners_;
};

TEST_F(RaceTest, DoublesCallsUntilABlockIsLongEnough) {
  const Timed& work = enter(1.5e-6);
  hold();
  EXPECT_EQ(runners_[0].calls, 16);  // 24 us
  EXPECT_TRUE(std::equal(work.blocks.begin(), work.blocks.begin() + 5, std::vector<int>{1, 2, 4, 8, 16}.begin()));
  EXPECT_NEAR(runners_[0].median(), 1.5e-6, 1e-13);  // the clock resolves 1.1e-13 s at 1000 s; 16 calls
}

TEST_F(RaceTest, EveryRoundRunsEachOnceInAnotherOrder) {
  for (int i = 0; i < 5; ++i) enter(30e-6);  // one call a block; blocks before the rounds are not kept
  RaceRules rules;
  rules.least_rounds = rules.most_rounds = 12;
  hold(rules);
  std::set<std::vector<std::size_t>> orders;
  for (std::size_t round = 0; round < 12; ++round) {
    std::vector<std::pair<double, std::size_t>> turns;
    for (std::size_t i = 0; i < work_.size(); ++i) {
      ASSERT_EQ(runners_[i].seconds.size(), 12u);
      turns.emplace_back(work_[i]->ends[round + 1], i);  // 0 is the search for the block
    }
    std::sort(turns.begin(), turns.end());
    EXPECT_NEAR(turns.back().first - turns.front().first, 4 * 30e-6, 1e-9);  // no other turn in between
    std::vector<std::size_t> order;
    for (const auto& [end, i] : turns) order.push_back(i);
    orders.insert(order);
  }
  EXPECT_GE(orders.size(), 10u);  // of 120 possible orders
}

TEST_F(RaceTest, HopelessRunnersLeaveAndKeepTheirTimes) {
  enter(30e-6);
  enter(80e-6);
  enter(100e-6);
  hold();
  EXPECT_FALSE(runners_[1].hopeless);
  EXPECT_TRUE(runners_[2].hopeless);  // more than three times as slow as the leader
  EXPECT_EQ(runners_[2].seconds.size(), 3u);
  EXPECT_GE(runners_[1].seconds.size(), 7u);
}

// The machine is slow for half of the time.
TEST_F(RaceTest, CorrectsTimesToTheUsualPace) {
  enter(30e-6);
  enter(33e-6);
  enter(30e-6);
  runners_[2].by_the_clock = true;
  Instruments with = laboratory_.instruments();
  with.stop = [&] {
    laboratory_.slow = std::fmod(laboratory_.now, 0.016) < 0.008 ? 1 : 1.8;
    return false;
  };
  RaceRules rules;
  rules.least_rounds = rules.most_rounds = 1000;
  const RaceFigures figures = race(runners_, rules, with);
  EXPECT_NEAR(runners_[0].median(), 30e-6, 1e-9);
  EXPECT_NEAR(runners_[1].median(), 33e-6, 1e-9);
  EXPECT_LT(runners_[0].spread(), 1e-9);
  EXPECT_EQ(runners_[2].seconds, runners_[2].raw);
  EXPECT_EQ(runners_[2].slowness(), 1);
  ASSERT_EQ(runners_[0].raw.size(), runners_[0].seconds.size());
  EXPECT_NEAR(runners_[0].slowness() * runners_[0].median(), median(runners_[0].raw), 1e-12);
  EXPECT_TRUE(figures.slowness == 1 || figures.slowness == 1.8) << figures.slowness;
}

TEST_F(RaceTest, FasterWiderRunnersDoNotEliminateNarrowOnes) {
  enter(100e-6, 1);
  enter(100e-6, 8);   // eight times as fast for one result
  enter(4000e-6, 8);  // slower than the narrow one
  hold();
  EXPECT_FALSE(runners_[0].hopeless);
  EXPECT_FALSE(runners_[1].hopeless);
  EXPECT_TRUE(runners_[2].hopeless);
}

TEST_F(RaceTest, ComparesRunnersWithinTheirHeatOnly) {
  enter(30e-6, 1, 0);
  enter(3000e-6, 1, 1);
  hold();
  EXPECT_FALSE(runners_[1].hopeless);
}

TEST_F(RaceTest, KeepsToItsTime) {
  for (int i = 0; i < 4; ++i) enter(0.01);
  RaceRules rules;
  rules.seconds = 0.2;
  const double begin = laboratory_.now;
  hold(rules);
  EXPECT_LE(laboratory_.now - begin, 0.2 + 0.01 + 1e-9);  // a block that has begun is completed
  for (const Runner& r : runners_) EXPECT_GE(r.seconds.size(), 4u);
}

TEST_F(RaceTest, RunsALongCallOnlyOnce) {
  const Timed& slow = enter(0.1);
  enter(30e-6);
  RaceRules rules;
  rules.seconds = 0.2;
  hold(rules);
  EXPECT_EQ(slow.blocks.size(), 1u);
  ASSERT_EQ(runners_[0].seconds.size(), 1u);
  EXPECT_EQ(runners_[0].spread(), runners_[0].seconds[0]);  // unknown, so as large as the time
}

TEST_F(RaceTest, FastRunnersHaveATimeEvenWithoutARound) {
  enter(1e-6);
  enter(0.3);
  RaceRules rules;
  rules.seconds = 0.1;
  hold(rules);
  ASSERT_EQ(runners_[0].seconds.size(), 1u);
  ASSERT_EQ(runners_[1].seconds.size(), 1u);
  EXPECT_LT(runners_[0].median(), runners_[1].median());
}

TEST_F(RaceTest, RepeatsDisturbedBlocks) {
  // This work loses the processor in every third block.
  class Disturbed final : public Timed {
   public:
    explicit Disturbed(Laboratory& laboratory) : Timed(laboratory, 30e-6), laboratory_(laboratory) {}
    bool run(int calls) override {
      if (blocks.size() % 3 == 2) {
        ++laboratory_.switches;
        laboratory_.now += 1e-3;
      }
      return Timed::run(calls);
    }

   private:
    Laboratory& laboratory_;
  };
  Disturbed disturbed(laboratory_);
  runners_.emplace_back().work = &disturbed;
  const RaceFigures figures = hold();
  EXPECT_GT(figures.disturbed, 0);
  for (const double s : runners_[0].seconds) EXPECT_NEAR(s, 30e-6, 1e-9);
}

// Blocks of one thread are never uneven, and all counted blocks include the repeated ones, even if time runs out.
TEST_F(RaceTest, CountsNoMoreDisturbancesThanBlocks) {
  class Disturbed final : public Timed {
   public:
    explicit Disturbed(Laboratory& laboratory) : Timed(laboratory, 30e-6), laboratory_(laboratory) {}
    bool run(int calls) override {
      ++laboratory_.switches;
      return Timed::run(calls);
    }

   private:
    Laboratory& laboratory_;
  };
  laboratory_.unevenness = 2;
  for (const double seconds : {3e-4, 1e-3, 5e-3, 0.5}) {
    runners_.clear();
    std::vector<std::unique_ptr<Disturbed>> work;
    for (int i = 0; i < 6; ++i) {
      work.push_back(std::make_unique<Disturbed>(laboratory_));
      runners_.push_back({.work = work.back().get(), .threads = i == 0 ? 2 : 1});
    }
    RaceRules rules;
    rules.seconds = seconds;
    const RaceFigures figures = hold(rules);
    EXPECT_GT(figures.disturbed, 0) << seconds;
    EXPECT_LE(figures.disturbed, figures.blocks) << seconds;
    EXPECT_LE(figures.uneven, figures.shared) << seconds;
  }
}

// One core runs at half its pace for three of six milliseconds, and the threads wait for this core.
TEST_F(RaceTest, UsesOnlyTimesOnEvenCoresForSeveralThreads) {
  const auto uneven = [this] { return std::fmod(laboratory_.now, 6e-3) < 3e-3; };
  class Shared final : public Timed {
   public:
    Shared(Laboratory& laboratory, std::function<bool()> uneven)
        : Timed(laboratory, 30e-6), laboratory_(laboratory), uneven_(std::move(uneven)) {}
    bool run(int calls) override {
      laboratory_.slow = uneven_() ? 2 : 1;
      const bool ok = Timed::run(calls);
      laboratory_.slow = 1;
      return ok;
    }

   private:
    Laboratory& laboratory_;
    std::function<bool()> uneven_;
  };
  int looks = 0;
  Instruments instruments = laboratory_.instruments();
  instruments.unevenness = [&] {
    laboratory_.now += 100e-6;
    ++looks;
    return uneven() ? 1.9 : 1.1;
  };
  RaceRules rules;
  rules.least_rounds = rules.most_rounds = 30;
  Shared shared(laboratory_, uneven);
  runners_.push_back({.work = &shared, .threads = 2});
  const RaceFigures figures = race(runners_, rules, instruments);
  EXPECT_EQ(runners_[0].seconds.size(), 30u);
  for (const double s : runners_[0].seconds) EXPECT_NEAR(s, 30e-6, 1e-9);
  EXPECT_GE(looks, 60);  // before and after each block
  EXPECT_GE(figures.shared, 30);
  EXPECT_EQ(figures.shared - figures.uneven, 30);  // all but the uneven ones

  runners_[0].threads = 1;
  looks = 0;
  (void)race(runners_, rules, instruments);
  EXPECT_EQ(looks, 0);
}

// If cores never have the same pace, the race goes on: times on uneven cores are better than none.
TEST_F(RaceTest, StopsWaitingForCoresThatStayUneven) {
  laboratory_.unevenness = 2;
  enter(30e-6);
  runners_[0].threads = 2;
  const RaceFigures figures = hold();
  EXPECT_GE(runners_[0].seconds.size(), 7u);
  EXPECT_GT(figures.uneven, 0);
  EXPECT_EQ(figures.uneven, figures.shared);
}

TEST_F(RaceTest, TakesUnevenCoresAsTheyAreIfTold) {
  for (const bool awaits : {true, false}) {
    int looks = 0;
    runners_.clear();
    enter(30e-6);
    runners_[0].threads = 2;
    Instruments instruments = laboratory_.instruments();
    instruments.unevenness = [&looks] { return ++looks, 2.0; };
    RaceRules rules;
    rules.awaits_even = awaits;
    rules.least_rounds = rules.most_rounds = 7;
    const RaceFigures figures = race(runners_, rules, instruments);
    EXPECT_EQ(runners_[0].seconds.size(), 7u);
    EXPECT_EQ(figures.uneven, figures.shared);
    EXPECT_EQ(figures.shared == 7, !awaits);  // nothing is repeated
    EXPECT_EQ(looks == 7, !awaits);
    EXPECT_NEAR(figures.timed, 30e-6 * static_cast<double>(figures.blocks + 1), 1e-9);  // one more found its length
  }
}

// Runners that would not get all of their blocks do not start, so that the others have theirs.
TEST_F(RaceTest, StartsOnlyRunnersThatGetAllTheirBlocks) {
  for (const int least : {1, 3}) {
    runners_.clear();
    for (const double seconds : {30e-6, 0.2, 40e-6}) enter(seconds);
    RaceRules rules;
    rules.seconds = 0.5;
    rules.least_blocks = least;
    hold(rules);
    EXPECT_GE(runners_[0].seconds.size(), 7u) << least;
    EXPECT_EQ(runners_[1].seconds.size(), least == 1 ? 1u : 0u);
    EXPECT_GE(runners_[2].seconds.size(), 7u) << least;
  }
}

TEST_F(RaceTest, FailedRunnersHaveNoTimes) {
  class Failing final : public Timed {
   public:
    using Timed::Timed;
    bool run(int calls) override { return Timed::run(calls) && blocks.size() < 5; }
  };
  Failing failing(laboratory_, 30e-6);
  runners_.emplace_back().work = &failing;
  enter(30e-6);
  hold();
  EXPECT_TRUE(runners_[0].failed);
  EXPECT_TRUE(runners_[0].seconds.empty());
  EXPECT_EQ(failing.blocks.size(), 5u);
  EXPECT_FALSE(runners_[1].failed);
}

TEST_F(RaceTest, StopsWhenAsked) {
  enter(30e-6);
  laboratory_.stopped = true;
  hold();
  EXPECT_TRUE(runners_[0].seconds.empty());
}

TEST(Runner, ReportsTheSlownessOfTheMachine) {
  Runner r;
  EXPECT_EQ(r.slowness(), 1);
  r.seconds = {10e-6, 11e-6, 12e-6};
  r.raw = {20e-6, 22e-6, 24e-6};
  EXPECT_DOUBLE_EQ(r.slowness(), 2);
}

TEST(Runner, ComputesMedianAndDeviation) {
  Runner r;
  r.seconds = {5, 1, 2, 100, 3};
  EXPECT_EQ(r.median(), 3);
  EXPECT_EQ(r.spread(), 2);  // the median of 2, 2, 1, 97, 0
  r.seconds = {5, 1};
  EXPECT_EQ(r.spread(), 4);
}

}  // namespace
}  // namespace assur::measure
