// Numbers as text, quantiles, and the files for other programs: report.csv and report.json.
#include "report/section.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "median.hpp"

namespace assur::report {
namespace {

Measurement time_of(double seconds) {
  return {"stewart", "groups/klu 2x1", "seconds per step", "s", seconds, "measured", 21, 0.004, 1.8e-15};
}

TEST(Measurement, HasAnOrigin) {
  EXPECT_EQ(about(time_of(2.36e-6)), "groups/klu 2x1: 2.36 µs; 21 repetitions, spread 0.4 %, error 1.8e-15, measured");
  Measurement theirs{"total 102", "GEOMP 3x1", "energy", "J", 12.5, "paper, table 4"};
  EXPECT_EQ(about(theirs), "GEOMP 3x1: 12.5 J; paper, table 4");
}

TEST(Measurement, HasAUnit) {
  EXPECT_EQ(value_text(time_of(0.00104)), "1.04 ms");
  Measurement ratio = time_of(1);
  ratio.unit = "1";
  ratio.value = 1.23456;
  EXPECT_EQ(value_text(ratio), "1.23");
  ratio.value = std::nan("");
  EXPECT_EQ(value_text(ratio), "-");
}

TEST(Measurement, SmallPercentagesHaveADecimal) {
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

TEST(Measurement, TableHasEveryColumnAndLimitedRows) {
  const std::vector<Measurement> all(5, time_of(1e-6));
  const HtmlTable table = table_of(all, 3);
  ASSERT_EQ(table.rows.size(), 3u);
  EXPECT_EQ(table.rows[0].cells, (std::vector<std::string>{"stewart", "groups/klu 2x1", "seconds per step", "1.00 µs",
                                                           "21", "0.4 %", "1.8e-15", "measured"}));
}

std::vector<Section> two_sections() {
  return {{.id = "steps",
           .title = "Steps",
           .measurements = {{"six \"legs\", fast", "groups/klu", "seconds per step", "s", 1.0 / 3e6, "measured", 21,
                             0.004, 1.8e-15}}},
          {.id = "regret",
           .title = "Regret",
           .measurements = {{"all questions", "auto", "regret, median", "1", 0.042, "computed from 5 questions"}}}};
}

TEST(ReportCsv, QuotesTextsAndKeepsEveryDigit) {
  EXPECT_EQ(csv_of(two_sections()),
            "section,item,strategy,quantity,unit,value,repetitions,spread,error,origin\n"
            "\"steps\",\"six \"\"legs\"\", fast\",\"groups/klu\",\"seconds per step\",\"s\",3.3333333333333335e-07,21,"
            "0.0040000000000000001,1.8000000000000001e-15,\"measured\"\n"
            "\"regret\",\"all questions\",\"auto\",\"regret, median\",\"1\",0.042000000000000003,0,,,"
            "\"computed from 5 questions\"\n");
}

TEST(ReportJson, HasTheFormatOfGoogleBenchmark) {
  const output::Json json = benchmark_json(two_sections(), this_machine(), "2026-11-22T01:02:03+00:00");
  for (const char* key : {"date", "host_name", "executable", "num_cpus", "caches", "library_build_type"}) {
    EXPECT_TRUE(json["context"].contains(key)) << key;
  }
  ASSERT_EQ(json["benchmarks"].size(), 2u);
  for (const auto& b : json["benchmarks"]) {
    // Keys that the tools of Google Benchmark need in an aggregate.
    for (const char* key : {"name", "run_name", "run_type", "aggregate_name", "repetitions", "iterations", "real_time",
                            "cpu_time", "time_unit"}) {
      EXPECT_TRUE(b.contains(key)) << key;
    }
    EXPECT_EQ(b["run_type"], "aggregate");
    EXPECT_EQ(b["time_unit"], "ns");
  }
  EXPECT_DOUBLE_EQ(json["benchmarks"][0]["real_time"].get<double>(), 1e3 / 3);
  EXPECT_EQ(json["benchmarks"][0]["name"], "steps/six \"legs\", fast/groups/klu/seconds per step_median");
  // Quantities other than times are counters, and unknown errors are null.
  EXPECT_EQ(json["benchmarks"][1]["real_time"], 0.0);
  EXPECT_EQ(json["benchmarks"][1]["regret, median"], 0.042);
  EXPECT_TRUE(json["benchmarks"][1]["relative_error"].is_null());
}

}  // namespace
}  // namespace assur::report
