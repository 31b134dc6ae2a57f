// Points of design spaces.
#include "sweep/design_space.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "assur/status.hpp"
#include "sweep/philox.hpp"

namespace assur::sweep {
namespace {

// Known answers that the authors of Philox publish with their generators (Random123, kat_vectors).
TEST(Philox, HasThePublishedValues) {
  using Block = std::array<std::uint32_t, 4>;
  constexpr std::uint32_t kOnes = 0xffffffff;
  EXPECT_EQ(philox({0, 0, 0, 0}, {0, 0}), (Block{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(philox({kOnes, kOnes, kOnes, kOnes}, {kOnes, kOnes}),
            (Block{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (Block{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

const std::vector<Range> kTwo = {{"a", -1, 3}, {"b", 10, 11}};

TEST(DesignSpace, AGridHasAllCombinations) {
  const DesignSpace grid(kTwo, Sampler::grid, 9, 0);
  std::vector<std::vector<double>> points;
  for (int k = 0; k < 9; ++k) points.push_back(grid.point(k));
  EXPECT_EQ(points, (std::vector<std::vector<double>>{
                        {-1, 10}, {-1, 10.5}, {-1, 11}, {1, 10}, {1, 10.5}, {1, 11}, {3, 10}, {3, 10.5}, {3, 11}}));
  EXPECT_EQ(DesignSpace(kTwo, Sampler::grid, 1, 0).point(0), (std::vector<double>{1, 10.5}));
  // Whole roots are found exactly.
  const std::vector<Range> three = {{"a", 0, 1}, {"b", 0, 1}, {"c", 0, 1}};
  EXPECT_EQ(DesignSpace(three, Sampler::grid, 1'000'000, 0).point(999'999), (std::vector<double>{1, 1, 1}));
}

TEST(DesignSpace, RefusesWhatItCannotSample) {
  const auto message = [](const std::vector<Range>& ranges, Sampler sampler, std::int64_t samples) {
    try {
      (void)DesignSpace(ranges, sampler, samples, 0);
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), Error::Kind::input);
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_NE(message(kTwo, Sampler::grid, 10).find("such as 9 or 16, not 10"), std::string::npos);
  EXPECT_NE(message({}, Sampler::random, 10).find("at least one parameter"), std::string::npos);
  EXPECT_NE(message({{"a", 2, 1}}, Sampler::random, 10).find("the smaller one first"), std::string::npos);
  EXPECT_NE(message({{"a", 0, INFINITY}}, Sampler::random, 10).find("finite"), std::string::npos);
  EXPECT_NE(message({{"a", -1e308, 1e308}}, Sampler::random, 10).find("finite"), std::string::npos);
  EXPECT_NE(message(kTwo, Sampler::random, 0).find("at least one sample"), std::string::npos);
}

// Mean and variance of uniform numbers, and no correlation between parameters or neighbours, within five standard
// deviations.
TEST(DesignSpace, RandomPointsAreUniformAndIndependent) {
  constexpr int kCount = 20'000;
  const std::vector<Range> units = {{"a", 0, 1}, {"b", 0, 1}, {"c", 0, 1}};
  const DesignSpace space(units, Sampler::random, kCount, 7);
  double mean[3] = {}, square[3] = {}, product[3] = {}, follow = 0, before = 0;
  for (int k = 0; k < kCount; ++k) {
    const std::vector<double> p = space.point(k);
    for (std::size_t i = 0; i < 3; ++i) {
      ASSERT_GE(p[i], 0);
      ASSERT_LT(p[i], 1);
      const double x = p[i] - 0.5, y = p[(i + 1) % 3] - 0.5;
      mean[i] += x / kCount;
      square[i] += x * x / kCount;
      product[i] += x * y / kCount;
    }
    follow += (p[0] - 0.5) * before / kCount;
    before = p[0] - 0.5;
  }
  const double of_mean = 5 * std::sqrt(1.0 / 12 / kCount), of_product = 5 / 12.0 / std::sqrt(kCount),
               of_square = 5 * std::sqrt(1.0 / 180 / kCount);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(mean[i], 0, of_mean);
    EXPECT_NEAR(square[i], 1.0 / 12, of_square);
    EXPECT_NEAR(product[i], 0, of_product);
  }
  EXPECT_NEAR(follow, 0, of_product);
}

TEST(DesignSpace, APointDependsOnSeedAndNumberOnly) {
  for (const Sampler sampler : {Sampler::random, Sampler::sobol}) {
    try {
      const DesignSpace few(kTwo, sampler, 10, 5), many(kTwo, sampler, 1'000'000'000, 5), other(kTwo, sampler, 10, 6);
      EXPECT_EQ(few.point(9), many.point(9));
      EXPECT_NE(few.point(9), few.point(8));
      EXPECT_NE(few.point(9), other.point(9));
      EXPECT_NE(many.point(999'999'999), many.point(999'999'998));
    } catch (const Error& e) {
      ASSERT_EQ(sampler, Sampler::sobol);
      ASSERT_EQ(e.kind(), Error::Kind::environment) << e.what();
    }
  }
}

// The first 2^m points have one in each of 2^m equal intervals of each parameter, for any seed.
TEST(DesignSpace, SobolPointsFillEachParameterEvenly) {
  const std::vector<Range> ranges(5, Range{"a", 0, 1});
  try {
    for (const std::uint64_t seed : {0u, 1u, 99u}) {
      const DesignSpace space(ranges, Sampler::sobol, 256, seed);
      std::vector<std::set<int>> seen(5);
      for (int k = 0; k < 256; ++k) {
        const std::vector<double> p = space.point(k);
        for (std::size_t i = 0; i < 5; ++i) seen[i].insert(static_cast<int>(p[i] * 256));
      }
      for (const std::set<int>& intervals : seen) EXPECT_EQ(intervals.size(), 256u) << seed;
    }
  } catch (const Error& e) {
    ASSERT_EQ(e.kind(), Error::Kind::environment) << e.what();
  }
}

}  // namespace
}  // namespace assur::sweep
