// Operation counts of matrices.
#include "dispatch/counts.hpp"

#include <gtest/gtest.h>

#include "assur/assur.hpp"

namespace assur {
namespace {

// Has the entries at most `below` under and `above` over the diagonal.
Pattern band(std::int32_t n, std::int32_t below, std::int32_t above) {
  Pattern p;
  p.n = n;
  p.column_start = {0};
  for (std::int32_t j = 0; j < n; ++j) {
    for (std::int32_t i = std::max(0, j - above); i <= std::min(n - 1, j + below); ++i) p.row.push_back(i);
    p.column_start.push_back(p.nnz());
  }
  return p;
}

TEST(Counts, ATriangularMatrixFillsNothingAndHasNoProducts) {
  const Shape shape = shape_of(band(30, 0, 3));
  EXPECT_EQ(shape.fill, shape.nnz);
  EXPECT_EQ(shape.operations, shape.fill);
  EXPECT_EQ(shape.depth, 1 + 30);  // one level forward, 30 levels backward
}

TEST(Counts, ATridiagonalMatrixHasOneProductForEachPivotButOne) {
  const Shape shape = shape_of(band(30, 1, 1), 7);
  EXPECT_EQ(shape.n, 30);
  EXPECT_EQ(shape.groups, 7);
  EXPECT_EQ(shape.fill, 3 * 30 - 2);
  EXPECT_EQ(shape.operations, shape.fill + 29);
}

// Small matrices are eliminated to count, large ones are taken as full. Both have the same numbers.
TEST(Counts, AFullMatrixTakesAThirdOfItsCube) {
  for (const std::int64_t n : {3, 12, 24, 25, 400}) {
    const Shape shape = shape_of(band(static_cast<std::int32_t>(n), static_cast<std::int32_t>(n), 400));
    EXPECT_EQ(shape.fill, n * n) << n;
    EXPECT_EQ(shape.depth, 2 * n) << n;
    std::int64_t products = 0;
    for (std::int64_t i = 0; i < n; ++i) products += i * i;  // sum over pivots of the products for each
    EXPECT_EQ(shape.operations, products + n * n) << n;
  }
}

TEST(Counts, OnlyEqualPatternsHaveTheSameNumber) {
  const std::uint64_t first = shape_of(band(30, 1, 1)).pattern;
  EXPECT_EQ(first, shape_of(band(30, 1, 1)).pattern);
  EXPECT_NE(first, shape_of(band(30, 1, 0)).pattern);
  EXPECT_NE(first, shape_of(band(31, 1, 1)).pattern);
  EXPECT_NE(first, 0U);
}

TEST(Counts, AClassHasTheShapeOfItsGroups) {
  const GroupedSystem s = group_equations(open_scene("stewart"));
  const SolvedGroup& leg = s.groups.back();
  Shape counted = shape_of(s.classes[static_cast<std::size_t>(leg.group_class)], 6);
  EXPECT_GE(counted.fill, counted.nnz);
  EXPECT_GT(counted.terms, counted.nnz);
  counted.fill = counted.operations = counted.depth = counted.terms = 0;
  counted.pattern = 0;
  EXPECT_EQ(counted, s.shape(leg));
}

}  // namespace
}  // namespace assur
