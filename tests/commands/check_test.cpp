// The command `assur check`.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "commands/command.hpp"

namespace assur {
namespace {

TEST(Check, JsonHasTheKeysOfTheContract) {
  const Outcome outcome = run_command({"check", "--case", "dwell", "--json", "--quick"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto json = outcome.json();
  std::set<std::string> keys;
  for (const auto& [key, value] : json.items()) keys.insert(key);
  EXPECT_EQ(keys, (std::set<std::string>{"cases", "passed", "failed", "left_out"}));
  ASSERT_EQ(json["cases"].size(), 1u);
  keys.clear();
  for (const auto& [key, value] : json["cases"][0].items()) keys.insert(key);
  EXPECT_EQ(keys, (std::set<std::string>{"name", "expected", "verdict", "forward_error", "backward_error", "condition",
                                         "bound"}));
  EXPECT_EQ(json["cases"][0]["name"], "dwell");
  EXPECT_EQ(json["cases"][0]["expected"], "pass");
  EXPECT_EQ(json["cases"][0]["verdict"], "pass");
  const double kappa = json["cases"][0]["condition"], epsilon = 2.2204460492503131e-16;
  EXPECT_DOUBLE_EQ(json["cases"][0]["bound"], epsilon * kappa * kappa);
  EXPECT_LE(json["cases"][0]["forward_error"], 8 * epsilon * std::pow(kappa, 3));  // equations hold to 8 eps
  EXPECT_EQ(json["passed"], 1);
  EXPECT_EQ(json["failed"], 0);
}

TEST(Check, PageHasOneRowForEachFamily) {
  const Outcome outcome = run_command({"check", "--case", "table_", "--quick"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  ASSERT_GE(outcome.lines().size(), 2u);
  EXPECT_EQ(outcome.lines()[0].rfind("  family  cases  unexpected", 0), 0u) << outcome.out;
  EXPECT_EQ(outcome.lines()[1].rfind("  time        5           0", 0), 0u) << outcome.out;
  EXPECT_NE(outcome.out.find("unexpected      nothing"), std::string::npos) << outcome.out;
}

TEST(Check, RunsScenesOfTheUserWithAllStrategies) {
  const Outcome outcome = run_command({"check", "slider_crank", "--set", "steps=5", "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  ASSERT_EQ(outcome.json()["cases"].size(), 1u);
  EXPECT_EQ(outcome.json()["cases"][0]["name"], "slider_crank");
  EXPECT_EQ(outcome.json()["cases"][0]["verdict"], "pass");
}

TEST(Check, RejectsAnInvalidSceneAsBadInput) {
  const Outcome outcome = run_command({"check", "slider_crank", "no_such_sample"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_NE(outcome.err.find("no_such_sample"), std::string::npos) << outcome.err;
  EXPECT_EQ(run_command({"check", "--case", "bogus"}).err,
            "error: --case: no case has a name that starts with \"bogus\"\n");
}

// Next to a change point some strategies pass, and others do not tell the branches apart.
TEST(Check, ReportsDisagreeingStrategiesWithTheirCommands) {
  const Outcome outcome =
      run_command({"check", "almost_parallelogram:delta=1e-12,step=0.01,steps=50",
                   "almost_parallelogram:delta=3e-14,step=0.01,steps=50", "--set", "step=0.1", "--quick"});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.out.find("branch_unknown"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("assur run"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("'almost_parallelogram:delta="), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("step=0.1 --strategy"), std::string::npos) << outcome.out;
}

TEST(Check, CtrlCKeepsFinishedCases) {
  // The remaining time is shown after the first case.
  const Outcome outcome = run_command({"check", "--json"}, {{}, {}, " left"});
  EXPECT_EQ(outcome.status, 130);
  EXPECT_GT(outcome.json()["cases"].size(), 0u);
}

}  // namespace
}  // namespace assur
