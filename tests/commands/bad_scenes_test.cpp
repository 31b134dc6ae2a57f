// Every file of tests/data/bad_scenes through the command: the exact lines, exit status 2, nothing on standard output.
#include <gtest/gtest.h>

#include <sstream>

#include "builder/bad_scenes.hpp"
#include "commands/command.hpp"

namespace assur {
namespace {

using bad_scenes::kFolder;

std::vector<std::string> expected_lines(const std::string& scene) {
  std::istringstream stream(bad_scenes::expected(scene));
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

class BadScene : public testing::TestWithParam<std::string> {};

TEST_P(BadScene, IsRefusedWithTheExpectedLines) {
  std::string expected;
  for (const std::string& line : expected_lines(GetParam())) expected += "error: " + line + "\n";
  const Outcome outcome = run_command({"run", GetParam() + ".json"}, {kFolder, {}, {}});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(outcome.err, expected);
}

INSTANTIATE_TEST_SUITE_P(Folder, BadScene, testing::ValuesIn(bad_scenes::names()),
                         [](const auto& test) { return test.param; });

TEST(BadScenes, JsonHasADiagnosticForEveryLine) {
  const Outcome outcome = run_command({"inspect", "several_findings.json", "--json"}, {kFolder, {}, {}});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.err, "");
  const auto json = outcome.json();
  EXPECT_EQ(json["error"]["kind"], "input");
  std::vector<std::string> lines;
  for (const auto& d : json["error"]["diagnostics"]) {
    lines.push_back("several_findings.json: " + std::string(d["where"]) + ": " + std::string(d["what"]));
  }
  EXPECT_EQ(lines, expected_lines("several_findings"));
  EXPECT_EQ(json["error"]["message"].get<std::string>() + "\n", bad_scenes::expected("several_findings"));
  EXPECT_GE(lines.size(), 2u);
}

TEST(BadScenes, AnUnreadableFileIsAnEnvironmentError) {
  const Outcome outcome = run_command({"run", "no_such_scene.json"});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_EQ(outcome.err.rfind("error: no_such_scene.json: ", 0), 0u) << outcome.err;
}

}  // namespace
}  // namespace assur
