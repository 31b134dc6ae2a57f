// The true error of every strategy is known before its time counts.
#include "measure/work_precision.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "numbers.hpp"

namespace assur::measure {
namespace {

WorkPrecisionOptions quick(const std::vector<std::string>& strategies, std::vector<double> accuracies) {
  WorkPrecisionOptions options;
  if (!strategies.empty()) options.strategies.emplace();
  for (const std::string& text : strategies) options.strategies->push_back(parse_strategy(text));
  options.accuracies = std::move(accuracies);
  options.model = std::make_shared<const PerformanceModel>();
  options.rules = {.seconds = 0.5, .least_rounds = 3, .most_rounds = 3};
  return options;
}

const WorkPrecisionRow* row_of(const WorkPrecision& result, const std::string& strategy) {
  const auto at = std::find_if(result.rows.begin(), result.rows.end(),
                               [&](const WorkPrecisionRow& row) { return row.strategy == strategy; });
  return at == result.rows.end() ? nullptr : &*at;
}

TEST(WorkPrecision, TimesEveryStrategyAndMarksThePicks) {
  const std::vector<std::string> asked = {"groups/eigen", "irreducible/lanes:8+once"};
  const WorkPrecision result = work_precision(sample("stewart:steps=40"), quick(asked, {1e-4, 1e-9}));
  EXPECT_EQ(result.steps, 40);
  EXPECT_FALSE(result.interrupted);
  for (const std::string& strategy : asked) {
    const WorkPrecisionRow* const row = row_of(result, strategy);
    ASSERT_NE(row, nullptr) << strategy;
    ASSERT_TRUE(row->seconds.has_value()) << strategy;
    EXPECT_GT(*row->seconds, 0);
    EXPECT_EQ(row->status, "ok");
  }
  for (const double accuracy : {1e-4, 1e-9}) ASSERT_NE(result.pick(accuracy), nullptr);
  EXPECT_EQ(result.pick(1e-5), nullptr);
  const auto slower = [](const auto& a, const auto& b) { return a.seconds < b.seconds; };
  EXPECT_TRUE(std::is_sorted(result.rows.begin(), result.rows.end(), slower));
}

TEST(WorkPrecision, FixedIterationsIncreaseTheError) {
  if (!work_precision(sample("four_bar:loops=2,steps=5"), quick({"groups/eigen"}, {})).no_yardstick.empty()) {
    GTEST_SKIP() << "no quad precision here";
  }
  // Predictions of order 0 have errors of some hundredths. One iteration squares this error once, two iterations twice.
  WorkPrecisionOptions options = quick({}, {1e-6});
  const Scene scene = sample("four_bar:loops=8,steps=30");
  const WorkPrecision result = work_precision(scene, options);
  const auto error = [&](const std::string& predictor, int iterations) {
    double least = 1;
    for (const WorkPrecisionRow& row : result.rows) {
      if (row.iterations == iterations && row.strategy.find(predictor) != std::string::npos)
        least = std::min(least, row.worst_error());
    }
    return least;
  };
  // Predictors are varied in the fastest strategy. The global formulation has one level, where iterations are not
  // fixed.
  const bool turned_global = std::any_of(result.rows.begin(), result.rows.end(), [](const WorkPrecisionRow& row) {
    return row.strategy.starts_with("global/") && row.strategy.find("+predict=taylor:1") != std::string::npos;
  });
  if (!turned_global) {
    EXPECT_GT(error("+predict=taylor:0", 1), 1e2 * error("+predict=taylor:0", 2));
    EXPECT_GT(error("+predict=taylor:0", 2), error("+predict=taylor:0", 3));
    EXPECT_LT(error("+predict=taylor:0", 3), 1e-9);
    EXPECT_LT(error("+predict=taylor:2", 1), error("+predict=taylor:0", 1));
  }

  std::set<std::string> ways;
  for (const WorkPrecisionRow& row : result.rows) {
    for (const double a : row.accuracies) {
      const std::string way = row.strategy + " " + std::to_string(row.iterations) + " " + std::to_string(std::log10(a));
      EXPECT_TRUE(ways.insert(way).second) << way;
    }
    if (row.on_front) {
      EXPECT_TRUE(row.seconds && row.error) << row.strategy;
    }
    if (row.seconds && result.no_yardstick.empty()) {
      EXPECT_TRUE(row.error.has_value()) << row.strategy;
    }
  }
}

TEST(WorkPrecision, ListsFailedStrategiesWithoutTime) {
  // The crank turns until coupler and rocker are in line, at cos t = 1/4.
  const Scene fold = SceneBuilder("fold", 2)
                         .fixed_point("A", {0, 0})
                         .fixed_point("D", {2, 0})
                         .point("B", {1, 0})
                         .point("C", {1.5, 0.8})
                         .constrain("coupler", Distance{"B", "C", 1.0})
                         .constrain("rocker", Distance{"D", "C", 1.0})
                         .drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, 1})})
                         .time(0, 2, 0.01)
                         .build();
  const WorkPrecision result = work_precision(fold, quick({"groups/eigen", "global/eigen"}, {}));
  ASSERT_EQ(result.rows.size(), 2u);
  for (const WorkPrecisionRow& row : result.rows) {
    EXPECT_EQ(row.status, "fold");
    EXPECT_FALSE(row.seconds.has_value());
    EXPECT_FALSE(row.on_front);
  }
}

TEST(WorkPrecision, KeepsResultsIfInterrupted) {
  WorkPrecisionOptions options = quick({"groups/eigen", "global/eigen", "irreducible/lanes"}, {1e-6});
  int looks = 0;
  options.progress = [&](std::int64_t, std::int64_t) { ++looks; };
  options.instruments.stop = [&] { return looks >= 3; };
  const WorkPrecision result = work_precision(sample("four_bar"), options);
  EXPECT_TRUE(result.interrupted);
  EXPECT_EQ(result.rows.size(), 2u);
  for (const WorkPrecisionRow& row : result.rows) EXPECT_FALSE(row.seconds.has_value());
}

TEST(WorkPrecision, RefusesARequestedStrategyThatCannotRun) {
  EXPECT_THROW((void)work_precision(sample("four_bar"), quick({"groups/klu+float"}, {})), Error);
  EXPECT_THROW((void)work_precision(sample("gough"), quick({"groups/eigen"}, {})), Error);  // the scene has no step
}

TEST(WorkPrecision, MeasuresTheLossAtTheRequiredAccuracy) {
  WorkPrecision result;
  const auto add = [&](double seconds, double error, std::vector<double> accuracies) {
    WorkPrecisionRow row;
    row.seconds = seconds;
    row.error = ForwardError{error, error / 2, 0};
    row.picked = std::move(accuracies);
    result.rows.push_back(row);
  };
  add(1, 1e-5, {});
  add(1.5, 1e-9, {1e-4, 1e-6});
  add(3, 1e-9, {1e-10});
  EXPECT_DOUBLE_EQ(result.behind(1e-4).value(), 0.5);
  EXPECT_DOUBLE_EQ(result.behind(1e-6).value(), 0);
  EXPECT_FALSE(result.behind(1e-10).has_value());  // the accuracy was missed
  EXPECT_FALSE(result.behind(1e-12).has_value());  // the accuracy was not asked for
}

TEST(WorkPrecision, TheFastestWithinAnErrorCountsItsBound) {
  WorkPrecision all;  // the fastest first
  const std::vector<Trade> trades = {{0.1, kNan}, {1, 1e-3}, {2, 1e-6}, {3, 1e-12}};
  for (const Trade& t : trades) {
    WorkPrecisionRow& row = all.rows.emplace_back();
    row.seconds = t.seconds;
    if (!std::isnan(t.error)) row.error = {t.error, t.error, t.error};
  }
  WorkPrecisionRow& not_timed = all.rows.emplace_back();
  not_timed.error = {0, 0, 0};
  EXPECT_EQ(all.fastest_within(1), &all.rows[1]);
  EXPECT_EQ(all.fastest_within(1e-6), &all.rows[2]);
  EXPECT_EQ(all.fastest_within(1e-7), &all.rows[3]);
  EXPECT_EQ(all.fastest_within(1e-13), nullptr);
}

}  // namespace
}  // namespace assur::measure
