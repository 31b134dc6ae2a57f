// --threads, with the limits of this machine.
#include <gtest/gtest.h>

#include <cstdlib>

#include "assur/machine.hpp"
#include "commands/command.hpp"

namespace assur {
namespace {

std::string count(int number, const std::string& what) {
  return std::to_string(number) + " " + what + (number == 1 ? "" : "s");
}

TEST(Threads, EveryCommandRefusesMoreThreadsThanProcessors) {
  const int processors = this_machine().processors;
  const std::string more = std::to_string(processors + 1);
  for (const auto& command :
       std::vector<std::vector<std::string>>{{"run", "stewart"}, {"inspect", "stewart"}, {"backends"}}) {
    std::vector<std::string> arguments = command;
    arguments.insert(arguments.end(), {"--threads", more});
    const Outcome outcome = run_command(arguments);
    EXPECT_EQ(outcome.status, 2);
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(outcome.err, "error: --threads: " + more + " threads are too many: this process may use " +
                               count(processors, "processor") + "\n");
  }
}

// With OMP_NUM_THREADS=1 a second thread exceeds the budget. The test needs two processors.
TEST(Threads, WarnsOfMoreThreadsThanTheBudget) {
  if (this_machine().processors < 2) GTEST_SKIP() << "one processor";
  const char* const before = std::getenv("OMP_NUM_THREADS");
  const std::string kept = before ? before : "";
  setenv("OMP_NUM_THREADS", "1", 1);
  const Outcome loud = run_command({"backends", "--threads", "2"});
  const Outcome quiet = run_command({"backends", "--threads", "2", "--quiet"});
  const Outcome within = run_command({"backends", "--threads", "1"});
  if (before) {
    setenv("OMP_NUM_THREADS", kept.c_str(), 1);
  } else {
    unsetenv("OMP_NUM_THREADS");
  }
  EXPECT_EQ(loud.status, 0);
  EXPECT_EQ(loud.err.rfind("warning: --threads: 2 threads exceed the budget of this machine; ", 0), 0u) << loud.err;
  EXPECT_EQ(quiet.err, "");
  EXPECT_EQ(within.err, "");
}

TEST(Threads, LimitTheStrategy) {
  const auto listed = run_command({"backends", "--json"}).json();
  for (const auto& backend : listed["backends"]) {
    if (backend["id"] == "team" && !backend["available"]) GTEST_SKIP() << backend["why_not"];
  }
  const std::vector<std::string> run = {"run", "stewart", "--steps", "1", "--strategy", "groups/team 1x2", "--threads"};
  std::vector<std::string> arguments = run;
  arguments.push_back("1");
  const Outcome one = run_command(arguments);
  EXPECT_EQ(one.status, 3);
  EXPECT_EQ(one.err,
            "error: strategy groups/team 1x2 cannot run here: it takes 2 threads and the budget is 1; choose a smaller "
            "PxQ or a larger budget\n");
  if (this_machine().processors < 2) return;
  arguments.back() = "2";
  EXPECT_EQ(run_command(arguments).status, 0);
}

}  // namespace
}  // namespace assur
