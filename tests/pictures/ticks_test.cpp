#include "pictures/ticks.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace assur::pictures {
namespace {

TEST(Ticks, DecadesCoverTheValuesAndAreRound) {
  const Ticks t = logarithmic_ticks(3e-15, 2e-3, 20);
  EXPECT_DOUBLE_EQ(t.low, 1e-15);
  EXPECT_DOUBLE_EQ(t.high, 1e-2);
  ASSERT_EQ(t.at.size(), 14u);
  for (std::size_t i = 0; i < t.at.size(); ++i) EXPECT_DOUBLE_EQ(t.at[i], std::pow(10, static_cast<int>(i) - 15));
}

TEST(Ticks, AValueOnATickNeedsNoFurtherDecade) {
  const Ticks t = logarithmic_ticks(1e-12, 1e-4, 20);
  EXPECT_DOUBLE_EQ(t.low, 1e-12);
  EXPECT_DOUBLE_EQ(t.high, 1e-4);
}

TEST(Ticks, LabelsSomeDecadesIfRoomIsScarce) {
  const Ticks t = logarithmic_ticks(1e-16, 1, 5);
  EXPECT_LE(t.at.size(), 5u);
  EXPECT_GE(t.at.size(), 3u);
  for (const double v : t.at) EXPECT_NEAR(std::log10(v), std::round(std::log10(v)), 1e-9);
}

TEST(Ticks, FewDecadesHaveTicksWithin) {
  const Ticks t = logarithmic_ticks(1.3e-6, 8e-6, 10);
  ASSERT_EQ(t.at.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_DOUBLE_EQ(t.at[i], std::vector<double>({1e-6, 2e-6, 5e-6, 1e-5})[i]);
}

TEST(Ticks, ASingleValueGetsRoom) {
  for (const double v : {3e-6, 1e-6}) {
    const Ticks t = logarithmic_ticks(v, v, 10);
    EXPECT_LE(t.low, v * 1.000001);
    EXPECT_GE(t.high, v * 0.999999);
    EXPECT_GT(t.high, t.low);
  }
  for (const double v : {0.0, -4.0, 7.0}) {
    const Ticks t = linear_ticks(v, v, 5);
    EXPECT_LT(t.low, v);
    EXPECT_GT(t.high, v);
  }
}

TEST(Ticks, LinearOnesAreMultiplesOfARoundStep) {
  const Ticks t = linear_ticks(-0.3, 1.9, 6);
  ASSERT_EQ(t.at.size(), 6u);  // steps of 0.5
  EXPECT_DOUBLE_EQ(t.low, -0.5);
  EXPECT_DOUBLE_EQ(t.high, 2);
  EXPECT_DOUBLE_EQ(t.at[1], 0);
}

TEST(Ticks, TheirTextsAreShort) {
  EXPECT_EQ(power_of_ten(1e-12), "10⁻¹²");
  EXPECT_EQ(power_of_ten(1), "1");
  EXPECT_EQ(power_of_ten(10), "10");
  EXPECT_EQ(power_of_ten(1e5), "10⁵");
  EXPECT_EQ(power_of_ten(2e-3), "2·10⁻³");
  EXPECT_EQ(time_text(1e-6), "1 µs");
  EXPECT_EQ(time_text(20e-6), "20 µs");
  EXPECT_EQ(time_text(0.5e-3), "500 µs");
  EXPECT_EQ(time_text(1e-3), "1 ms");
  EXPECT_EQ(time_text(2), "2 s");
  EXPECT_EQ(time_text(5e-10), "0.5 ns");
}

}  // namespace
}  // namespace assur::pictures
