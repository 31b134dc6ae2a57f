#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "assur/simulator.hpp"
#include "commands/command.hpp"
#include "commands/fold.hpp"
#include "output/format.hpp"

namespace assur {
namespace {

std::string csv_of(const Scene& scene) {
  Simulator simulator(prepare(scene));
  std::ostringstream out;
  write_csv(out, simulator.run());
  return out.str();
}

std::vector<double> times_of(const std::string& csv) {
  std::istringstream stream(csv);
  std::vector<double> times;
  std::string line;
  std::getline(stream, line);
  while (std::getline(stream, line)) times.push_back(std::stod(line));
  return times;
}

TEST(Run, JsonHasTheFiguresOfTheRun) {
  const Outcome outcome = run_command({"run", "stewart", "--json", "--quiet", "--strategy", "groups/eigen"});
  ASSERT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.err, "");
  const auto json = outcome.json();
  EXPECT_EQ(json["scene"], "stewart");
  EXPECT_EQ(json["strategy"], "groups/eigen");
  EXPECT_EQ(json["status"], "ok");
  EXPECT_EQ(json["steps"], 1000);
  EXPECT_EQ(json["reached"], 10.0);
  ASSERT_EQ(json["plan"].size(), 2u);
  EXPECT_EQ(json["plan"][0]["n"], 12);
  EXPECT_EQ(json["plan"][1]["n"], 15);
  EXPECT_EQ(json["plan"][1]["groups"], 6);
  EXPECT_EQ(json["plan"][1]["reason"], "forced");
  EXPECT_EQ(parse_strategy(json["plan"][1]["strategy"].get<std::string>()).solver.backend, "eigen");
  EXPECT_GE(json["factorizations"], 7 * 1000);
  EXPECT_LE(json["newton_iterations"]["mean"], json["newton_iterations"]["max"]);
  EXPECT_GT(json["newton_iterations"]["mean"], 0);
  for (const char* key : {"position", "velocity", "acceleration"}) {
    EXPECT_GT(json["error"][key], 0) << key;
    EXPECT_LE(json["error"][key], 1e-14) << key;
    EXPECT_TRUE(json["error"][std::string("forward_") + key].is_null());
  }
  EXPECT_TRUE(json["error"]["certified_radius"].is_null());
  EXPECT_TRUE(json["certificate"].is_null());
  EXPECT_TRUE(json["left_out"].contains("static_groups"));
  EXPECT_TRUE(json["events"].empty());
  EXPECT_TRUE(json["fallbacks"].empty());
}

TEST(Run, StepTimesAddUpToTheRun) {
  const auto json = run_command({"run", "stewart", "--json"}).json();
  const auto step = json["step_seconds"];
  const double median = step["median"], p99 = step["p99"], max = step["max"];
  EXPECT_GT(median, 0);
  EXPECT_LE(median, p99);
  EXPECT_LE(p99, max);
  // Half of the steps take at least the median.
  EXPECT_LE(500 * median, json["seconds"]);
  EXPECT_EQ(step["block"] == 1, median >= 1e-6);
}

TEST(Run, CsvEqualsTheTrajectoryOfTheLibrary) {
  const Scratch scratch;
  const std::string expected = csv_of(sample("andrews"));
  const Outcome to_file = run_command({"run", "andrews", "--csv", scratch.file("motion.csv")});
  EXPECT_EQ(to_file.status, 0);
  EXPECT_EQ(content(scratch.file("motion.csv")), expected);

  const Outcome to_output = run_command({"run", "andrews", "--csv", "-"});
  EXPECT_EQ(to_output.status, 0);
  EXPECT_EQ(to_output.out, expected);
  EXPECT_EQ(to_output.err.rfind("andrews: 72 steps", 0), 0u) << to_output.err;

  const Outcome quiet = run_command({"run", "andrews", "--csv", "-", "--quiet"});
  EXPECT_EQ(quiet.out, expected);
  EXPECT_EQ(quiet.err, "");
}

TEST(Run, OptionsSetTheTimeGrid) {
  const auto times = [](std::vector<std::string> options) {
    options.insert(options.begin(), {"run", "four_bar", "--quiet", "--csv", "-"});
    const Outcome outcome = run_command(options);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return times_of(outcome.out);
  };
  const TimeGrid scene = sample("four_bar").time();
  EXPECT_EQ(times({"--steps", "0"}), std::vector<double>{scene.start});
  EXPECT_EQ(times({"--steps", "2"}), (std::vector<double>{scene.start, scene.time(1), scene.time(2)}));
  EXPECT_EQ(times({"--start", "-0.25", "--dt", "0.125", "--steps", "3"}),
            (std::vector<double>{-0.25, -0.125, 0, 0.125}));
  const auto halved = times({"--dt", "0.0005"});
  ASSERT_EQ(halved.size(), static_cast<std::size_t>(2 * scene.steps() + 1));
  EXPECT_EQ(halved[3], scene.start + 3 * 0.0005);
}

TEST(Run, RefusesAGridWithoutWholeNumberOfSteps) {
  struct Case {
    std::vector<std::string> options;
    std::string message;
  };
  const std::string wanted = " s, which is not a whole number >= 1; give the number with --steps\n";
  const Case cases[] = {
      {{"--dt", "0.3"}, "--dt: from 0 s to the scene's end at 10 s there are 33.3333 steps of 0.3" + wanted},
      {{"--dt", "20"}, "--dt: from 0 s to the scene's end at 10 s there are 0.5 steps of 20" + wanted},
      // A time grid of 1e-10 steps is an error, not a rounded step.
      {{"--dt", "1e11"}, "--dt: from 0 s to the scene's end at 10 s there are 1e-10 steps of 1e+11" + wanted},
      {{"--start", "10"}, "--start: from 10 s to the scene's end at 10 s there are 0 steps of 0.01" + wanted},
  };
  for (const Case& c : cases) {
    std::vector<std::string> arguments = {"run", "stewart"};
    arguments.insert(arguments.end(), c.options.begin(), c.options.end());
    const Outcome outcome = run_command(arguments);
    EXPECT_EQ(outcome.status, 2);
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(outcome.err, "error: " + c.message);
  }
}

TEST(Run, OptionsGiveTheTimesOfASceneWithoutTimes) {
  const Scratch scratch;
  std::string text = kFold;
  const std::size_t time = text.find("\"time\"");
  ASSERT_NE(time, std::string::npos);
  text.erase(text.rfind(',', time), text.find('}', time) + 1 - text.rfind(',', time));
  const std::string scene = scratch.file("no_time.json", text);
  const Outcome outcome = run_command({"run", scene, "--quiet", "--csv", "-", "--dt", "0.5", "--steps", "2"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(times_of(outcome.out), (std::vector<double>{0, 0.5, 1}));

  const Outcome no_step = run_command({"run", scene, "--steps", "3"});
  EXPECT_EQ(no_step.status, 2);
  EXPECT_EQ(no_step.err, "error: --dt: the scene has no time step; give one\n");
  const Outcome no_end = run_command({"run", scene, "--dt", "0.5"});
  EXPECT_EQ(no_end.status, 2);
  EXPECT_EQ(no_end.err.rfind("error: --dt: from 0 s to the scene's end at 0 s there are 0 steps", 0), 0u) << no_end.err;
}

TEST(Run, ARepeatedOutputIsOneColumn) {
  const auto header = [](const std::string& outputs) {
    return run_command({"run", "slider_crank", "--quiet", "--csv", "-", "--steps", "1", "--outputs", outputs})
        .lines()
        .at(0);
  };
  EXPECT_EQ(header("C.velocity,B.position,C.velocity"), "t,C.vx,C.vy,B.x,B.y");
}

TEST(Run, AppliesOutputsAndParameters) {
  const Outcome outcome = run_command({"run", "stewart", "--quiet", "--csv", "-", "--steps", "5", "--outputs",
                                       "handle1.value,O.position", "--set", "omega=2"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  TimeGrid grid = sample("stewart").time();
  grid.end = grid.time(5);
  const Scene scene = sample("stewart", {{"omega", 2}}).with_outputs({"handle1.value", "O.position"}).with_time(grid);
  EXPECT_EQ(outcome.out, csv_of(scene));
  EXPECT_EQ(outcome.lines()[0], "t,handle1,O.x,O.y,O.z");
}

TEST(Run, DerivativesThatAreNotComputedHaveNoError) {
  const auto json = run_command({"run", "stewart", "--json", "--steps", "20", "--outputs", "handle1.value"}).json();
  EXPECT_TRUE(json["error"]["acceleration"].is_null());
  EXPECT_LE(json["error"]["position"], 1e-14);
  EXPECT_EQ(json["left_out"]["groups"].empty(), false);
}

// Unmeasured figures of a run, of chunks, and of an ensemble are null, not 0.
TEST(Run, JsonHasNullForUnmeasuredFigures) {
  const std::string file = testing::TempDir() + "unknown_figures.csv";
  std::ofstream(file) << "omega\n1\n2\n";
  const std::vector<std::string> call = {"run", "stewart", "--json", "--steps", "20", "--outputs", "handle1.value"};
  for (const auto& more : {std::vector<std::string>{"--strategy", "groups/eigen+predict=past:3"},
                           {"--strategy", "groups/eigen:2+predict=past:3+chunks=2"},
                           {"--strategy", "groups/eigen:2+predict=past:3", "--ensemble", file}}) {
    std::vector<std::string> all = call;
    all.insert(all.end(), more.begin(), more.end());
    const Outcome outcome = run_command(all);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const auto error = outcome.json()["error"];
    EXPECT_LE(error["position"], 1e-14);
    EXPECT_LE(error["estimated_position"], 1e-10);
    for (const char* key : {"velocity", "acceleration", "estimated_velocity", "estimated_acceleration"}) {
      EXPECT_TRUE(error[key].is_null()) << key << " " << more[1];
    }
  }
}

TEST(Run, FixesIterationsBeyondTheFirstLevel) {
  const auto json = run_command({"run", "stewart", "--json", "--strategy", "groups/eigen", "--iterations", "3"}).json();
  EXPECT_EQ(json["status"], "ok");
  EXPECT_EQ(json["newton_iterations"]["max"], 3);
}

TEST(Run, ReferenceGivesTheForwardError) {
  const Outcome outcome = run_command({"run", "andrews", "--json", "--reference"});
  if (outcome.status == 3) GTEST_SKIP() << "built without quad arithmetic";
  ASSERT_EQ(outcome.status, 0) << outcome.out;
  const auto error = outcome.json()["error"];
  for (const char* key : {"forward_position", "forward_velocity", "forward_acceleration"}) {
    EXPECT_GT(error[key], 0) << key;
    EXPECT_LE(error[key], 1e-11) << key;
  }
}

TEST(Run, CertifyProvesThePostures) {
  const std::vector<std::string> call = {"run", "stewart", "--certify", "--steps", "20", "--quiet"};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = call;
    all.insert(all.end(), more.begin(), more.end());
    return run_command(all);
  };
  const Outcome outcome = with({"--json", "--strategy", "groups/eigen"});
  if (outcome.status == 3) GTEST_SKIP() << "built without quad arithmetic";
  ASSERT_EQ(outcome.status, 0) << outcome.out;
  const auto json = outcome.json();
  const double radius = json["error"]["certified_radius"];
  EXPECT_GT(radius, 0);
  EXPECT_LE(radius, 1e-13);  // as the forward error of this platform
  EXPECT_EQ(json["certificate"]["radius"], radius);
  EXPECT_EQ(json["certificate"]["why_not"], "");
  EXPECT_GT(json["certificate"]["uniqueness"], 1e-3);
  EXPECT_NE(with({}).out.find("certified"), std::string::npos);

  const auto chunks = with({"--json", "--mode", "throughput", "--strategy", "groups/eigen+chunks=2"}).json();
  EXPECT_TRUE(chunks["error"]["certified_radius"].is_null());
  EXPECT_NE(chunks["certificate"]["why_not"], "");
  EXPECT_NE(with({"--mode", "throughput", "--strategy", "groups/eigen+chunks=2"}).out.find("certified       no, "),
            std::string::npos);
}

TEST(Run, AFailureKeepsRowsAndNamesTheTime) {
  const Scratch scratch;
  const std::string scene = scratch.file("fold.json", kFold);
  const Outcome page = run_command({"run", scene, "--csv", scratch.file("motion.csv")});
  EXPECT_EQ(page.status, 1);
  EXPECT_EQ(page.err.rfind("error: t = 1.31", 0), 0u) << page.err;
  EXPECT_NE(page.err.find("group C: the mechanism cannot move further (fold)\n"), std::string::npos) << page.err;
  const auto times = times_of(content(scratch.file("motion.csv")));
  EXPECT_EQ(times.back(), 131 * 0.01);
  EXPECT_EQ(times.size(), 132u);

  const Outcome outcome = run_command({"run", scene, "--json"});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.err, "");
  const auto json = outcome.json();
  EXPECT_EQ(json["status"], "fold");
  EXPECT_EQ(json["steps"], 131);
  ASSERT_FALSE(json["events"].empty());
  const auto event = json["events"].back();
  EXPECT_EQ(event["kind"], "fold");
  EXPECT_EQ(event["group"], "C");
  EXPECT_GE(event["time"], 1.31);
  EXPECT_LE(event["time"], kFoldTime);
  EXPECT_LE(event["time"], event["until"]);
}

TEST(Run, AMechanismThatCannotBeAssembledIsANumericalFailure) {
  const Outcome outcome = run_command({"run", "andrews", "--set", "xb=0.03635"});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(outcome.err.rfind("error: group ", 0), 0u) << outcome.err;
  const Outcome json = run_command({"run", "andrews", "--set", "xb=0.03635", "--json"});
  EXPECT_EQ(json.status, 1);
  EXPECT_EQ(json.json()["error"]["kind"], "numerical");
}

TEST(Run, InspectAndRunShowNotesOfTheScene) {
  const Scratch scratch;
  std::string text = kFold;
  text.replace(text.find("\"drivers\""), 0, "\"vectors\": {\"e\": {\"at\": [3, 4], \"fixed\": true}},\n  ");
  const std::string scene = scratch.file("note.json", text);
  for (const std::string command : {"inspect", "run"}) {
    std::vector<std::string> arguments = {command, scene};
    if (command == "run") arguments.insert(arguments.end(), {"--steps", "2"});
    const Outcome page = run_command(arguments);
    EXPECT_EQ(page.status, 0) << page.err;
    EXPECT_NE(page.out.find("\n  notes           /vectors/e/at: the vector has length 5"), std::string::npos)
        << page.out;
    arguments.push_back("--json");
    EXPECT_EQ(run_command(arguments).json()["notes"][0]["where"], "/vectors/e/at");
  }
}

TEST(Run, ExplainsWhyABackendCannotRun) {
  EXPECT_EQ(run_command({"run", "hexapod:drive=legs"}).status, 2);
  EXPECT_EQ(run_command({"run", "stewart", "--strategy", "groups/nonesuch"}).status, 2);
  EXPECT_EQ(run_command({"run", "stewart", "--strategy", "quickly"}).status, 2);
  const Outcome threads = run_command({"run", "stewart", "--strategy", "groups/eigen 1x2"});
  EXPECT_EQ(threads.status, 3);
  EXPECT_EQ(threads.err.rfind("error: ", 0), 0u);
}

TEST(Run, AnUnwritableCsvIsAnEnvironmentError) {
  const Scratch scratch;
  const std::string nowhere = scratch.file("no/such/folder.csv");
  const Outcome outcome = run_command({"run", "andrews", "--csv", nowhere});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(outcome.err, "error: --csv: cannot write " + nowhere + ": No such file or directory\n");
  if (!std::filesystem::exists("/dev/full")) return;
  const Outcome full = run_command({"run", "andrews", "--csv", "/dev/full"});
  EXPECT_EQ(full.status, 3);
  EXPECT_EQ(full.err, "error: --csv: cannot write /dev/full: No space left on device\n");
  const Outcome piped = run_command({"run", "andrews", "--csv", "-"}, {{}, "/dev/full", {}});
  EXPECT_EQ(piped.status, 3);
  EXPECT_EQ(piped.err, "error: --csv: cannot write to standard output: No space left on device\n");
}

TEST(Run, AnInterruptKeepsFinishedRows) {
  const Scratch scratch;
  const std::string csv = scratch.file("motion.csv");
  const std::vector<std::string> arguments = {"run",       "four_bar:400",  "--steps", "1000000",
                                              "--outputs", "B400.position", "--csv",   csv};
  const Outcome outcome = run_command(arguments, {{}, {}, " of 1,000,000 steps"});
  EXPECT_EQ(outcome.status, 130);
  EXPECT_NE(outcome.out.find("\n  status          interrupted after "), std::string::npos) << outcome.out;
  const std::size_t rows = times_of(content(csv)).size();
  EXPECT_GT(rows, 1u);
  EXPECT_LT(rows, 1000001u);
  EXPECT_EQ(content(csv).back(), '\n');
}

TEST(Run, PageFitsEightyColumnsAndNamesEverything) {
  for (const std::string scene : {"stewart", "four_bar:30", "gough", "andrews", "rings:legs=6,n=120,terminal=24"}) {
    const Outcome outcome = run_command({"run", scene, "--steps", "10"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    for (const std::string& line : outcome.lines()) EXPECT_LE(output::display_width(line), 80u) << line;
    for (const char* label : {"time", "step", "Newton", "factorizations", "error", "left out", "status"}) {
      EXPECT_NE(outcome.out.find(std::string("\n  ") + label + " "), std::string::npos) << label << "\n" << outcome.out;
    }
    EXPECT_EQ(outcome.lines().back(), "  status          done");
  }
}

// The tables of the scene are protected under every name of their files; so are the tables of ensemble members.
TEST(Run, OutputsDoNotOverwriteTablesOfTheScene) {
  const Scratch scratch;
  const std::string table = "0,0\n1,1\n2,4\n", variants = "AP\n1\n";
  const std::string csv = scratch.file("swing.csv", table), speeds = scratch.file("speeds.csv", variants);
  const std::string link = scratch.file("link.csv");
  std::filesystem::create_symlink(csv, link);
  const std::string scene = scratch.file("swing.json", R"({"assur": 1, "name": "swing", "dimension": 2,
    "parameters": {"AP": 1}, "points": {"A": {"at": [0, 0], "fixed": true}, "P": {"at": ["=AP", 0]}},
    "constraints": {"arm": {"distance": ["A", "P"], "value": "=AP"}},
    "drivers": {"motor": {"angle": ["A", "P"], "law": {"table": "swing.csv"}}},
    "time": {"start": 0, "end": 2, "step": 0.5}})");
  ASSERT_EQ(run_command({"run", scene, "--quiet"}).status, 0) << run_command({"run", scene}).err;
  const auto refused = [](const std::string& option, const std::string& file) {
    return "error: " + option + ": " + file + " is an input and would be overwritten; name another file\n";
  };
  for (const std::string& file : {csv, link}) {
    for (const std::string option : {"--csv", "--errors", "--animate", "--picture", "--plot"}) {
      EXPECT_EQ(run_command({"run", scene, option, file}).err, refused(option, file));
    }
    EXPECT_EQ(run_command({"run", scene, "--ensemble", speeds, "--csv", file}).err, refused("--csv", file));
    EXPECT_EQ(run_command({"plan", scene, "--save", file}).err, refused("--save", file));
    EXPECT_EQ(run_command({"compare", scene, "--html", file}).err, refused("--html", file));
    EXPECT_EQ(run_command({"tune", "--scene", scene, "--budget", "1", "--csv", file}).err, refused("--csv", file));
  }
  EXPECT_EQ(run_command({"tune", "--scene", scene, "--budget", "1", "--csv", scene}).err, refused("--csv", scene));
  EXPECT_EQ(content(csv), table);
  EXPECT_EQ(content(speeds), variants);
}

TEST(Run, OutputsDoNotOverwriteInputs) {
  const Scratch scratch;
  const std::string scene = scratch.file("fold.json", kFold), speeds = scratch.file("speeds.csv", "a\n1\n");
  for (const std::string option : {"--csv", "--errors", "--animate", "--picture", "--plot"}) {
    const Outcome o = run_command({"run", scene, option, scene});
    EXPECT_EQ(o.status, 2);
    EXPECT_EQ(o.err, "error: " + option + ": " + scene + " is an input and would be overwritten; name another file\n");
    EXPECT_EQ(content(scene), kFold);
  }
  const Outcome variants = run_command({"run", scene, "--ensemble", speeds, "--csv", speeds});
  EXPECT_EQ(variants.status, 2);
  EXPECT_EQ(content(speeds), "a\n1\n");
  const Outcome plan = run_command({"plan", scene, "--save", scene});
  EXPECT_EQ(plan.status, 2);
  const Outcome page = run_command({"compare", scene, "--html", scene});
  EXPECT_EQ(page.status, 2);
  EXPECT_EQ(content(scene), kFold);
  const std::string database = scratch.file("tuning.db", "of samples");
  EXPECT_EQ(run_command({"run", scene, "--db", database, "--csv", database}).err,
            "error: --csv: " + database + " is an input and would be overwritten; name another file\n");
  EXPECT_EQ(content(database), "of samples");
  const std::string peers = scratch.file("report.csv", "of others");
  const std::string folder = std::filesystem::path(peers).parent_path();
  EXPECT_EQ(run_command({"report", "--quick", "--peers", peers, "--out", folder}).err,
            "error: --out: " + peers + " is an input and would be overwritten; name another file\n");
  EXPECT_EQ(content(peers), "of others");
  const std::string both = scratch.file("both");
  EXPECT_EQ(run_command({"run", scene, "--csv", both, "--plot", both}).err,
            "error: --plot: --csv also writes " + both + "; name another file\n");
}

// A row lies where the branches of a parallelogram cross.
TEST(Run, ExplainsHowToAvoidARowOnAChangePoint) {
  const Scratch scratch;
  const std::string scene = scratch.file("parallelogram.json", R"({"assur": 1, "dimension": 2,
      "points": {"A": {"at": [0, 0], "fixed": true}, "D": {"at": [2, 0], "fixed": true}, "B": {"at": [0, 1]},
                 "C": {"at": [2, 1]}},
      "constraints": {"coupler": {"distance": ["B", "C"]}, "rocker": {"distance": ["D", "C"]}},
      "drivers": {"motor": {"angle": ["A", "B"], "law": {"polynomial": [1.5707963267948966, 6.283185307179586]}}},
      "time": {"start": 0, "end": 1, "step": 0.05}})");
  const Outcome o = run_command({"run", scene, "--quiet"});
  if (o.status == 0) GTEST_SKIP() << "the row is passed here";
  EXPECT_NE(o.err.find("it could not be decided which branch continues the motion; if a row lies at or very near a "
                       "posture in which branches cross, choose another step or start time (branch_unknown)"),
            std::string::npos)
      << o.err;
}

}  // namespace
}  // namespace assur
