// `assur plan`: programs can run the plans that it saves.
#include <gtest/gtest.h>

#include <fstream>
#include <regex>

#include "assur/saved_plan.hpp"
#include "assur/simulator.hpp"
#include "commands/command.hpp"

namespace assur {
namespace {

TEST(Plan, SavedPlansRun) {
  const Scratch scratch;
  const std::string file = scratch.file("stewart.plan");
  const Outcome o = run_command({"plan", "stewart", "--without", "klu", "--save", file, "--json"});
  ASSERT_EQ(o.status, 0) << o.err;
  std::ifstream in(file);
  const Prepared prepared = load_plan(in, {.table = backends()});
  EXPECT_EQ(prepared.name(), "stewart");
  ASSERT_EQ(prepared.plan().choices.size(), o.json()["classes"].size());
  for (std::size_t c = 0; c < prepared.plan().choices.size(); ++c) {
    EXPECT_EQ(o.json()["classes"][c]["strategy"], to_string(prepared.plan().strategy(prepared.plan().choices[c])));
  }
  Simulator simulator(prepared);
  EXPECT_EQ(simulator.run().rows(), 1001u);
  EXPECT_TRUE(simulator.report().status.ok());
}

TEST(Plan, UsesOnlyTheNamedDatabase) {
  const Scratch scratch;
  const std::string missing = scratch.file("none.db");
  for (const char* command : {"plan", "run"}) {
    const Outcome o = run_command({command, "stewart", "--db", missing});
    EXPECT_EQ(o.status, 3) << command;
    EXPECT_NE(o.err.find(missing), std::string::npos) << o.err;
  }
}

TEST(Plan, SaysHowStepsUseMachineCode) {
  const bool has_code = !Simulator(prepare(sample("four_bar"))).machine_code().empty();  // on this processor
  const std::string small = run_command({"plan", "four_bar", "--json"}).json()["machine_code"];
  EXPECT_EQ(small.find("one call for all") != small.npos, has_code) << small;
  const std::string long_chain = run_command({"plan", "four_bar:300", "--json"}).json()["machine_code"];
  EXPECT_EQ(long_chain.find("300 of 300 groups") != long_chain.npos, has_code) << long_chain;
  const std::string large = run_command({"plan", "bennett", "--json"}).json()["machine_code"];
  EXPECT_EQ(large.find("4 of 4 groups") != large.npos, has_code) << large;
  const std::string too_large = run_command({"plan", "rings", "--json"}).json()["machine_code"];
  EXPECT_EQ(too_large.find("1 of 7 groups") != too_large.npos, has_code) << too_large;
  const std::string nothing = run_command({"plan", "gough", "--json"}).json()["machine_code"];
  EXPECT_EQ(nothing, "") << nothing;
  const std::string text = run_command({"plan", "gough"}).out;
  EXPECT_NE(text.find("\n  machine code    none\n"), text.npos) << text;
}

// Without samples, times follow from operation counts and are the same on all machines.
TEST(Plan, ShowsThePartsOfAStep) {
  const nlohmann::json all = run_command({"plan", "stewart", "--json", "--threads", "1"}).json();
  const nlohmann::json one =
      run_command({"plan", "stewart", "--outputs", "handle1.value", "--json", "--threads", "1"}).json();
  EXPECT_EQ(all["outputs"], 432);
  EXPECT_EQ(one["outputs"], 1);
  for (const nlohmann::json& plan : {all, one}) {
    EXPECT_GT(plan["expected_around_seconds"], 0);
    EXPECT_GT(plan["expected_seconds"], plan["expected_around_seconds"]);
    EXPECT_NEAR(plan["expected_storing_seconds"], 0.3e-9 * plan["outputs"].get<double>(), 1e-15);
  }
  EXPECT_GT(all["expected_around_seconds"], one["expected_around_seconds"]);
  const std::string text = run_command({"plan", "stewart", "--threads", "1"}).out;
  EXPECT_TRUE(std::regex_search(text, std::regex("\n  expected        [0-9.]+ .+s for a step\n"
                                                 "                  [0-9.]+ .+s groups; [0-9.]+ .+s laws, predictions, "
                                                 "432 outputs\n"
                                                 "                  a run that stores its rows takes 130 ns more for "
                                                 "each\n")))
      << text;
}

// A forced strategy costs what auto expected of the same strategy.
TEST(Plan, ShowsTheExpectedTimesOfAStrategy) {
  for (const char* scene : {"stewart:platforms=3", "four_bar", "four_bar:100", "rings:legs=2,n=22"}) {
    for (const char* mode : {"latency", "throughput"}) {
      const auto plan_of = [&](const std::string& strategy) {
        const Outcome o =
            run_command({"plan", scene, "--mode", mode, "--strategy", strategy, "--json", "--threads", "1"});
        EXPECT_EQ(o.status, 0) << o.err;
        return o.json();
      };
      const nlohmann::json chosen = plan_of("auto");
      const std::string strategy = chosen["classes"][0]["strategy"];
      const bool uniform = std::all_of(chosen["classes"].begin(), chosen["classes"].end(),
                                       [&](const nlohmann::json& c) { return c["strategy"] == strategy; });
      const nlohmann::json forced = plan_of(strategy);
      EXPECT_EQ(forced["classes"][0]["expected_seconds"], chosen["classes"][0]["expected_seconds"]) << scene;
      EXPECT_GT(forced["expected_seconds"], forced["expected_around_seconds"]) << scene;
      if (uniform) {
        EXPECT_NEAR(forced["expected_seconds"].get<double>() / chosen["expected_seconds"].get<double>(), 1, 1e-12)
            << scene << " " << mode << " " << strategy;
      }
    }
  }
  const Outcome unknown = run_command({"plan", "stewart", "--strategy", "groups/nothing"});
  EXPECT_EQ(unknown.status, 2) << unknown.err;
}

TEST(Plan, ShowsIfLevelsAreSolvedTogether) {
  const nlohmann::json plan = run_command({"plan", "four_bar:100", "--json", "--threads", "1"}).json();
  const nlohmann::json& of_class = plan["classes"].at(0);
  EXPECT_TRUE(
      std::regex_match(of_class["strategy"].get<std::string>(), std::regex("irreducible/lanes:[0-9]+\\+together.*")))
      << of_class["strategy"];
  EXPECT_GT(of_class["expected_seconds"], 0);
  EXPECT_GT(plan["expected_seconds"].get<double>(),
            plan["expected_around_seconds"].get<double>() + of_class["expected_seconds"].get<double>());
  const std::string chain = run_command({"plan", "four_bar:100", "--threads", "1"}).out;
  EXPECT_NE(chain.find("+together"), std::string::npos) << chain;
  EXPECT_TRUE(std::regex_search(chain, std::regex("all levels together: expected [0-9.]+ times as fast"))) << chain;
  const std::string two = run_command({"plan", "four_bar:2", "--json", "--threads", "1"}).json()["reason"];
  EXPECT_TRUE(std::regex_search(two, std::regex("; all levels together would take [0-9.]+ times as long$"))) << two;
}

TEST(Plan, NamesAnUnwritableFile) {
  const Scratch scratch;
  const std::string file = scratch.file("no_such_folder/stewart.plan");
  const Outcome o = run_command({"plan", "stewart", "--save", file});
  EXPECT_EQ(o.status, 3);
  EXPECT_EQ(o.out, "");
  EXPECT_NE(o.err.find(file), std::string::npos) << o.err;
  EXPECT_EQ(run_command({"plan", "stewart", "--save", "/dev/full"}).status, 3);
  EXPECT_EQ(run_command({"plan", "stewart", "--save", ""}).status, 2);
}

}  // namespace
}  // namespace assur
