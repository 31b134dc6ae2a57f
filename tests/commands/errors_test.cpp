// assur run --errors and --accuracy.
#include <gtest/gtest.h>

#include <map>
#include <set>
#include <sstream>

#include "commands/command.hpp"

namespace assur {
namespace {

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> all = {""};
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      all.emplace_back();
    } else {
      all.back() += c;
    }
  }
  return all;
}

TEST(Errors, HasOneRowForEachStepAndGroup) {
  const Scratch scratch;
  const std::string file = scratch.file("errors.csv");
  const Outcome o = run_command(
      {"run", "stewart", "--steps", "20", "--quiet", "--json", "--strategy", "groups/eigen", "--errors", file});
  ASSERT_EQ(o.status, 0) << o.err;
  std::istringstream lines(content(file));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "t,group,residual,estimated,error,condition,iterations,substeps");
  std::map<std::string, std::set<double>> times;  // by group
  double worst = 0;
  while (std::getline(lines, line)) {
    const std::vector<std::string> row = cells(line);
    ASSERT_EQ(row.size(), 8u) << line;
    times[row[1]].insert(std::stod(row[0]));
    worst = std::max(worst, std::stod(row[2]));
    EXPECT_GE(std::stod(row[5]), 1) << line;
    EXPECT_GT(std::stod(row[3]), 0) << line;
    EXPECT_EQ(row[4], "");  // without --reference
    EXPECT_EQ(row[7], "0");
  }
  EXPECT_EQ(times.size(), 7u);  // the terminal and six legs
  for (const auto& [group, at] : times) EXPECT_EQ(at.size(), 21u) << group;
  EXPECT_GT(worst, 0);
  EXPECT_LE(worst, 1e-14);
}

TEST(Errors, HasTrueErrorsWithReference) {
  const Scratch scratch;
  const std::string file = scratch.file("errors.csv");
  const Outcome o = run_command(
      {"run", "four_bar", "--steps", "10", "--quiet", "--strategy", "groups/eigen", "--reference", "--errors", file});
  if (o.status == 3) GTEST_SKIP() << o.err;  // no quad precision here
  ASSERT_EQ(o.status, 0) << o.err;
  std::istringstream lines(content(file));
  std::string line;
  std::getline(lines, line);
  double worst = 0;
  while (std::getline(lines, line)) {
    const std::vector<std::string> row = cells(line);
    const double error = std::stod(row.at(4));
    worst = std::max(worst, error);
    EXPECT_LE(error, 100 * 2.3e-16 * std::stod(row.at(5))) << line;
  }
  EXPECT_GT(worst, 0);
}

TEST(Errors, IsRefusedWithoutSingleSteps) {
  for (const auto& more : {std::vector<std::string>{"--mode", "throughput"}, {"--strategy", "groups/eigen+chunks=4"}}) {
    std::vector<std::string> call = {"run", "stewart", "--errors", "/dev/null"};
    call.insert(call.end(), more.begin(), more.end());
    const Outcome o = run_command(call);
    EXPECT_EQ(o.status, 2);
    EXPECT_NE(o.err.find("--errors"), std::string::npos) << o.err;
  }
  const Outcome o = run_command({"run", "stewart", "--errors", "/no_such_folder/errors.csv"});
  EXPECT_EQ(o.status, 3);
  EXPECT_NE(o.err.find("/no_such_folder/errors.csv"), std::string::npos) << o.err;
}

TEST(Accuracy, EveryRunReportsEstimatedErrors) {
  const auto json = run_command({"run", "stewart", "--steps", "5", "--json", "--accuracy", "1e-9"}).json();
  for (const char* kind : {"position", "velocity", "acceleration"}) {
    const auto estimate = json["error"].at(std::string("estimated_") + kind);
    EXPECT_GT(estimate, 0) << kind;
    EXPECT_LE(estimate, 1e-9) << kind;
  }
  EXPECT_EQ(json["status"], "ok");
}

TEST(Accuracy, ReportsUnreachableAccuracyAndContinues) {
  const Outcome o = run_command({"run", "stewart", "--steps", "5", "--accuracy", "1e-17"});
  EXPECT_EQ(o.status, 1);
  EXPECT_NE(o.out.find("done, but inaccurate"), std::string::npos) << o.out;
  EXPECT_NE(o.err.find("inaccurate"), std::string::npos) << o.err;
  const auto json = run_command({"run", "stewart", "--steps", "5", "--json", "--accuracy", "1e-17"}).json();
  EXPECT_EQ(json["status"], "inaccurate");
  EXPECT_EQ(json["steps"], 5);
  EXPECT_EQ(json["events"][0]["kind"], "inaccurate");
}

}  // namespace
}  // namespace assur
