// The section for artificial answers: every figure follows from its measurements.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "report/sections.hpp"

namespace assur::report {
namespace {

using tuning::Answer;

Answer answer(const std::string& scene, std::vector<std::string> without, double chosen, double best) {
  Answer a;
  a.question = {scene, std::move(without), 2};
  a.chosen = {"irreducible/lanes:8", chosen, chosen / 100, 21, 1e-15};
  a.again = {a.chosen.strategy, chosen / 1.07, chosen / 100, 21, 1e-15};
  a.best = {chosen == best ? "irreducible/lanes:8" : "groups/klu", best, best / 50, 15, 2e-15};
  a.untuned = {"irreducible/lanes", 1.6 * best, best / 50, 21, 1e-15};
  a.best_trial_seconds = best;
  a.uniform = {{"groups/klu", 1.5 * best}, {"groups/eigen", 3 * best}};
  return a;
}

const std::vector<Answer>& answers() {
  static const std::vector<Answer> kAll = {answer("four_bar:5", {}, 1e-6, 1e-6), answer("andrews", {}, 2.2e-6, 2e-6),
                                           answer("stewart", {"lanes"}, 6e-6, 4e-6)};
  return kAll;
}

// As many with one set of backends as a comparison with constant strategies needs.
std::vector<Answer> many_answers() {
  std::vector<Answer> all;
  for (int n = 1; n <= 10; ++n) all.push_back(answer("four_bar:" + std::to_string(n), {}, 1.1e-6, 1e-6));
  return all;
}

TEST(RegretSection, EveryRegretIsTheRatioOfItsTimes) {
  const Section s = regret_section(answers(), 62);
  std::map<std::string, std::map<std::string, double>> by_item;
  for (const Measurement& m : s.measurements) by_item[m.item][m.quantity] = m.value;
  for (const Answer& a : answers()) {
    const std::string item = a.question.scene + (a.question.without.empty() ? "" : ", -lanes");
    ASSERT_TRUE(by_item.contains(item)) << item;
    auto& of = by_item[item];
    EXPECT_DOUBLE_EQ(of["regret"], of["seconds per step, auto"] / of["seconds per step, fastest"] - 1);
    EXPECT_FALSE(of.contains("regret of the best constant strategy"));
  }
}

// The best of several strategies for two questions is good in both, whatever the strategies are.
TEST(RegretSection, ComparesWithAConstantStrategyOnlyOverManyQuestions) {
  const Section few = regret_section(answers(), 62), many = regret_section(many_answers(), 62);
  EXPECT_EQ(few.body.find("best constant"), std::string::npos);
  EXPECT_NE(few.body.find("So few answers say little"), std::string::npos);
  EXPECT_NE(many.body.find("best constant"), std::string::npos);
  EXPECT_EQ(many.body.find("So few answers say little"), std::string::npos);
  int constants = 0;
  for (const Measurement& m : many.measurements) {
    if (m.quantity != "regret of the best constant strategy") continue;
    EXPECT_DOUBLE_EQ(m.value, 0.5);
    ++constants;
  }
  EXPECT_EQ(constants, 10);
}

TEST(RegretSection, ShowsWhatTuningGains) {
  const Section s = regret_section(answers(), 62);
  EXPECT_NE(s.body.find("auto without measurements"), std::string::npos);
  int figures = 0;
  for (const Measurement& m : s.measurements) {
    if (!m.quantity.starts_with("regret without measurements")) continue;
    EXPECT_NEAR(m.value, 0.6, 1e-12) << m.quantity;
    ++figures;
  }
  EXPECT_EQ(figures, 4);
}

TEST(RegretSection, FiguresOfThePageEqualTheMeasurements) {
  const Section s = regret_section(answers(), 62);
  std::vector<double> regrets;
  for (const Measurement& m : s.measurements) {
    if (m.quantity == "regret") regrets.push_back(m.value);
  }
  std::sort(regrets.begin(), regrets.end());
  ASSERT_EQ(regrets.size(), 3u);
  EXPECT_NEAR(regrets[1], 0.1, 1e-12);
  EXPECT_NEAR(regrets[2], 0.5, 1e-12);
  for (const Measurement& m : s.measurements) {
    if (m.item != "all questions" || m.strategy != "auto" || !m.quantity.starts_with("regret, ")) continue;
    const std::map<std::string, double> again = {{"regret, median", regrets[1]},
                                                 {"regret, p95", regrets[2]},
                                                 {"regret, max", regrets[2]},
                                                 {"regret, mean", (regrets[0] + regrets[1] + regrets[2]) / 3}};
    EXPECT_DOUBLE_EQ(m.value, again.at(m.quantity));
    EXPECT_NE(s.body.find(">" + percent(m.value) + "<"), std::string::npos) << m.quantity;
  }
  EXPECT_EQ(std::count_if(s.measurements.begin(), s.measurements.end(),
                          [](const Measurement& m) {
                            return m.quantity.starts_with("regret to itself, ") && std::abs(m.value - 0.07) < 1e-12;
                          }),
            4);  // median, p95, max and mean
  EXPECT_NE(s.body.find("auto against itself"), std::string::npos);
  EXPECT_NE(s.body.find("3 of 62"), std::string::npos);
}

TEST(RegretSection, NamesTheWorstCasesFirst) {
  const std::string body = regret_section(answers(), 62).body;
  const std::size_t table = body.find("worst cases");
  ASSERT_NE(table, std::string::npos);
  const std::size_t worst = body.find("stewart, -lanes", table), next = body.find("andrews", table);
  EXPECT_LT(worst, next);
  EXPECT_NE(next, std::string::npos);
  EXPECT_EQ(body.find("four_bar:5", table), std::string::npos);
}

TEST(RegretSection, ReportsThatThereAreNoAnswers) {
  const Section s = regret_section({}, 62);
  EXPECT_TRUE(s.measurements.empty());
  EXPECT_NE(s.body.find("No question was answered"), std::string::npos);
}

}  // namespace
}  // namespace assur::report
