// A time counts only if its result is right; speed-ups compare neighbouring rounds.
#include "contest.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

#include "assur/status.hpp"

namespace assur::bench {
namespace {

// A contender with given times and results.
class Scripted : public Contender {
 public:
  Scripted(std::vector<double> seconds, std::vector<double> result, double residual = 0)
      : seconds_(std::move(seconds)), result_(std::move(result)), residual_(residual) {}

  Cost work() override {
    if (round_ == seconds_.size()) throw Error(Error::Kind::numerical, "no more");
    ++round_;
    return {seconds_[round_ - 1], 3};
  }
  std::span<const double> result() const override { return result_; }
  const std::vector<std::string>& columns() const override { return columns_; }
  double residual() const override { return residual_; }

 private:
  std::vector<double> seconds_, result_;
  double residual_;
  std::size_t round_ = 0;
  std::vector<std::string> columns_ = {"A.x", "A.vx"};
};

Entry entry(std::vector<double> seconds, std::vector<double> result, double bound,
            const std::string& strategy = "groups/eigen", double residual = 0) {
  Entry e{"scene", strategy};
  e.base = 0;
  e.bound = bound;
  e.contender = std::make_unique<Scripted>(std::move(seconds), std::move(result), residual);
  return e;
}

std::vector<Entry> against(Entry other) {
  std::vector<Entry> contest;
  contest.push_back(entry({4, 8, 2}, {1, 10}, 0));
  contest.front().base = Entry::kItself;
  contest.push_back(std::move(other));
  hold(contest, 3);
  return contest;
}

TEST(Contest, ComparesRoundsWithTheirNeighbours) {
  const std::vector<Entry> contest = against(entry({2, 2, 2}, {1, 10}, 0, "groups/eigen 2x1"));
  EXPECT_EQ(contest[1].seconds, (std::vector<double>{2, 2, 2}));
  EXPECT_EQ(contest[1].failure, "");
  const Spread ratio = speed_up(contest[1], contest[0]);
  EXPECT_EQ(ratio.lower, 1);  // the ratios of the rounds are 2, 4 and 1
  EXPECT_EQ(ratio.median, 2);
  EXPECT_EQ(ratio.upper, 4);
}

TEST(Contest, ComparesProcessorTimesOfOneThread) {
  const std::vector<Entry> contest = against(entry({2, 2, 2}, {1, 10}, 0));
  EXPECT_EQ(speed_up(contest[1], contest[0]).upper, 1);  // both take 3 s of the processor in each round
}

TEST(Contest, HasNoTimesForAWrongResult) {
  const double next = std::nextafter(1.0, 2.0);
  for (const double value : {next, std::numeric_limits<double>::quiet_NaN()}) {
    const std::vector<Entry> contest = against(entry({1, 1, 1}, {value, 10}, 0));
    EXPECT_TRUE(contest[1].wrong);
    EXPECT_TRUE(contest[1].seconds.empty());
    EXPECT_NE(contest[1].failure.find("WRONG"), std::string::npos);
    EXPECT_EQ(contest[0].seconds.size(), 3u);
  }
  EXPECT_FALSE(against(entry({1, 1, 1}, {next, 10}, 1e-15))[1].wrong);                // within the bound
  EXPECT_TRUE(against(entry({1, 1, 1}, {1, 10, 1, 10}, 1))[1].wrong);                 // another number of rows
  EXPECT_TRUE(against(entry({1, 1, 1}, {1, 10}, 1, "groups/eigen", 1e-6))[1].wrong);  // the residual is too large
}

TEST(Contest, NamesTheFailure) {
  const std::vector<Entry> contest = against(entry({1, 1}, {1, 10}, 0));  // fails in the third round
  EXPECT_EQ(contest[1].failure, "no more");
  EXPECT_TRUE(contest[1].seconds.empty());
}

}  // namespace
}  // namespace assur::bench
