// Operation counts of matrices.
#include "dispatch/counts.hpp"

#include <gtest/gtest.h>

#include <random>

#include "assur/assur.hpp"
#include "executors/step_code.hpp"
#include "program/class_step.hpp"

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

std::size_t instructions_of(const GroupClass& c) {
  std::mt19937_64 random(1);
  std::vector<double> values(c.pattern.row.size());
  for (double& value : values) value = std::uniform_real_distribution<double>(1, 2)(random);
  const lanes::Order order = lanes::markowitz_order(c.pattern, values, 1, 1, {.threshold = 0});
  std::size_t count = 0;
  for (const Phase& phase : class_step(c, lanes::write_program(c.pattern, order), {}).phases) {
    count += phase.code.size();
  }
  return count;
}

// The length of a program is estimated without writing it, so that programs of about the largest length may be wrong.
TEST(Counts, ClassesWithShortProgramsAreKnown) {
  int shorter = 0, longer = 0;
  for (const char* text : {"rings:legs=2,n=24", "rings:legs=2,n=60", "rings:legs=2,n=100", "rings:legs=2,n=240",
                           "delta", "three_rps", "scissor:20", "bricard", "sarrus", "goldberg"}) {
    for (const GroupClass& c : group_equations(sample(text), {.formulation = Formulation::groups}).classes) {
      if (!has_class_step(c)) continue;
      const auto ratio = static_cast<double>(instructions_of(c)) / static_cast<double>(kMostInstructions);
      if (ratio > 0.8 && ratio < 1.2) continue;
      EXPECT_EQ(shape_of(c).one_program, ratio < 1) << text << ", n = " << c.n << ": " << ratio;
      ++(ratio < 1 ? shorter : longer);
    }
  }
  EXPECT_GE(shorter, 8);
  EXPECT_GE(longer, 2);
  const GroupedSystem chain = group_equations(sample("n_four_bar:4"), {.formulation = Formulation::global});
  EXPECT_FALSE(class_shapes(chain)[0].one_program);  // it can be divided
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

TEST(Counts, AWholeStepHasTheSumsOfItsGroups) {
  const GroupedSystem s = group_equations(open_scene("stewart"));
  const Shape step = shape_of_step(s, class_shapes(s));
  EXPECT_EQ(step.n, 6 * 15 + 12);
  EXPECT_EQ(step.groups, 7);
  std::int64_t terms = 0;
  for (const Shape& c : class_shapes(s)) terms += c.groups * c.terms;
  EXPECT_EQ(step.terms, terms);
}

// Sizes and laws of a mechanism do not matter; what a step does, does.
TEST(Counts, OnlyStepsThatDoTheSameHaveOneShape) {
  const auto shape = [](const std::string& text, Formulation formulation, std::vector<std::string> outputs = {}) {
    const Scene scene = sample(text);
    const GroupedSystem s =
        group_equations(outputs.empty() ? scene : scene.with_outputs(std::move(outputs)), {.formulation = formulation});
    return shape_of_step(s, class_shapes(s));
  };
  const auto irreducible = Formulation::irreducible;
  EXPECT_EQ(shape("stewart:omega=2", irreducible), shape("stewart", irreducible));
  EXPECT_EQ(shape("slider_crank:rod_length=0.4", irreducible), shape("slider_crank", irreducible));
  const std::vector<Shape> all = {
      shape("stewart", irreducible),         shape("stewart", Formulation::groups),
      shape("stewart", Formulation::global), shape("stewart", irreducible, {"handle1.value"}),
      shape("stewart:legs=5", irreducible),  shape("four_bar:6", irreducible),
      shape("jansen", irreducible)};
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) EXPECT_NE(all[i].pattern, all[k].pattern) << i << " " << k;
  }
}

}  // namespace
}  // namespace assur
