#include "measure/deviation.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace assur::measure {
namespace {

TEST(Deviation, IsMeasuredByKind) {
  const std::vector<std::string> columns = {"A.x", "A.y", "A.vx"};
  const std::vector<double> a = {0, 2, 1e-3}, b = {1e-6, 2, 1e-3};
  EXPECT_EQ(deviation(columns, a, a), 0);
  EXPECT_DOUBLE_EQ(deviation(columns, b, a), 5e-7);  // relative to the largest coordinate
  const std::vector<double> c = {0, 2, 1.001e-3}, minus = {-0.0, 2, 1e-3};
  EXPECT_NEAR(deviation(columns, c, a), 1e-3, 1e-15);
  EXPECT_GT(deviation(columns, minus, a), 0);  // -0.0 and 0 differ in their bits
  EXPECT_TRUE(std::isinf(deviation(columns, std::vector<double>{0, 2}, a)));
}

}  // namespace
}  // namespace assur::measure
