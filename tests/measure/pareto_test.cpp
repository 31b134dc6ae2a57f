#include "measure/pareto.hpp"
#include "numbers.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace assur::measure {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(Pareto, FrontHasOnlyUnbeatenRows) {
  const std::vector<Trade> all = {{3, 1e-12}, {1, 1e-3}, {2, 1e-3}, {2, 1e-6}, {4, 1e-12}, {5, 1e-9}};
  EXPECT_EQ(pareto_front(all), (std::vector<bool>{true, true, false, true, false, false}));
}

TEST(Pareto, TreatsEqualRowsAlike) {
  const std::vector<Trade> all = {{1, 1e-3}, {2, 1e-6}, {2, 1e-6}, {3, 1e-4}, {3, 1e-4}};
  EXPECT_EQ(pareto_front(all), (std::vector<bool>{true, true, true, false, false}));
}

TEST(Pareto, RowsWithUnknownErrorsAreNotOnTheFront) {
  const std::vector<Trade> all = {{kNaN, 0}, {1, kNaN}, {0, kInfinity}, {2, 0}};
  EXPECT_EQ(pareto_front(all), (std::vector<bool>{false, false, false, true}));
  EXPECT_TRUE(pareto_front({}).empty());
}

TEST(Pareto, AgreesWithTheDefinition) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> few(1, 12);  // few values, so that some trades have equal numbers
  std::vector<Trade> all;
  for (int i = 0; i < 200; ++i) all.push_back({double(few(random)), double(few(random))});
  const std::vector<bool> front = pareto_front(all);
  for (std::size_t i = 0; i < all.size(); ++i) {
    bool beaten = false;
    for (const Trade& o : all) {
      beaten = beaten || (o.seconds <= all[i].seconds && o.error <= all[i].error &&
                          (o.seconds < all[i].seconds || o.error < all[i].error));
    }
    EXPECT_EQ(front[i], !beaten) << all[i].seconds << ' ' << all[i].error;
  }
}

}  // namespace
}  // namespace assur::measure
