#include "tuning/probe.hpp"

#include <gtest/gtest.h>

#include <set>

#include "measure/step_times.hpp"

namespace assur::tuning {
namespace {

std::vector<std::string> shell(const std::string& script) { return {"/bin/sh", "-c", script}; }

TEST(Probe, DescribesTheEndOfAChild) {
  EXPECT_EQ(try_in_child(shell("exit 0"), 10), "");
  EXPECT_EQ(try_in_child(shell("kill -SEGV $$"), 10), "crashes (signal 11)");
  EXPECT_EQ(try_in_child(shell("kill -ABRT $$"), 10), "crashes (signal 6)");
  EXPECT_EQ(try_in_child(shell("exit 3"), 10), "fails on a well-conditioned matrix (status 3)");
  EXPECT_EQ(try_in_child({"/there/is/no/such/program"}, 10), "its trial cannot be started");
}

TEST(Probe, StopsAHangingChild) {
  const double begin = measure::StepTimes::steady();
  EXPECT_EQ(try_in_child({"/bin/sleep", "600"}, 0.05), "does not end");
  EXPECT_LT(measure::StepTimes::steady() - begin, 60);
}

TEST(Probe, EveryBackendThatRunsHerePassesItsTrial) {
  for (const Backend& backend : backends()) {
    if (!backend.why_not({}, {}).empty()) continue;
    Strategy s;
    s.solver.backend = backend.id;
    EXPECT_NO_THROW(probe(s, backends())) << backend.id;
  }
}

TEST(Probes, TryNonCoreAndThreadedBackends) {
  std::set<std::string> tried;
  const Probes probes(
      backends(), ThreadBudget{2},
      [&](const Strategy& s) {
        tried.insert(to_string(s));
        return shell(s.solver.backend == "klu" || s.solver.threads > 1 ? "kill -SEGV $$" : "exit 0");
      },
      10);
  EXPECT_EQ(tried.count("groups/eigen"), 0u);
  EXPECT_EQ(tried.count("groups/lanes"), 0u);
  for (const Backend& backend : backends()) {
    if (backend.id == "eigen" || backend.id == "lanes" || !backend.why_not({}, {}).empty()) continue;
    EXPECT_EQ(tried.count("groups/" + std::string(backend.id)), 1u);
  }
  EXPECT_EQ(probes.why_not(parse_strategy("groups/eigen")), "");
  if (tried.count("groups/klu") != 0) {
    EXPECT_EQ(probes.why_not(parse_strategy("irreducible/klu+refine")), "crashes (signal 11)");
    EXPECT_EQ(probes.failed().at("klu"), "crashes (signal 11)");
  }
  if (tried.count("groups/team 1x2") != 0) {
    EXPECT_EQ(probes.why_not(parse_strategy("groups/team 1x2")), "crashes (signal 11)");
    EXPECT_EQ(probes.why_not(parse_strategy("groups/team")), "");
  }
}

// The first child hangs and ignores signals. It is killed and recorded by name, and all others are tried.
TEST(Probes, ContinueAfterAHangingChild) {
  std::vector<std::string> tried;
  const auto command = [&](const Strategy& s) {
    tried.push_back(to_string(s));
    return shell(tried.size() == 1 ? "trap '' TERM INT HUP; while :; do :; done" : "exit 0");
  };
  const Probes probes(backends(), ThreadBudget{2}, command, 3);
  if (tried.empty()) GTEST_SKIP() << "this build has no backend that is tried in a child";
  const Strategy first = parse_strategy(tried.front());
  EXPECT_EQ(std::set<std::string>(tried.begin(), tried.end()).size(), tried.size());
  EXPECT_EQ(probes.failed(), (std::map<std::string, std::string>{
                                 {first.solver.backend + (first.solver.threads > 1 ? " 1x2" : ""), "does not end"}}));
  EXPECT_EQ(probes.why_not(first), "does not end");
  for (std::size_t i = 1; i < tried.size(); ++i) {
    const Strategy s = parse_strategy(tried[i]);
    EXPECT_EQ(probes.why_not(s),
              s.solver.backend == first.solver.backend && first.solver.threads == 1 ? "does not end" : "")
        << tried[i];
  }
}

}  // namespace
}  // namespace assur::tuning
