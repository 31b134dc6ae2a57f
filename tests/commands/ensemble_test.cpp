// The options --ensemble and --mode of `assur run`.
#include "assur/ensemble.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "assur/simulator.hpp"
#include "commands/command.hpp"
#include "output/format.hpp"

namespace assur {
namespace {

// The crank turns until coupler and rocker are in line, |B - D| = coupler + 1. This happens at t = 1.31... for a
// coupler of 1, and after t = 2 for couplers of 1.8 or more. Couplers of 2 or more cannot be assembled.
const char* const kFold = R"({
  "assur": 1, "name": "fold", "dimension": 2, "parameters": {"coupler": 1},
  "points": {"A": {"at": [0, 0], "fixed": true}, "D": {"at": [2, 0], "fixed": true},
             "B": {"at": [1, 0]}, "C": {"at": [1.5, 0.8]}},
  "constraints": {"coupler_bar": {"distance": ["B", "C"], "value": "=coupler"},
                  "rocker": {"distance": ["D", "C"], "value": 1}},
  "drivers": {"motor": {"angle": ["A", "B"], "law": {"polynomial": [0, 1]}}},
  "outputs": ["C"],
  "time": {"start": 0, "end": 2, "step": 0.01}
})";

struct Row {
  std::vector<double> values;
};

std::vector<Row> rows_of(const std::string& csv) {
  std::istringstream stream(csv);
  std::vector<Row> rows;
  std::string line;
  std::getline(stream, line);
  while (std::getline(stream, line)) {
    Row& row = rows.emplace_back();
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) row.values.push_back(std::stod(field));
  }
  return rows;
}

class Ensembles : public testing::Test {
 protected:
  // Runs `assur run SCENE --ensemble FILE ...`, where FILE contains `variants`.
  Outcome run(const std::string& scene, const std::string& variants, std::vector<std::string> more = {},
              const Setting& setting = {}) const {
    more.insert(more.begin(), {"run", scene, "--ensemble", scratch_.file("variants.csv", variants)});
    return run_command(more, setting);
  }
  [[nodiscard]] std::string fold() const { return scratch_.file("fold.json", kFold); }

  Scratch scratch_;
};

TEST_F(Ensembles, CsvEqualsTheTrajectoryOfTheLibrary) {
  std::string variants = "omega\n";
  for (int i = 0; i < 10; ++i) variants += std::to_string(1 + 0.125 * i) + "\n";
  TimeGrid grid = sample("stewart").time();
  grid.end = grid.time(40);
  for (const std::string strategy : {"irreducible/lanes:4", "groups/eigen"}) {
    Ensemble ensemble(10, [&](std::size_t i) {
      const Scene scene = sample("stewart", {{"omega", 1 + 0.125 * static_cast<double>(i)}});
      return prepare(scene.with_outputs({"handle1", "O"}).with_time(grid), {.strategy = strategy});
    });
    std::ostringstream expected;
    write_csv(expected, ensemble.run());
    const Outcome outcome =
        run("stewart", variants,
            {"--quiet", "--csv", "-", "--steps", "40", "--outputs", "handle1,O", "--strategy", strategy});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    EXPECT_EQ(outcome.out, expected.str()) << strategy;
  }
}

// Errors of position, velocity and acceleration grow with up to the third power of the condition. The condition is
// below 8, because coupler and rocker stay 18 degrees away from one line. The factor of 4 allows for a few roundings.
TEST_F(Ensembles, MembersMoveAsInSingleRuns) {
  constexpr double kTolerance = 8 * 8 * 8 * 4 * std::numeric_limits<double>::epsilon();
  const std::string scene = fold();
  const std::vector<Row> all = rows_of(run(scene, "coupler\n1.8\n1.9\n1.85\n", {"--quiet", "--csv", "-"}).out);
  ASSERT_EQ(all.size(), 3u * 201u);
  const char* const couplers[] = {"1.8", "1.9", "1.85"};
  for (std::size_t member = 0; member < 3; ++member) {
    const std::string set = std::string("coupler=") + couplers[member];
    const std::vector<Row> own = rows_of(run_command({"run", scene, "--quiet", "--csv", "-", "--set", set}).out);
    ASSERT_EQ(own.size(), 201u);
    for (std::size_t k = 0; k < own.size(); ++k) {
      const std::vector<double>& row = all[member * 201 + k].values;
      ASSERT_EQ(row.size(), own[k].values.size() + 1);
      EXPECT_EQ(row[0], static_cast<double>(member + 1));
      EXPECT_EQ(row[1], own[k].values[0]);
      for (std::size_t i = 1; i < own[k].values.size(); ++i) {
        EXPECT_NEAR(row[i + 1], own[k].values[i], kTolerance * std::max(1.0, std::abs(own[k].values[i])));
      }
    }
  }
}

TEST_F(Ensembles, JsonHasTheFiguresOfTheRun) {
  const Outcome outcome = run("stewart", "omega\n1\n2\n3\n", {"--json", "--steps", "50"});
  ASSERT_EQ(outcome.status, 0) << outcome.out;
  EXPECT_EQ(outcome.err, "");
  const auto json = outcome.json();
  EXPECT_EQ(json["scene"], "stewart");
  EXPECT_EQ(json["mode"], "throughput");
  EXPECT_EQ(json["strategy"], "auto");
  EXPECT_EQ(json["status"], "ok");
  EXPECT_EQ(json["members"], 3);
  EXPECT_TRUE(json["failed"].empty());
  EXPECT_EQ(json["steps"], 150);
  EXPECT_EQ(json["reached"], 0.5);
  for (const char* key : {"median", "p99", "max"}) EXPECT_TRUE(json["step_seconds"][key].is_null());
  EXPECT_DOUBLE_EQ(json["step_seconds"]["mean"].get<double>() * 150, json["seconds"].get<double>());
  EXPECT_GT(json["prepare_seconds"], 0);
  for (const char* key : {"position", "velocity", "acceleration"}) {
    EXPECT_GT(json["error"][key], 0) << key;
    EXPECT_LE(json["error"][key], 1e-14) << key;
  }
  for (const auto& choice : json["plan"]) {
    EXPECT_EQ(parse_strategy(choice["strategy"].get<std::string>()).run.chunks, 1);
    EXPECT_GE(parse_strategy(choice["strategy"].get<std::string>()).solver.lanes, 2);
  }
}

TEST_F(Ensembles, NamesFailedMembersAndContinuesTheOthers) {
  const std::string scene = fold(), variants = "coupler\n1.9\n1\n3\n-1\n1.8\n";
  const std::string csv = scratch_.file("motion.csv");
  const Outcome outcome = run(scene, variants, {"--json", "--csv", csv});
  EXPECT_EQ(outcome.status, 1);
  const auto json = outcome.json();
  EXPECT_EQ(json["status"], "fold");
  EXPECT_EQ(json["members"], 5);
  ASSERT_EQ(json["failed"].size(), 3u);
  const auto stuck = json["failed"][0], apart = json["failed"][1], wrong = json["failed"][2];
  EXPECT_EQ(stuck["member"], 2);
  EXPECT_EQ(stuck["parameters"]["coupler"], 1);
  EXPECT_EQ(stuck["status"], "fold");
  EXPECT_GE(stuck["reached"], 1.31);
  EXPECT_LT(stuck["reached"], std::acos(0.25));
  EXPECT_EQ(stuck["why"].get<std::string>().rfind("t = 1.31", 0), 0u) << stuck;
  EXPECT_EQ(apart["member"], 3);
  EXPECT_TRUE(apart["status"].is_null());
  EXPECT_TRUE(apart["reached"].is_null());
  EXPECT_EQ(wrong["member"], 4);
  EXPECT_NE(wrong["why"].get<std::string>().find("/constraints/coupler_bar"), std::string::npos) << wrong;
  ASSERT_FALSE(json["events"].empty());
  EXPECT_EQ(json["events"][0]["member"], 2);
  EXPECT_EQ(json["events"][0]["kind"], "fold");

  std::vector<int> rows(6);
  for (const Row& row : rows_of(content(csv))) ++rows[static_cast<std::size_t>(row.values[0])];
  EXPECT_EQ(rows, (std::vector<int>{0, 201, 132, 0, 0, 201}));
  EXPECT_EQ(json["steps"], 200 + 131 + 200);

  const Outcome page = run(scene, variants);
  EXPECT_EQ(page.status, 1);
  EXPECT_EQ(page.err.rfind("error: 3 of 5 members failed; the first: member 2 (coupler = 1): t = 1.31", 0), 0u)
      << page.err;
  EXPECT_NE(page.out.find("\n  members         2 done, 3 failed; 1 continued alone\n"), std::string::npos) << page.out;
  EXPECT_NE(page.out.find("member 3 (coupler = 3): "), std::string::npos) << page.out;
  EXPECT_EQ(page.lines().back(), "  status          3 of 5 members failed");
}

TEST_F(Ensembles, ReportsMembersBelowTheRequiredAccuracy) {
  const std::string variants = "delta\n1e-3\n1e-12\n1e-2\n";
  const auto json =
      run("almost_parallelogram", variants, {"--json", "--strategy", "global/eigen:4+predict=taylor:2"}).json();
  EXPECT_EQ(json["status"], "inaccurate");
  ASSERT_EQ(json["failed"].size(), 1u);
  EXPECT_EQ(json["failed"][0]["member"], 2);
  EXPECT_EQ(json["failed"][0]["status"], "inaccurate");
  EXPECT_GT(json["error"]["estimated_acceleration"], 1e-6);
  const Outcome page = run("almost_parallelogram", variants, {"--strategy", "global/eigen:4+predict=taylor:2"});
  EXPECT_EQ(page.status, 1);
  EXPECT_EQ(page.lines().back(), "  status          1 of 3 members inaccurate");
}

TEST_F(Ensembles, AnErrorOfAllMembersIsReportedAsWithoutAnEnsemble) {
  const std::string scene = fold();
  const Outcome set = run_command({"run", scene, "--set", "couple=1"});
  const Outcome column = run(scene, "couple\n1\n2\n");
  EXPECT_EQ(column.status, 2);
  EXPECT_EQ(column.out, "");
  EXPECT_EQ(column.err, set.err);
  EXPECT_NE(column.err.find("did you mean 'coupler'?"), std::string::npos) << column.err;

  const Outcome apart = run(scene, "coupler\n3\n4\n");
  EXPECT_EQ(apart.status, 1);
  EXPECT_EQ(apart.err, run_command({"run", scene, "--set", "coupler=3"}).err);
}

TEST_F(Ensembles, RefusesInvalidFiles) {
  const Outcome wrong = run("stewart", "omega\n1\nfast\n");
  EXPECT_EQ(wrong.status, 2);
  EXPECT_EQ(wrong.err,
            "error: " + scratch_.file("variants.csv") + ": line 3, column 1 (omega): 'fast' is not a finite number\n");
  const Outcome none = run_command({"run", "stewart", "--ensemble", scratch_.file("none.csv")});
  EXPECT_EQ(none.status, 3);
  EXPECT_EQ(none.err, "error: " + scratch_.file("none.csv") +
                          ": the file of variants cannot be read: no such file or directory\n");
}

TEST_F(Ensembles, SetAppliesToEveryMember) {
  const Outcome set = run("stewart", "omega\n1\n2\n", {"--set", "legs=4", "--json", "--steps", "2"});
  ASSERT_EQ(set.status, 0) << set.out;
  EXPECT_EQ(set.json()["plan"].back()["groups"], 4);
  const Outcome twice = run("stewart", "omega\n1\n2\n", {"--set", "omega=1"});
  EXPECT_EQ(twice.status, 2);
  EXPECT_EQ(twice.err,
            "error: --set: \"omega\" is also a column of " + scratch_.file("variants.csv") + "; give it only once\n");
}

TEST_F(Ensembles, RefusesMembersWithDifferentTimeGrids) {
  const auto json = run("four_bar", "steps\n100\n200\n", {"--json"}).json();
  EXPECT_EQ(json["failed"][0]["member"], 2);
  EXPECT_EQ(json["failed"][0]["why"], "its time grid differs from that of the first member");
  EXPECT_EQ(run("four_bar", "steps\n100\n200\n", {"--steps", "50"}).status, 0);
}

TEST_F(Ensembles, ResultsAreBitwiseEqualForAllThreads) {
  std::string variants = "omega\n";
  for (int i = 0; i < 20; ++i) variants += std::to_string(1 + 0.125 * i) + "\n";
  const auto csv = [&](const std::string& strategy) {
    const Outcome outcome =
        run("stewart", variants, {"--quiet", "--csv", "-", "--steps", "30", "--strategy", strategy});
    if (outcome.status == 3) return std::string();
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.out;
  };
  const std::string two = csv("irreducible/lanes:4 2x1");
  if (two.empty()) GTEST_SKIP() << "one core";
  EXPECT_TRUE(two == csv("irreducible/lanes:4"));
}

TEST_F(Ensembles, PinnedThreadsGiveTheSameResults) {
  const std::vector<std::string> options = {"--quiet", "--csv", "-", "--strategy", "groups/klu:2 2x1"};
  std::vector<std::string> pinned = options;
  pinned.push_back("--pin");
  const std::string variants = "omega\n1\n2\n3\n4\n";
  const Outcome outcome = run("stewart", variants, pinned);
  if (outcome.status == 3) GTEST_SKIP() << outcome.err;
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(outcome.out == run("stewart", variants, options).out);
}

TEST_F(Ensembles, RefusesContradictoryOptions) {
  struct Case {
    std::vector<std::string> options;
    std::string message;
  };
  const Case cases[] = {
      {{"--mode", "latency"},
       "--mode: latency runs one mechanism step by step, but --ensemble runs its members side by side; remove one of "
       "them"},
      {{"--strategy", "groups/klu+chunks=4"},
       "--ensemble: its members use the lanes and threads; remove +chunks= from the strategy"},
      {{"--reference"}, "--reference: it compares a single mechanism; run one member with --set"},
      {{"--certify"}, "--certify: it certifies a single mechanism; run one member with --set"},
  };
  for (const Case& c : cases) {
    const Outcome outcome = run("stewart", "omega\n1\n", c.options);
    EXPECT_EQ(outcome.status, 2);
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(outcome.err, "error: " + c.message + "\n");
  }
}

TEST_F(Ensembles, AnInterruptKeepsFinishedRows) {
  const std::string csv = scratch_.file("motion.csv");
  const Outcome outcome =
      run("four_bar:400", "omega\n6\n6.1\n", {"--steps", "1000000", "--outputs", "B400.position", "--csv", csv},
          {{}, {}, " of 2,000,000 steps"});
  EXPECT_EQ(outcome.status, 130);
  EXPECT_NE(outcome.out.find("\n  status          interrupted after "), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find(" interrupted"), std::string::npos) << outcome.out;
  const std::size_t rows = rows_of(content(csv)).size();
  EXPECT_GT(rows, 2u);
  EXPECT_LT(rows, 2000002u);
}

TEST_F(Ensembles, PageFitsEightyColumns) {
  std::string variants = "coupler\n";
  for (int i = 0; i < 30; ++i) variants += std::to_string(0.9 + 0.03 * i) + "\n";
  for (const Outcome& outcome : {run(fold(), variants), run("stewart", "omega\n1\n2\n", {"--steps", "10"})}) {
    for (const std::string& line : outcome.lines()) EXPECT_LE(output::display_width(line), 80u) << line;
    for (const char* label : {"members", "prepared", "time", "step", "Newton", "error", "left out", "status"}) {
      EXPECT_NE(outcome.out.find(std::string("\n  ") + label + " "), std::string::npos) << label << "\n" << outcome.out;
    }
  }
}

// The two motions differ by at most their true errors, relative to the largest output.
TEST(Mode, ThroughputGivesTheSameMotion) {
  std::vector<std::vector<Row>> motions;
  double allowed = 0;
  for (const std::string mode : {"latency", "throughput"}) {
    const Scratch scratch;
    const std::string csv = scratch.file("motion.csv");
    const Outcome outcome = run_command({"run", "stewart", "--json", "--reference", "--mode", mode, "--csv", csv});
    if (outcome.status == 3) GTEST_SKIP() << "built without quad arithmetic";
    const auto error = outcome.json()["error"];
    allowed += std::max({error["forward_position"].get<double>(), error["forward_velocity"].get<double>(),
                         error["forward_acceleration"].get<double>()});
    motions.push_back(rows_of(content(csv)));
  }
  EXPECT_LE(allowed, 1e-12);
  double largest = 0;
  for (const Row& row : motions[0]) {
    for (std::size_t i = 1; i < row.values.size(); ++i) largest = std::max(largest, std::abs(row.values[i]));
  }
  ASSERT_EQ(motions[0].size(), motions[1].size());
  for (std::size_t k = 0; k < motions[0].size(); ++k) {
    const std::vector<double>&a = motions[0][k].values, &b = motions[1][k].values;
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], allowed * largest) << k << " " << i;
  }
}

TEST(Mode, ThroughputRunsChunksAndReportsTheMean) {
  const auto json = run_command({"run", "stewart", "--json", "--mode", "throughput"}).json();
  EXPECT_EQ(json["mode"], "throughput");
  EXPECT_EQ(json["steps"], 1000);
  for (const std::string text : json["fallbacks"]) EXPECT_EQ(text.find("chunk"), std::string::npos) << text;
  EXPECT_FALSE(json.contains("members"));
  for (const char* key : {"median", "p99", "max"}) EXPECT_TRUE(json["step_seconds"][key].is_null());
  EXPECT_DOUBLE_EQ(json["step_seconds"]["mean"].get<double>() * 1000, json["seconds"].get<double>());
  for (const auto& choice : json["plan"]) {
    EXPECT_GT(parse_strategy(choice["strategy"].get<std::string>()).run.chunks, 1);
  }
}

TEST(Mode, ChunksInAStrategyMeanThroughput) {
  const auto json = run_command({"run", "stewart", "--json", "--strategy", "groups/eigen+chunks=3"}).json();
  EXPECT_EQ(json["mode"], "throughput");
  EXPECT_EQ(parse_strategy(json["plan"][0]["strategy"].get<std::string>()).run.chunks, 3);
  EXPECT_FALSE(json["step_seconds"]["mean"].is_null());
  const Outcome outcome = run_command({"run", "stewart", "--strategy", "groups/eigen+chunks=3", "--mode", "latency"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.err,
            "error: --mode: latency runs one mechanism step by step, but +chunks= runs parts of the time grid side by "
            "side; remove one of them\n");
}

TEST(Mode, LatencyIsTheDefault) {
  const auto json = run_command({"run", "stewart", "--json"}).json();
  EXPECT_EQ(json["mode"], "latency");
  EXPECT_FALSE(json["step_seconds"]["median"].is_null());
  const auto named = run_command({"run", "stewart", "--json", "--mode", "latency"}).json();
  EXPECT_EQ(named["plan"], json["plan"]);
}

}  // namespace
}  // namespace assur
