#include <gtest/gtest.h>

#include "commands/command.hpp"
#include "equations/system.hpp"
#include "numbers.hpp"
#include "output/format.hpp"
#include "source_dir.hpp"
#include "structure/grouped_system.hpp"

namespace assur {
namespace {

TEST(Inspect, StewartHasTheGroupsOfThePaper) {
  const Outcome outcome = run_command({"inspect", "stewart", "--json"});
  ASSERT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.err, "");
  const auto json = outcome.json();
  EXPECT_EQ(json["scene"], "stewart");
  EXPECT_EQ(json["dimension"], 3);
  EXPECT_EQ(json["unknowns"], 12 + 6 * 15);
  EXPECT_EQ(json["equations"], 12 + 6 * 15);
  EXPECT_EQ(json["derived"], 6 * (3 + 3));  // P1..P6 and t1..t6
  EXPECT_EQ(json["eliminated"], 0);
  EXPECT_EQ(json["mobility"], 6);
  EXPECT_EQ(json["undetermined"].size(), 0u);
  EXPECT_EQ(json["redundant"].size(), 0u);
  EXPECT_EQ(json["levels"], 2);
  EXPECT_EQ(json["classes"], 2);
  ASSERT_EQ(json["groups"].size(), 7u);
  for (const auto& group : json["groups"]) {
    const bool terminal = group["name"] == "SG_T";
    EXPECT_EQ(group["n"], terminal ? 12 : 15);
    EXPECT_EQ(group["of"], group["n"]);
    EXPECT_EQ(group["nnz"], terminal ? 39 : 48);
    EXPECT_GE(group["fill"], group["nnz"]);
    EXPECT_EQ(group["level"], terminal ? 0 : 1);
  }
  EXPECT_EQ(json["left_out"]["unknowns"], 0);
}

// The file has the scene with its options; nothing that was read is overwritten.
TEST(Inspect, WritesTheScene) {
  const Scratch scratch;
  const std::string file = scratch.file("written.json"), again = scratch.file("again.json");
  Outcome outcome = run_command({"inspect", "bennett", "--outputs", "all", "--write", file, "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.json()["scene"], "bennett");
  EXPECT_EQ(write_scene(read_scene(file)), write_scene(sample("bennett").with_outputs({"all"})));
  ASSERT_EQ(run_command({"inspect", file, "--modes", "--write", again}).status, 0);
  EXPECT_EQ(content(again), content(file));
  outcome = run_command({"inspect", file, "--write", file});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.err, "error: --write: " + file + " is an input and would be overwritten; name another file\n");
  EXPECT_EQ(run_command({"inspect", file, "--write", scratch.file("no/such.json")}).status, 3);
  EXPECT_EQ(run_command({"inspect", file, "--write", ""}).status, 2);
}

TEST(Inspect, OutputsReduceTheGroups) {
  const Outcome outcome = run_command({"inspect", "stewart", "--json", "--outputs", "handle1.value,handle2.value"});
  ASSERT_EQ(outcome.status, 0);
  const auto json = outcome.json();
  ASSERT_EQ(json["groups"].size(), 3u);
  for (std::size_t i = 1; i < 3; ++i) {
    EXPECT_EQ(json["groups"][i]["n"], 9);
    EXPECT_EQ(json["groups"][i]["of"], 15);
    EXPECT_EQ(json["groups"][i]["derivatives"], 0);
  }
  const auto left_out = json["left_out"];
  EXPECT_EQ(left_out["groups"], (nlohmann::json{"SG_HS3", "SG_HS4", "SG_HS5", "SG_HS6"}));
  EXPECT_EQ(left_out["unknowns"], 4 * 15 + 2 * 6);
  EXPECT_EQ(left_out["equations"], left_out["unknowns"]);
  EXPECT_EQ(left_out["static_groups"], 0);
  ASSERT_FALSE(left_out["levels"].empty());
  for (const auto& level : left_out["levels"]) {
    EXPECT_EQ(level["derivatives"], 0);
    EXPECT_EQ(level["for_predictor"], false);
  }
}

// `inspect` and `run` leave out the same groups, for declared groups and for the irreducible ones of `auto`.
TEST(Inspect, LeavesOutTheSameAsRun) {
  for (const std::string scene : {"stewart", "slider_crank", "four_bar:3"}) {
    const std::string output = scene == "stewart"        ? "handle1.value"
                               : scene == "slider_crank" ? "C.position"
                                                         : "B1.velocity";
    const auto seen = run_command({"inspect", scene, "--json", "--outputs", output}).json();
    const auto left_out = [&](const std::string& strategy) {
      const std::vector<std::string> call = {"run", scene,       "--json", "--quiet",    "--steps",
                                             "2",   "--outputs", output,   "--strategy", strategy};
      return run_command(call).json()["left_out"];
    };
    EXPECT_EQ(left_out("groups/eigen+predict=past:3"), seen["left_out"]) << scene;
    EXPECT_EQ(left_out("irreducible/eigen+predict=past:3"), seen["irreducible"]["left_out"]) << scene;
  }
  const Outcome page = run_command({"inspect", "stewart", "--outputs", "handle1.value"});
  EXPECT_NE(page.out.find("  left out        81 unknowns, 81 equations\n"), std::string::npos) << page.out;
  EXPECT_NE(page.out.find("                  of the irreducible groups 51 unknowns, 51 equations\n"), std::string::npos)
      << page.out;
}

// Notes on the posture come first, then notes on drivers, then notes on careless input.
TEST(Inspect, PrintsNotesOnceInOrderOfImportance) {
  const Scratch scratch;
  const std::string scene = scratch.file("notes.json", R"({"assur": 1, "dimension": 2,
      "points": {"A": {"at": [0, 0], "fixed": true}, "B": {"at": [1, 0]}, "D": {"at": [3, 0], "fixed": true},
                 "C": {"at": [-3, 0.5]}},
      "vectors": {"u": {"at": [2, 0], "fixed": true}, "v": {"at": [0, 3], "fixed": true}},
      "constraints": {"coupler": {"distance": ["B", "C"], "value": 2}, "rocker": {"distance": ["D", "C"], "value": 2}},
      "drivers": {"motor": {"angle": ["A", "B"], "law": {"constant": 0.5}}},
      "time": {"start": 0, "end": 1, "step": 0.5}})");
  const auto notes = run_command({"inspect", scene, "--json"}).json()["notes"];
  ASSERT_EQ(notes.size(), 3u) << notes;
  EXPECT_EQ(notes[0]["where"], "/points/C");
  EXPECT_EQ(notes[1]["where"], "/drivers/motor");
  EXPECT_EQ(notes[2]["what"], "2 vectors are normalised: u has length 2, v 3");
}

// The powers of two below 1.9, 1.5, 3.2 and 4.5 m are 1, 1, 2 and 4 m; the larger one of the two in the middle is
// taken. Those of a thousandth of these lengths are 1/1024, 1/1024, 1/512 and 1/256 m.
TEST(Inspect, ShowsTheCharacteristicLength) {
  const Scratch scratch;
  const auto scene = [&](const std::string& name, const std::string& size) {
    return scratch.file(name, R"({"assur": 1, "dimension": 2, "parameters": {"s": )" + size + R"(},
      "points": {"A": {"at": [0, 0], "fixed": true}, "B": {"at": [0, "=1.9*s"]}, "C": {"at": ["=2*s", "=2.5*s"]},
                 "D": {"at": ["=4.5*s", 0], "fixed": true}},
      "constraints": {"ab": {"distance": ["A", "B"], "value": "=1.9*s"},
                      "bc": {"distance": ["B", "C"], "value": "=1.5*s"},
                      "cd": {"distance": ["C", "D"], "value": "=4.5*s"}},
      "drivers": {"motor": {"distance": ["A", "C"], "law": {"constant": "=3*s"}}}})");
  };
  EXPECT_EQ(run_command({"inspect", scene("m.json", "1"), "--json"}).json()["characteristic_length"], 2);
  EXPECT_EQ(run_command({"inspect", scene("mm.json", "1e-3"), "--json"}).json()["characteristic_length"], 1. / 512);
  const Outcome page = run_command({"inspect", scene("m.json", "1")});
  EXPECT_NE(page.out.find("\n  length          2 m, the characteristic length\n"), std::string::npos) << page.out;
}

// All figures of the JSON equal those of the structure.
TEST(Inspect, JsonHasTheStructure) {
  for (const std::string scene : {"andrews", "slider_crank", "four_bar:5", "rings:legs=2,n=12"}) {
    for (const Formulation formulation : {Formulation::global, Formulation::groups, Formulation::irreducible}) {
      const std::string text(name(formulation));
      const Outcome outcome = run_command({"inspect", scene, "--json", "--formulation", text});
      ASSERT_EQ(outcome.status, 0) << scene;
      const auto json = outcome.json();
      StructureOptions options;
      options.formulation = formulation;
      const GroupedSystem s = group_equations(sample(scene), options);
      EXPECT_EQ(json["formulation"], text);
      EXPECT_EQ(json["coordinates"], s.coordinates);
      EXPECT_EQ(json["unknowns"], s.unknowns);
      EXPECT_EQ(json["derived"], s.derived);
      EXPECT_EQ(json["equations"], s.equations);
      EXPECT_EQ(json["eliminated"], s.eliminated);
      EXPECT_EQ(json["levels"], s.levels);
      EXPECT_EQ(json["classes"], s.classes.size());
      EXPECT_EQ(json["characteristic_length"], s.system->unit(1));
      ASSERT_EQ(json["groups"].size(), s.groups.size());
      for (std::size_t g = 0; g < s.groups.size(); ++g) {
        EXPECT_EQ(json["groups"][g]["name"], s.groups[g].name);
        EXPECT_EQ(json["groups"][g]["n"], s.groups[g].unknowns.size());
        EXPECT_EQ(json["groups"][g]["nnz"], s.shape(s.groups[g]).nnz);
        EXPECT_EQ(json["groups"][g]["fill"], s.fill(s.groups[g]));
        EXPECT_EQ(json["groups"][g]["class"], s.groups[g].group_class);
      }
    }
  }
}

TEST(Inspect, IrreducibleGroupsAreShownBeforeAndAfterPresolve) {
  const auto json = run_command({"inspect", "stewart", "--json"}).json()["irreducible"];
  EXPECT_EQ(json["eliminated"], 6 * 6);  // B - A = L1 e and P - B = L2 r in each leg
  EXPECT_EQ(json["groups"], 6 * 3);
  EXPECT_EQ(json["sizes"], (nlohmann::json::parse(R"([{"n": 3, "groups": 18}])")));
  EXPECT_EQ(json["blocks_of_classes"][1], (nlohmann::json{9, 3, 3}));
}

TEST(Inspect, NamesUndeterminedUnknownsWithoutFailure) {
  const Outcome outcome = run_command({"inspect", "hexapod:drive=legs", "--json"});
  ASSERT_EQ(outcome.status, 0);
  const auto undetermined = outcome.json()["undetermined"];
  ASSERT_FALSE(undetermined.empty());
  const Outcome page = run_command({"inspect", "hexapod:drive=legs"});
  EXPECT_NE(page.out.find("\n  undetermined    " + std::string(undetermined[0]) + ", "), std::string::npos) << page.out;
}

TEST(Inspect, PrintsTheDocumentedPage) {
  const Outcome outcome = run_command({"inspect", "stewart", "--outputs", "handle1,handle2.value"});
  ASSERT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(outcome.out, R"(stewart, 3D

  coordinates       156  of points, vectors and auxiliaries
  derived            36  of body members: no unknowns, no equations
  unknowns          102
  equations         102
  mobility            6  without the drivers
  groups              3  declared ones, else irreducible
  classes             3  of groups with the same equations
  levels              2  of groups independent of each other
  length          0.25 m, the characteristic length

  level  group   unknowns  nonzeros  fill  class  up to
      0  SG_T          12        39    39      0  acceleration
      1  SG_HS1   9 of 15        21    27      1  acceleration
      1  SG_HS2   9 of 15        21    28      2  position

  irreducible     class 0: 12 = 1 + 1 + 1 + 3 + 3 + 3
                  linear equations eliminate 36 unknowns; this leaves 2 groups
                  of 3
  left out        72 unknowns, 72 equations
                  4 groups: SG_HS3, SG_HS4, SG_HS5, SG_HS6
                  no velocity, no acceleration: SG_HS2
                  of the irreducible groups 48 unknowns, 48 equations
                  16 groups: e3, e4, e5, e6, c1, c2, c3, c4, c5, c6, d1, d2, d3,
                  d4, d5, d6
                  no velocity, no acceleration: e2
)");
}

TEST(Inspect, PagesFitIntoEightyColumns) {
  for (const std::string scene : {"stewart", "stewart:platforms=20", "four_bar:30", "gough", "andrews", "slider_crank",
                                  "hexapod:drive=legs", "rings:legs=6,n=120,terminal=24"}) {
    const Outcome outcome = run_command({"inspect", scene});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    for (const std::string& line : outcome.lines()) EXPECT_LE(output::display_width(line), 80u) << line;
  }
}

TEST(Inspect, ShowsLargeScenesByClass) {
  const Outcome outcome = run_command({"inspect", "four_bar:20000"});
  ASSERT_EQ(outcome.status, 0);
  EXPECT_LT(outcome.lines().size(), 25u);
  EXPECT_NE(outcome.out.find("\n      0  20,000  B1 "), std::string::npos) << outcome.out;
}

// The dyad of the four-bar: C is to the left or to the right of the line from B to D.
TEST(Inspect, ShowsAllModes) {
  const Scratch scratch;
  const std::string scene = scratch.file("four_bar.json", R"({"assur": 1, "name": "four_bar", "dimension": 2,
      "points": {"A": {"at": [0, 0], "fixed": true}, "D": {"at": [2, 0], "fixed": true}, "B": {"at": [0.8, 0]},
                 "C": {"at": [1.6, 1.2]}},
      "constraints": {"coupler": {"distance": ["B", "C"], "value": 1}, "rocker": {"distance": ["D", "C"], "value": 1}},
      "drivers": {"motor": {"angle": ["A", "B"], "law": {"constant": 0}}}})");
  const Outcome page = run_command({"inspect", scene, "--modes"});
  EXPECT_EQ(page.status, 0);
  EXPECT_EQ(page.err, "");
  const std::vector<std::string> lines = page.lines();
  ASSERT_EQ(lines.size(), 5u) << page.out;
  EXPECT_EQ(lines[0], "four_bar, 2D: assembly modes at the start");
  EXPECT_EQ(lines[2], "  group  mode         residual  condition  unknowns");
  EXPECT_EQ(lines[3].substr(0, 21), "  C         0  start ");
  EXPECT_TRUE(lines[3].ends_with("  C = (1.4, 0.8)")) << lines[3];
  EXPECT_EQ(lines[4].substr(0, 21), "            1        ");
  EXPECT_TRUE(lines[4].ends_with("  C = (1.4, -0.8)")) << lines[4];

  const auto json = run_command({"inspect", scene, "--modes", "--json"}).json();
  ASSERT_EQ(json["groups"].size(), 1u);
  const auto& group = json["groups"][0];
  EXPECT_EQ(group["group"], "C");
  EXPECT_EQ(group["unknowns"], (nlohmann::json{"C.x", "C.y"}));
  EXPECT_EQ(group["start"], 0);
  EXPECT_EQ(group["complete"], true);
  EXPECT_EQ(group["paths"], 2);
  ASSERT_EQ(group["modes"].size(), 2u);
  EXPECT_NEAR(group["modes"][1]["values"][1], -0.8, 1e-15);
  EXPECT_LT(group["modes"][1]["residual"], 1e-15);
  EXPECT_EQ(group["folds"].size(), 0u);
}

TEST(Inspect, SaysWhyModesAreMissing) {
  const Outcome large = run_command({"inspect", "gough", "--modes"});
  EXPECT_EQ(large.status, 0);
  EXPECT_NE(large.out.find("findings        B1+u+v+w: not computed: it has 12 unknowns; at most 6 can be\n"),
            std::string::npos)
      << large.out;
  const Scratch scratch;
  const std::string folded = scratch.file("folded.json", R"({"assur": 1, "name": "folded", "dimension": 2,
      "points": {"A": {"at": [0, 0], "fixed": true}, "D": {"at": [2, 0], "fixed": true}, "P": {"at": [1, 0]}},
      "constraints": {"rod": {"distance": ["D", "P"], "value": 1}},
      "drivers": {"cylinder": {"distance": ["A", "P"], "law": {"constant": 1}}}})");
  const Outcome fold = run_command({"inspect", folded, "--modes", "--json"});
  EXPECT_EQ(fold.status, 0);
  const auto group = fold.json()["groups"][0];
  EXPECT_EQ(group["start"], nullptr);
  EXPECT_EQ(group["modes"].size(), 0u);
  EXPECT_EQ(group["multiple"], 2);
  ASSERT_EQ(group["folds"].size(), 1u);
  const Outcome page = run_command({"inspect", folded, "--modes"});
  EXPECT_NE(page.out.find("P: 2 paths end at multiple solutions (folds)"), std::string::npos) << page.out;
}

TEST(Inspect, RefusesUnknownOutputs) {
  const Outcome outcome = run_command({"inspect", "stewart", "--outputs", "handle1,handel2"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(outcome.err.rfind("error: /outputs/1: ", 0), 0u) << outcome.err;
}

TEST(Inspect, ShowsTheRangeOfADriver) {
  const std::string scene = ASSUR_SOURCE_DIR "/scenes/bricard_joints.json";
  const Outcome outcome = run_command({"inspect", scene, "--json", "--range"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto range = outcome.json()["range"];
  EXPECT_EQ(range["driver"], "motor");
  EXPECT_EQ(range["unit"], "rad");
  EXPECT_EQ(range["low"]["status"], "fold");
  EXPECT_NEAR(range["low"]["reached"], -30 * kTurn / 360, 1e-12);
  EXPECT_NEAR(range["high"]["beyond"], 210 * kTurn / 360, 1e-12);
  const Outcome page = run_command({"inspect", scene, "--range", "motor"});
  EXPECT_NE(page.out.find("\n    least         -0.523598775598 ± "), std::string::npos) << page.out;
  EXPECT_NE(page.out.find("\n    greatest      3.66519142919 ± "), std::string::npos) << page.out;
  EXPECT_EQ(run_command({"inspect", "stewart", "--range", "handle"}).status, 2);
}

}  // namespace
}  // namespace assur
