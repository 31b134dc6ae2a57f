#include "measure/noise.hpp"

#include <gtest/gtest.h>

#include "parallel/file_tree.hpp"

namespace assur::measure {
namespace {

TEST(Noise, MeasuresLoadAndStolenTime) {
  test::FileTree system;
  system.file("proc/loadavg", "1.50 1.00 0.50 2/100 1\n");
  system.file("proc/stat", "cpu  100 0 100 800 0 0 0 10 0 0\ncpu0 1 1 1 1\n");
  const NoiseWatch watch(2, system.root());
  system.file("proc/stat", "cpu  150 0 110 830 0 0 0 20 0 0\ncpu0 1 1 1 1\n");
  const Noise noise = watch.noise();
  EXPECT_DOUBLE_EQ(noise.load, 0.75);
  EXPECT_DOUBLE_EQ(noise.stolen, 0.1);  // 10 of 100 ticks
}

TEST(Noise, ASystemWithoutFiguresIsQuiet) {
  const test::FileTree system;
  const Noise noise = NoiseWatch(2, system.root()).noise();
  EXPECT_EQ(noise.load, 0);
  EXPECT_EQ(noise.stolen, 0);
  EXPECT_EQ(assess(noise).quiet, Quiet::yes);
  EXPECT_EQ(assess(noise).reason, "");
}

TEST(Noise, TheWorstFigureDecidesAndAllAreReported) {
  Noise noise;
  noise.scatter = 0.03;
  EXPECT_EQ(assess(noise).quiet, Quiet::some_noise);
  EXPECT_EQ(assess(noise).reason, "times scatter by 3 %");
  noise.uneven = 0.3;
  EXPECT_EQ(
      assess(noise).reason,
      "one core was slower than another in 30 % of the measurements with several threads, which were repeated; times "
      "scatter by 3 %");
  noise.uneven = 0;
  noise.stolen = 0.2;
  EXPECT_EQ(assess(noise).quiet, Quiet::noisy);
  noise.drift = 0.4;
  EXPECT_EQ(assess(noise).reason,
            "the hypervisor took 20 % of the time; times scatter by 3 %; the whole machine was at times up to 40 % "
            "slower, for which times are corrected");
}

}  // namespace
}  // namespace assur::measure
