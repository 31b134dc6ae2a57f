#include "pictures/packed.hpp"

#include <gtest/gtest.h>

#include "pictures/unpacked.hpp"

namespace assur::pictures {
namespace {

TEST(Packed, UnpacksNumbersWithinHalfAStep) {
  std::vector<double> rows;
  for (int i = 0; i < 1000; ++i) {
    rows.push_back(std::sin(i));
    rows.push_back(1e9 + 1e-3 * i);
  }
  const Packed p = packed(rows, 2);
  EXPECT_EQ(p.text.size(), 4 * rows.size());
  const std::vector<double> back = unpacked(p.text, p.low, p.span);
  ASSERT_EQ(back.size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double half = p.span[i % 2] / ((1 << 24) - 2) / 2;
    EXPECT_NEAR(back[i], rows[i], half + 4e-16 * std::abs(rows[i]));
  }
}

TEST(Packed, KeepsConstantAndNonFiniteNumbers) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const Packed p = packed(std::vector<double>{0.1, 1, nan, 0.1, infinity, nan, 0.1, 3, nan}, 3);
  const std::vector<double> back = unpacked(p.text, p.low, p.span);
  for (const std::size_t i : {0u, 3u, 6u}) EXPECT_EQ(back[i], 0.1);
  EXPECT_EQ(back[1], 1);
  EXPECT_EQ(back[7], 3);
  for (const std::size_t i : {2u, 4u, 5u, 8u}) EXPECT_TRUE(std::isnan(back[i])) << i;
}

}  // namespace
}  // namespace assur::pictures
