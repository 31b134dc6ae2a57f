// Numbers as text, and the ranks of sorted values.
#include "report/measurement.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace assur::report {
namespace {

Measurement time_of(double seconds) {
  return {"steps", "stewart", "groups/klu 2x1", "seconds per step", "s", seconds, 21, 0.004, 1.8e-15, "measured"};
}

TEST(Measurement, SaysWhereItComesFrom) {
  EXPECT_EQ(about(time_of(2.36e-6)), "groups/klu 2x1: 2.36 µs; 21 repetitions, spread 0.4 %, error 1.8e-15, measured");
  Measurement theirs{"table2", "total 102", "GEOMP 3x1", "energy", "J", 12.5, 0, 0, std::nan(""), "paper, table 4"};
  EXPECT_EQ(about(theirs), "GEOMP 3x1: 12.5 J; paper, table 4");
}

TEST(Measurement, HasTheUnitThatItIsIn) {
  EXPECT_EQ(value_text(time_of(0.00104)), "1.04 ms");
  Measurement ratio = time_of(1);
  ratio.unit = "1";
  ratio.value = 1.23456;
  EXPECT_EQ(value_text(ratio), "1.23");
  ratio.value = std::nan("");
  EXPECT_EQ(value_text(ratio), "-");
}

TEST(Measurement, PercentHasADecimalWhereItIsSmall) {
  EXPECT_EQ(percent(0), "0.0 %");
  EXPECT_EQ(percent(0.0417), "4.2 %");
  EXPECT_EQ(percent(3.715), "372 %");
}

TEST(Measurement, QuantilesAreNearestRanks) {
  const std::vector<double> values = {5, 1, 4, 2, 3};
  EXPECT_EQ(quantile(values, 0), 1);
  EXPECT_EQ(quantile(values, 0.5), 3);
  EXPECT_EQ(quantile(values, 0.6), 3);
  EXPECT_EQ(quantile(values, 0.61), 4);
  EXPECT_EQ(quantile(values, 0.95), 5);
  EXPECT_EQ(quantile(values, 1), 5);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
  EXPECT_EQ(mean(values), 3);
}

TEST(Measurement, TheTableHasEveryColumnAndNoMoreRowsThanAskedFor) {
  const std::vector<Measurement> all(5, time_of(1e-6));
  const pictures::HtmlTable table = table_of(all, 3);
  ASSERT_EQ(table.rows.size(), 3u);
  EXPECT_EQ(table.rows[0].cells, (std::vector<std::string>{"stewart", "groups/klu 2x1", "seconds per step", "1.00 µs",
                                                           "21", "0.4 %", "1.8e-15", "measured"}));
}

}  // namespace
}  // namespace assur::report
