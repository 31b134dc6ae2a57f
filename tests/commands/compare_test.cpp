// assur compare: error against run time.
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "commands/command.hpp"

namespace assur {
namespace {

const std::vector<std::string> kCall = {
    "compare",    "stewart",  "--steps", "30", "--quiet", "--strategies", "groups/eigen,irreducible/lanes:8+once",
    "--accuracy", "1e-4,1e-8"};

std::vector<std::string> with(std::vector<std::string> call, const std::vector<std::string>& more) {
  call.insert(call.end(), more.begin(), more.end());
  return call;
}

TEST(Compare, JsonHasARowForEachStrategyAndEachAccuracy) {
  const Outcome o = run_command(with(kCall, {"--json"}));
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_EQ(o.err, "");
  const auto json = o.json();
  EXPECT_EQ(json["scene"], "stewart");
  EXPECT_EQ(json["steps"], 30);
  std::multiset<double> picked;
  std::map<std::string, std::set<double>> asked;
  bool any_front = false;
  double before = 0;
  for (const auto& row : json["rows"]) {
    ASSERT_EQ(row["status"], "ok");
    EXPECT_GE(row["seconds_per_step"], before);
    before = row["seconds_per_step"];
    if (row["picked"]) picked.insert(row["accuracy"].get<double>());
    asked[row["strategy"]].insert(row["accuracy"].is_null() ? 0 : row["accuracy"].get<double>());
    any_front = any_front || row["on_front"].get<bool>();
    if (!json["no_yardstick"].is_null()) continue;
    for (const char* kind : {"forward_position", "forward_velocity", "forward_acceleration"}) {
      EXPECT_GE(row[kind], 0);
      // The error is below the required accuracy, or, if there is none, a multiple of rounding.
      EXPECT_LE(row[kind], row["accuracy"].is_null() ? 1e-12 : row["accuracy"].get<double>()) << row["strategy"];
    }
    if (row["picked"]) {
      EXPECT_GE(row["behind"], 0);
    }
  }
  EXPECT_EQ(picked, (std::multiset<double>{1e-4, 1e-8}));
  for (const char* strategy : {"groups/eigen", "irreducible/lanes:8+once"}) {
    EXPECT_EQ(asked[strategy], (std::set<double>{0, 1e-4, 1e-8})) << strategy;
  }
  EXPECT_EQ(any_front, json["no_yardstick"].is_null());
}

TEST(Compare, ComparesAutoAlone) {
  const Outcome o = run_command(
      {"compare", "four_bar", "--steps", "20", "--quiet", "--strategies", "auto", "--accuracy", "1e-6", "--json"});
  ASSERT_EQ(o.status, 0) << o.err;
  ASSERT_EQ(o.json()["rows"].size(), 1u);
  EXPECT_EQ(o.json()["rows"][0]["picked"], true);
}

TEST(Compare, PageHasTheDiagramAndEveryRow) {
  const Scratch scratch;
  const std::string file = scratch.file("compare.html");
  const Outcome o = run_command(with(kCall, {"--html", file, "--json"}));
  ASSERT_EQ(o.status, 0) << o.err;
  std::string page = content(file);
  for (std::size_t at = 0; (at = page.find("<wbr>", at)) != std::string::npos;) page.erase(at, 5);
  EXPECT_EQ(page.find("<!DOCTYPE html>"), 0u);
  for (const auto& row : o.json()["rows"]) {
    EXPECT_NE(page.find("<td>" + row["strategy"].get<std::string>() + "</td>"), std::string::npos) << row;
  }
  if (o.json()["no_yardstick"].is_null()) {
    EXPECT_NE(page.find("<svg class=\"plot narrow\""), std::string::npos);
  }
  EXPECT_EQ(page.find("http://"), page.find("http://www.w3.org/2000/svg"));
}

TEST(Compare, TableNamesTheChoicesOfAuto) {
  const Outcome o = run_command(kCall);
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_NE(o.out.find("stewart: true error against time, 30 steps of 0.01 s"), std::string::npos);
  EXPECT_NE(o.out.find("groups/eigen"), std::string::npos);
  EXPECT_NE(o.out.find("auto, required"), std::string::npos);
}

TEST(Compare, ReportsWrongArguments) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"--accuracy", "fine"}, "--accuracy: expects numbers > 0 such as 1e-4,1e-8, not \"fine\""},
      {{"--accuracy", "1e-4,0"}, "--accuracy: expects numbers > 0 such as 1e-4,1e-8, not \"1e-4,0\""},
      {{"--strategies", "groups/eigen+chunks=4"}, "remove +chunks="},
      {{"--html", ""}, "--html: expects a file name"},
      {{"--steps", "0"}, "--steps: expects a whole number from 1 to 2147483647, not \"0\""},
  };
  for (const auto& [options, message] : cases) {
    const Outcome o = run_command(with({"compare", "stewart"}, options));
    EXPECT_EQ(o.status, 2) << options[1];
    EXPECT_EQ(o.out, "");
    EXPECT_NE(o.err.find(message), std::string::npos) << o.err;
  }
}

TEST(Compare, MissingBackendsAndUnwritableFilesAreEnvironmentErrors) {
  const Scratch scratch;
  const Outcome page = run_command(with(kCall, {"--html", scratch.file("no_such_folder/page.html")}));
  EXPECT_EQ(page.status, 3);
  EXPECT_NE(page.err.find("no_such_folder"), std::string::npos) << page.err;
  const Outcome strategy = run_command({"compare", "stewart", "--strategies", "groups/klu+float"});
  EXPECT_EQ(strategy.status, 3);
  EXPECT_NE(strategy.err.find("klu"), std::string::npos) << strategy.err;
}

}  // namespace
}  // namespace assur
