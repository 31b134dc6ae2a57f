// The files of the stability suite and their syntax.
#include "check/case.hpp"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "check/runner.hpp"

namespace assur::check {
namespace {

std::string message(const std::string& text) {
  try {
    (void)parse_cases(R"({"family": "f", "cases": [)" + text + "]}", "f.json");
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::input);
    return error.what();
  }
  return "no error";
}

TEST(Cases, IncludeAllRequiredCases) {
  const std::vector<Case> cases = all_cases();
  std::set<std::string> named, names;
  std::map<std::string, int> families, quick;
  for (const Case& c : cases) {
    EXPECT_TRUE(names.insert(c.name).second) << c.name;  // `--case` finds them by name
    named.insert(c.name.substr(0, c.name.find(' ')));
    ++families[c.family];
    quick[c.family] += c.quick ? 1 : 0;
    EXPECT_FALSE(c.about.empty()) << c.name;
    EXPECT_FALSE(c.expected.verdicts.empty()) << c.name;
  }
  EXPECT_GE(named.size(), 60u);
  EXPECT_EQ(families.size(), 9u);
  for (const auto& [family, count] : quick) {
    EXPECT_EQ(count > 0, family != "size" || count > 0) << family;
    EXPECT_GT(count, 0) << family;
  }
}

// A scene with a reading error would otherwise count as a refusal.
TEST(Cases, HaveReadableScenesUnlessRefusalIsExpected) {
  for (const Case& c : all_cases()) {
    if (!c.matrix.empty() || c.maker == "wide") continue;
    if (c.expected.verdicts.front() == "refused" && c.family == "values") continue;
    if (c.maker == "table") continue;  // one of these is too short on purpose
    EXPECT_NO_THROW((void)scene_of(c)) << c.name;
  }
}

TEST(Cases, ExpandASweepIntoOneCaseForEachValue) {
  const std::vector<Case> cases = parse_cases(R"({"family": "f", "cases": [
    {"name": "a", "about": "x", "sample": "four_bar", "set": {"steps": 3}, "sweep": {"step": [0.1, 1e-9]},
     "expected_each": ["pass", ["inaccurate", {"refused": "why"}]], "because": "y", "accuracy": 1e-3},
    {"name": "b", "about": "x", "maker": "table", "time": [0, 1, 0.5], "expected": "singular", "formulations": ["groups"]}
  ]})",
                                              "f.json");
  ASSERT_EQ(cases.size(), 3u);
  EXPECT_EQ(cases[0].name, "a step=0.1");
  EXPECT_EQ(cases[1].name, "a step=1e-09");
  EXPECT_EQ(cases[1].set, (Parameters{{"steps", 3}, {"step", 1e-9}}));
  EXPECT_EQ(to_string(cases[0].expected), "pass");
  EXPECT_EQ(to_string(cases[1].expected), "inaccurate or refused");
  EXPECT_EQ(cases[1].expected.message, "why");
  EXPECT_EQ(cases[1].accuracy, 1e-3);
  EXPECT_EQ(cases[2].family, "f");
  ASSERT_TRUE(cases[2].time);
  EXPECT_EQ(cases[2].time->steps(), 2);
  EXPECT_EQ(cases[2].formulations, std::vector{Formulation::groups});
}

TEST(Cases, ReportErrorsOfTheirFile) {
  const std::string head = R"({"name": "a", "about": "x", )";
  EXPECT_EQ(message(R"({"about": "x"})"), "f.json: a case needs the key \"name\"");
  EXPECT_EQ(message(R"({"name": "a", "about": "x", "expected": "pass"})"),
            "f.json: a: a case needs exactly one of \"sample\", \"scene\", \"maker\" and \"matrix\"");
  EXPECT_EQ(message(head + R"("sample": "s", "expected": "fine"})"), "f.json: a: a case cannot expect \"fine\"");
  EXPECT_EQ(message(head + R"("sample": "s", "expected": ["pass", "singular"]})"),
            "f.json: a: a case with several expected verdicts needs a reason: \"because\"");
  EXPECT_EQ(message(head + R"("sample": "s", "expected": "pass", "acuracy": 1})"),
            "f.json: a: a case cannot have the key \"acuracy\"");
  EXPECT_EQ(message(head + R"("sample": 3, "expected": "pass"})"),
            "f.json: a: a case has a value of the wrong type for \"sample\"");
  EXPECT_EQ(message(head + R"("sample": "s", "sweep": {"x": [1, 2]}, "expected_each": ["pass"]})"),
            "f.json: a: a case needs one entry of \"expected_each\" for each value of its sweep");
}

}  // namespace
}  // namespace assur::check
