#include "measure/regret_question.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace assur::measure {
namespace {

std::set<std::string> strategies(const Answer& a) {
  std::set<std::string> all;
  for (const auto& [strategy, seconds] : a.uniform) {
    EXPECT_GT(seconds, 0) << strategy;
    EXPECT_TRUE(std::isfinite(seconds)) << strategy;
    all.insert(strategy);
  }
  return all;
}

// Else whatever comes last would be no candidate for the best where something before it takes long.
TEST(RegretQuestion, EveryCandidateHasATimeHoweverShortTheRace) {
  QuestionOptions options;
  options.quick = true;
  options.seconds = 1;
  const auto enough = answer({"four_bar", {"mumps"}, 1}, options);
  options.seconds = 1e-4;
  const auto short_of_time = answer({"four_bar", {"mumps"}, 1}, options);
  ASSERT_TRUE(enough && short_of_time);
  EXPECT_GE(strategies(*enough).size(), 10u);
  EXPECT_EQ(strategies(*short_of_time), strategies(*enough));
}

}  // namespace
}  // namespace assur::measure
