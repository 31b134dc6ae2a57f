// assur plan: what it saves, a program can run.
#include <gtest/gtest.h>

#include <fstream>

#include "assur/saved_plan.hpp"
#include "assur/simulator.hpp"
#include "commands/command.hpp"

namespace assur {
namespace {

TEST(Plan, WhatIsSavedRuns) {
  const Scratch scratch;
  const std::string file = scratch.file("stewart.plan");
  const Outcome o = run_command({"plan", "stewart", "--without", "klu", "--save", file, "--json"});
  ASSERT_EQ(o.status, 0) << o.err;
  std::ifstream in(file);
  const Prepared prepared = load_plan(in, {.table = backends()});
  EXPECT_EQ(prepared.name, "stewart");
  ASSERT_EQ(prepared.plan.choices.size(), o.json()["classes"].size());
  for (std::size_t c = 0; c < prepared.plan.choices.size(); ++c) {
    EXPECT_EQ(to_string(prepared.plan.choices[c].strategy), o.json()["classes"][c]["strategy"]);
  }
  Simulator simulator(prepared);
  EXPECT_EQ(simulator.run().rows(), 1001u);
  EXPECT_TRUE(simulator.report().status.ok());
}

TEST(Plan, OnlyTheDatabaseThatIsNamedCounts) {
  const Scratch scratch;
  const std::string missing = scratch.file("none.db");
  for (const char* command : {"plan", "run"}) {
    const Outcome o = run_command({command, "stewart", "--db", missing});
    EXPECT_EQ(o.status, 3) << command;
    EXPECT_NE(o.err.find(missing), std::string::npos) << o.err;
  }
}

TEST(Plan, AFileThatCannotBeWrittenIsNamed) {
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
