// report.csv and report.json: what other programs read.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "report/benchmark_json.hpp"
#include "report/measurement_csv.hpp"

namespace assur::report {
namespace {

std::vector<Section> two_sections() {
  Section steps{"steps", "Steps", "", {}};
  steps.measurements.push_back({"steps", "six \"legs\", fast", "groups/klu", "seconds per step", "s", 1.0 / 3e6, 21,
                                0.004, 1.8e-15, "measured"});
  Section regret{"regret", "Regret", "", {}};
  regret.measurements.push_back({"regret", "all questions", "auto", "regret, median", "1", 0.042, 0, 0, std::nan(""),
                                 "computed from 5 questions"});
  return {steps, regret};
}

TEST(ReportCsv, QuotesTextsAndKeepsEveryDigit) {
  std::ostringstream out;
  write_csv(out, two_sections());
  EXPECT_EQ(out.str(),
            "section,item,strategy,quantity,unit,value,repetitions,spread,error,origin\n"
            "\"steps\",\"six \"\"legs\"\", fast\",\"groups/klu\",\"seconds per step\",\"s\",3.3333333333333335e-07,21,"
            "0.0040000000000000001,1.8000000000000001e-15,\"measured\"\n"
            "\"regret\",\"all questions\",\"auto\",\"regret, median\",\"1\",0.042000000000000003,0,,,"
            "\"computed from 5 questions\"\n");
}

TEST(ReportJson, IsWhatGoogleBenchmarkWrites) {
  const output::Json json = benchmark_json(two_sections(), this_machine(), "2026-11-22T01:02:03+00:00");
  for (const char* key : {"date", "host_name", "executable", "num_cpus", "caches", "library_build_type"}) {
    EXPECT_TRUE(json["context"].contains(key)) << key;
  }
  ASSERT_EQ(json["benchmarks"].size(), 2u);
  for (const auto& b : json["benchmarks"]) {
    // What its tools look for in an aggregate.
    for (const char* key : {"name", "run_name", "run_type", "aggregate_name", "repetitions", "iterations", "real_time",
                            "cpu_time", "time_unit"}) {
      EXPECT_TRUE(b.contains(key)) << key;
    }
    EXPECT_EQ(b["run_type"], "aggregate");
    EXPECT_EQ(b["time_unit"], "ns");
  }
  EXPECT_DOUBLE_EQ(json["benchmarks"][0]["real_time"].get<double>(), 1e3 / 3);
  EXPECT_EQ(json["benchmarks"][0]["name"], "steps/six \"legs\", fast/groups/klu/seconds per step_median");
  // What is no time is a counter, and an error that nobody knows is null.
  EXPECT_EQ(json["benchmarks"][1]["real_time"], 0.0);
  EXPECT_EQ(json["benchmarks"][1]["regret, median"], 0.042);
  EXPECT_TRUE(json["benchmarks"][1]["relative_error"].is_null());
}

}  // namespace
}  // namespace assur::report
