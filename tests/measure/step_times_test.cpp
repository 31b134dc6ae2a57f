#include "measure/step_times.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace assur::measure {
namespace {

constexpr double kClockCost = 30e-9;

// A clock that only this test advances; a call costs kClockCost, half before and half after the reading.
struct Laboratory {
  double now = 1000;
  int calls = 0;

  StepTimes::Clock clock() {
    return [this] {
      ++calls;
      now += kClockCost;
      return now - kClockCost / 2;
    };
  }
};

// Times near 1000 s are rounded to 1.1e-13 s; a block adds up to 64 of them, read twice.
constexpr double kRounding = 2 * 64 * 1.2e-13;

TEST(StepTimes, ReportsZeroWithoutSteps) {
  Laboratory laboratory;
  StepTimes times(0, laboratory.clock());
  times.tick();
  const auto figures = times.figures();
  EXPECT_EQ(figures.median, 0);
  EXPECT_EQ(figures.max, 0);
  EXPECT_EQ(figures.block, 1);
}

TEST(StepTimes, TimesLongStepsSinglyWithoutClockOverhead) {
  Laboratory laboratory;
  StepTimes times(1000, laboratory.clock());
  times.tick();
  for (int k = 1; k <= 1000; ++k) {
    laboratory.now += k * 1e-5;
    EXPECT_TRUE(times.tick());
    laboratory.now += 3;  // work of the caller between two steps
    times.resume();
  }
  const auto figures = times.figures();
  EXPECT_EQ(figures.block, 1);
  EXPECT_NEAR(figures.median, 500e-5, kRounding);
  EXPECT_NEAR(figures.p99, 990e-5, kRounding);
  EXPECT_NEAR(figures.max, 1000e-5, kRounding);
  EXPECT_GT(times.elapsed(), 3000);
}

TEST(StepTimes, TimesShortStepsInBlocks) {
  Laboratory laboratory;
  StepTimes times(6400, laboratory.clock());
  const int before = laboratory.calls;
  times.tick();
  for (int k = 1; k <= 6400; ++k) {
    laboratory.now += 300e-9;
    times.tick();
  }
  const auto figures = times.figures();
  const auto blocks = times.blocks();
  EXPECT_EQ(blocks.steps, 16);
  ASSERT_EQ(blocks.seconds.size(), 400u);
  for (const double s : blocks.seconds) EXPECT_NEAR(s, 300e-9, kRounding);
  EXPECT_EQ(figures.block, 16);  // the first power of two that takes 4 us
  EXPECT_NEAR(figures.median, 300e-9, kRounding);
  EXPECT_NEAR(figures.max, 300e-9, kRounding);
  EXPECT_LE(laboratory.calls - before, 2 * (1 + 64 + (6400 - 64) / 16));
}

TEST(StepTimes, JoinsStepsOfAShortRunAfterwards) {
  Laboratory laboratory;
  StepTimes times(40, laboratory.clock());
  times.tick();
  for (int k = 1; k <= 40; ++k) {
    laboratory.now += k % 2 == 0 ? 100e-9 : 700e-9;
    times.tick();
  }
  const auto figures = times.figures();
  EXPECT_EQ(figures.block, 40);  // 40 x 100 ns
  EXPECT_NEAR(figures.median, 400e-9, kRounding);
}

TEST(StepTimes, AgreesWithTheSteadyClock) {
  StepTimes times(200);
  times.tick();
  const double begin = StepTimes::steady();
  for (int k = 0; k < 200; ++k) {
    for (const double until = StepTimes::steady() + 20e-6; StepTimes::steady() < until;) {
    }
    times.tick();
  }
  const double end = StepTimes::steady();
  const auto figures = times.figures();
  EXPECT_EQ(figures.block, 1);
  EXPECT_GE(figures.median, 19e-6);  // minus the assumed cost of the clock
  EXPECT_LE(figures.median, figures.p99);
  EXPECT_LE(figures.p99, figures.max);
  EXPECT_LE(100 * figures.median, end - begin);  // half of the steps take at least the median
}

}  // namespace
}  // namespace assur::measure
