// The pace of a machine that the test controls.
#include "measure/pace.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "assur/machine.hpp"
#include "assur/status.hpp"
#include "measure/laboratory.hpp"

namespace assur::measure {
namespace {

TEST(Pace, UsualPaceIsTheLowerQuartile) {
  Laboratory laboratory;
  Timed work(laboratory, 3e-6);
  const auto clock = [&] {
    laboratory.slow = laboratory.now < 1000.3 ? 2 : 1;  // slow in more than half of 0.5 s
    return laboratory.now;
  };
  Pace pace(work, clock, 0.5);
  EXPECT_NEAR(pace.usual(), 3e-6, 1e-12);
  EXPECT_NEAR(pace.slowness(), 1, 1e-6);
}

TEST(Pace, MeasuresTheCurrentSlowness) {
  Laboratory laboratory;
  Timed work(laboratory, 3e-6);
  Pace pace(work, laboratory.instruments().clock, 0.5);
  for (const double slow : {1.7, 0.9, 1.0}) {
    laboratory.slow = slow;
    EXPECT_NEAR(pace.slowness(), slow, 1e-6);
  }
}

TEST(Pace, IgnoresAnInterruption) {
  class Interrupted final : public Timed {
   public:
    using Timed::Timed;
    bool run(int calls) override { return Timed::run(++runs_ % 3 == 2 ? 1000 * calls : calls); }

   private:
    int runs_ = 0;
  };
  Laboratory laboratory;
  Interrupted work(laboratory, 3e-6);
  Pace pace(work, laboratory.instruments().clock, 0.5, 3e-6);
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(pace.slowness(), 1, 1e-6);
}

TEST(Pace, TakesThePaceOfAnEarlierRun) {
  Laboratory laboratory;
  Timed work(laboratory, 3e-6);
  Pace pace(work, laboratory.instruments().clock, 0.5, 2e-6);
  EXPECT_LT(laboratory.now, 1000.001);  // the pace was hardly measured
  EXPECT_EQ(pace.usual(), 2e-6);
  EXPECT_NEAR(pace.slowness(), 1.5, 1e-6);
}

TEST(Pace, ReportsFailingWork) {
  class Fails final : public Workload {
    bool run(int) override { return false; }
  } work;
  Laboratory laboratory;
  EXPECT_THROW(Pace(work, laboratory.instruments().clock, 0.5), Error);
}

// The time of the fixed work can be stored as a sample of a pack.
TEST(Pace, FixedWorkIsAnOrdinarySample) {
  const FixedWork fixed = leg_steps();
  EXPECT_EQ(fixed.shape.n, 15);
  EXPECT_EQ(fixed.shape.groups, 6);
  EXPECT_GT(fixed.shape.terms, 0);
  EXPECT_EQ(to_string(fixed.strategy), "groups/eigen");
  EXPECT_TRUE(fixed.work->run(12));
}

// Every thread has its own clock, which its work advances.
thread_local double own_clock = 0;

class OnItsCore final : public Workload {
 public:
  bool run(int calls) override {
    own_clock += seconds * calls;
    return true;
  }
  double seconds = 1e-6;
};

TEST(CorePaces, MeasureTheUnevennessOfCores) {
  std::vector<std::int32_t> cores = this_machine().cores;
  std::vector<OnItsCore*> made;
  const auto work = [&] {
    auto one = std::make_unique<OnItsCore>();
    made.push_back(one.get());
    return FixedWork{Kernel::pack, {}, {}, std::move(one)};
  };
  CorePaces paces(cores, work, [] { return own_clock; });
  ASSERT_EQ(made.size(), std::max<std::size_t>(cores.size(), 1));
  EXPECT_NEAR(paces.unevenness(), 1, 1e-9);
  made.back()->seconds = 3e-6;
  EXPECT_NEAR(paces.unevenness(), made.size() > 1 ? 3 : 1, 1e-9);
  for (OnItsCore* one : made) one->seconds = 3e-6;
  EXPECT_NEAR(paces.unevenness(), 1, 1e-9);
}

TEST(MachinePace, AttachesToInstruments) {
  for (const int threads : {1, 64}) {
    Instruments instruments;
    MachinePace pace(threads, 0.01);
    pace.attach(instruments);
    EXPECT_GT(pace.usual(), 0);
    EXPECT_GT(instruments.slowness(), 0);
    const double unevenness = instruments.unevenness();
    EXPECT_TRUE(std::isfinite(unevenness));
    EXPECT_GE(unevenness, 1);
    if (threads == 1) {
      EXPECT_EQ(unevenness, 1);
    }
  }
}

}  // namespace
}  // namespace assur::measure
