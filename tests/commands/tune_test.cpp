// The command `assur tune` with a budget of two seconds.
#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>
#include <set>
#include <string>

#include "commands/command.hpp"
#include "db/store.hpp"

namespace assur {
namespace {

class Tune : public testing::Test {
 protected:
  Tune() { setenv("ASSUR_DB", file().c_str(), 1); }
  ~Tune() override { setenv("ASSUR_DB", "", 1); }
  [[nodiscard]] std::string file() const { return scratch_.file("tuning.db"); }
  [[nodiscard]] db::Store store() const { return db::Store(file(), db::Access::read); }

  Scratch scratch_;
};

TEST_F(Tune, MeasuresTheMachineWithinItsBudget) {
  const Outcome outcome = run_tuning(2, {"--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const nlohmann::json result = outcome.json();
  for (const char* key : {"tuning_run", "grade", "samples", "seconds", "coverage", "held_out_regret"}) {
    EXPECT_TRUE(result.contains(key)) << key;
  }
  for (const char* key : {"median", "p95", "max"}) EXPECT_TRUE(result["held_out_regret"].contains(key)) << key;
  const std::set<std::string> grades = {"good", "fair", "noisy"};
  EXPECT_EQ(grades.count(result["grade"]), 1u);
  EXPECT_GE(result["coverage"], 0);
  EXPECT_LE(result["coverage"], 1);
  EXPECT_EQ(result["database"], file());

  const std::vector<db::Run> runs = store().runs();
  ASSERT_EQ(runs.size(), 1u);
  EXPECT_TRUE(runs[0].finished);
  EXPECT_EQ(runs[0].id, result["tuning_run"]);
  EXPECT_EQ(runs[0].samples, result["samples"]);
  EXPECT_EQ(result["grade"], runs[0].grade);
  const std::optional<std::string> learned = store().model(db::this_host(), "quick");
  ASSERT_TRUE(learned.has_value());
  EXPECT_EQ(nlohmann::json::parse(*learned)["winners"], result["winners"]);
}

TEST_F(Tune, MeasuresOnlyForTheScene) {
  setenv("ASSUR_DB", "", 1);
  const Outcome outcome = run_tuning(3, {"--scene", "four_bar", "--db", file()});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("Tuning run 1, quick: four_bar"), std::string::npos);
  std::set<std::string> kernels;
  for (const Sample& s : store().samples()) {
    kernels.insert(std::string(name(s.kernel)));
    EXPECT_EQ(s.shape.n, 2) << to_string(s.strategy);
  }
  kernels.erase("around");  // measured only if the machine is quiet enough
  EXPECT_EQ(kernels, (std::set<std::string>{"evaluate", "factor", "pack", "solve", "step"}));
}

TEST_F(Tune, ContinuesAnInterruptedRun) {
  // The first line of progress comes after a second, when some cells are stored.
  Setting setting;
  setting.interrupt_when_err = "of 60 seconds";
  const Outcome first = run_command({"tune", "--budget", "60", "--json"}, setting);
  EXPECT_EQ(first.status, 130);
  ASSERT_TRUE(first.json()["interrupted"]);
  ASSERT_EQ(store().runs().size(), 1u);
  EXPECT_FALSE(store().runs()[0].finished);
  const std::int64_t stored = store().runs()[0].samples;
  EXPECT_EQ(stored, first.json()["samples"]);
  ASSERT_GT(stored, 0);

  const Outcome second = run_tuning(3, {"--json"});
  EXPECT_EQ(second.status, 0) << second.err;
  EXPECT_EQ(second.json()["tuning_run"], first.json()["tuning_run"]);
  EXPECT_GT(second.json()["cells"]["of_interrupted_run"], 0);
  ASSERT_EQ(store().runs().size(), 1u);
  EXPECT_TRUE(store().runs()[0].finished);
  EXPECT_GE(store().runs()[0].samples, stored);
}

TEST_F(Tune, WritesSamplesAsCsv) {
  setenv("ASSUR_DB", "", 1);
  EXPECT_EQ(run_command({"tune", "--budget", "1"}).status, 3);  // neither a database nor a file
  const std::string csv = scratch_.file("samples.csv");
  const Outcome outcome = run_tuning(3, {"--scene", "four_bar", "--csv", csv, "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(outcome.json()["tuning_run"].is_null());
  EXPECT_TRUE(content(csv).starts_with("kernel,n,nnz,"));
  EXPECT_NE(content(csv).find("\npack,2,4,"), std::string::npos);
}

TEST_F(Tune, RefusesInvalidOptions) {
  EXPECT_EQ(run_command({"tune", "--profile", "hasty"}).err,
            "error: --profile: expects quick, standard or patient, not \"hasty\"\nSee assur tune --help.\n");
  EXPECT_EQ(run_command({"tune", "--budget", "0"}).status, 2);
  for (const char* scene : {"no such thing", "gough", "hexapod:drive=legs"}) {  // unknown, at rest, undetermined
    EXPECT_EQ(run_command({"tune", "--scene", scene}).status, 2) << scene;
  }
  EXPECT_EQ(run_command({"tune", "--csv", "/no/such/folder/samples.csv"}).status, 3);
}

TEST_F(Tune, StatusOfATrialShowsWhetherASolverRuns) {
  EXPECT_EQ(run_command({"tune", "--trial", "groups/eigen"}).status, 0);
  EXPECT_EQ(run_command({"tune", "--trial", "groups/no_such_solver"}).status, 2);
}

// The first call of this library never returns. Its trial is stopped, the solver is named, and all others are measured.
TEST_F(Tune, LeavesOutASolverThatHangs) {
  Setting setting;
  setting.before = [] { setenv("LD_LIBRARY_PATH", ASSUR_HSL_THAT_HANGS, 1); };
  const Outcome outcome = run_tuning(10, {"--scene", "four_bar", "--quiet", "--json"}, setting);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.json()["left_out"], nlohmann::json::parse(R"([{"backend": "ma27", "why_not": "does not end"}])"));
  std::set<std::string> measured;
  for (const Sample& s : store().samples()) measured.insert(s.strategy.solver.backend);
  EXPECT_GT(measured.size(), 1u);
  EXPECT_EQ(measured.count("ma27"), 0u);
}

// On every machine the budget is over before the first cell.
TEST_F(Tune, ReportsThatNothingWasMeasured) {
  const Outcome outcome = run_command({"tune", "--budget", "1e-3", "--scene", "four_bar", "--quiet"});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_EQ(outcome.err, "error: nothing was measured in 1.00 ms: the machine is busy or slow; increase --budget\n");
  EXPECT_NE(outcome.out.find("samples         0 of 0 cells in "), std::string::npos) << outcome.out;
  ASSERT_EQ(store().runs().size(), 1u);
  EXPECT_FALSE(store().runs()[0].finished);
}

}  // namespace
}  // namespace assur
