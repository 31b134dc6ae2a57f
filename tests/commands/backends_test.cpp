#include <gtest/gtest.h>

#include "assur/backend.hpp"
#include "commands/command.hpp"

namespace assur {
namespace {

TEST(Backends, JsonHasOneRowForEachBackend) {
  const Outcome outcome = run_command({"backends", "--json"});
  ASSERT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.err, "");
  const auto rows = outcome.json()["backends"];
  ASSERT_EQ(rows.size(), backends().size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Backend& backend = backends()[i];
    const std::string why_not = backend.why_not(Shape{}, ThreadBudget{});
    EXPECT_EQ(rows[i]["id"], backend.id);
    EXPECT_EQ(rows[i]["available"], why_not.empty());
    EXPECT_EQ(rows[i]["why_not"].is_null() ? "" : rows[i]["why_not"].get<std::string>(), why_not);
    EXPECT_EQ(rows[i]["version"].is_null() ? "" : rows[i]["version"].get<std::string>(), backend.version());
    EXPECT_EQ(rows[i]["slowed"].is_null() ? "" : rows[i]["slowed"].get<std::string>(),
              backend.slowed ? backend.slowed() : "");
    EXPECT_EQ(rows[i]["licence"], backend.licence);
    EXPECT_EQ(rows[i]["steady"], backend.steady);
  }
  const auto code = outcome.json()["machine_code"];
  EXPECT_TRUE(code.is_null() || code == "AVX2" || code == "AVX-512");
}

TEST(Backends, MachineCodeIsShownAndRuns) {
  const bool has_code = !run_command({"backends", "--json"}).json()["machine_code"].is_null();
  const Outcome page = run_command({"backends"});
  EXPECT_NE(page.out.find(has_code ? "for steps of small groups" : "it needs x86-64"), std::string::npos) << page.out;
  const auto rows = [](std::vector<std::string> more) {
    std::vector<std::string> command = {"run",     "stewart", "--steps", "50", "--strategy", "irreducible/lanes:8",
                                        "--quiet", "--csv",   "-"};
    command.insert(command.end(), more.begin(), more.end());
    const Outcome outcome = run_command(command);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.out;
  };
  EXPECT_EQ(rows({}), rows({"--no-machine-code"}));
}

TEST(Backends, PageShowsWhetherEachBackendRuns) {
  const Outcome outcome = run_command({"backends"});
  ASSERT_EQ(outcome.status, 0);
  const auto lines = outcome.lines();
  ASSERT_GT(lines.size(), backends().size());
  EXPECT_EQ(lines[0].rfind("  backend   runs here  version", 0), 0u) << lines[0];
  for (std::size_t i = 0; i < backends().size(); ++i) {
    const Backend& backend = backends()[i];
    const std::string why_not = backend.why_not(Shape{}, ThreadBudget{});
    EXPECT_EQ(lines[i + 1].rfind("  " + std::string(backend.id) + " ", 0), 0u) << lines[i + 1];
    EXPECT_NE(lines[i + 1].find(why_not.empty() ? " yes " : " no "), std::string::npos) << lines[i + 1];
    EXPECT_NE(lines[i + 1].find(backend.licence), std::string::npos);
  }
}

}  // namespace
}  // namespace assur
