// `assur import`, and commands that take models of MuJoCo.
#include <gtest/gtest.h>

#include "assur/scene.hpp"
#include "commands/command.hpp"
#include "source_dir.hpp"

namespace assur {
namespace {

const std::string kModels = ASSUR_SOURCE_DIR "/scenes/mjcf/";

TEST(Import, WritesTheSceneThatRunTakes) {
  const Scratch scratch;
  const std::string scene = scratch.file("delta.json");
  const std::vector<std::string> drive = {"--drive", "shoulder_a=0,0.3", "--drive",
                                          "shoulder_c={\"harmonics\":[{\"amplitude\":0.2,\"frequency\":1}]}"};
  std::vector<std::string> arguments = {"import", kModels + "delta.xml", "--out", scene, "--json"};
  arguments.insert(arguments.end(), drive.begin(), drive.end());
  const Outcome made = run_command(arguments);
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_EQ(made.err, "");
  const auto json = made.json();
  EXPECT_EQ(json["scene"], "delta");
  EXPECT_EQ(json["bodies"], 10);
  EXPECT_EQ(json["joints"], 16);
  EXPECT_EQ(json["loops"], 6);
  EXPECT_EQ(json["left_out"], nlohmann::json::parse(R"([{"kind": "geom", "count": 11}])"));
  ASSERT_EQ(json["drivers"].size(), 3u);
  EXPECT_EQ(json["drivers"][1],
            nlohmann::json::parse(R"({"name": "motor_b", "coordinate": "shoulder_b.angle", "controlled": true})"));
  EXPECT_EQ(json["out"], scene);

  // The written scene and the model itself move the same, to the bit.
  arguments = {"run", kModels + "delta.xml", "--csv", "-"};
  arguments.insert(arguments.end(), drive.begin(), drive.end());
  const Outcome model = run_command(arguments), file = run_command({"run", scene, "--csv", "-"});
  ASSERT_EQ(model.status, 0) << model.err;
  EXPECT_EQ(model.lines().size(), 102u);
  EXPECT_EQ(model.out, file.out);
}

TEST(Import, ListsThePartsOfTheScene) {
  const Outcome outcome = run_command({"import", kModels + "four_bar.xml"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.out,
            "four_bar: 3 moving bodies, 3 joints, 1 loop\n"
            "  controlled      shaft.angle (motor); at rest until --drive or a program moves\n"
            "                  them\n"
            "  not driven      elbow, swing\n"
            "  left out        geom (4), light\n"
            "  scene           not written; --out FILE writes it\n");
}

TEST(Import, RunListsTheJointsOfAModelThatNothingDrives) {
  const std::string model = kModels + "four_bar.xml";
  const Outcome run = run_command({"run", model, "--drive", "shaft=free"});
  EXPECT_EQ(run.status, 2);
  EXPECT_EQ(run.err, "error: " + model +
                         ": no joint is driven, so that nothing moves; choose with --drive JOINT=LAW "
                         "among: shaft, elbow, swing\n");
  const Outcome inspect = run_command({"inspect", model, "--drive", "shaft=free", "--json"});
  ASSERT_EQ(inspect.status, 0) << inspect.err;
  EXPECT_EQ(inspect.json()["mobility"], 1);
}

TEST(Import, RefusesWrongFilesAndOptions) {
  const Scratch scratch;
  const std::string model = scratch.file("model.xml", "<mujoco/>"), other = scratch.file("scene.json", "{}");
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"import", model, "--out", model},
       "--out: " + model + " is an input and would be overwritten; name another file"},
      {{"import", other}, other + ": a model of MuJoCo is wanted here, a file that ends with .xml"},
      {{"import", scratch.file("none.xml")},
       scratch.file("none.xml") + ": the model cannot be read: no such file or directory"},
      {{"run", "stewart", "--key", "home"}, "--key: is for models of MuJoCo, files that end with .xml"},
      {{"inspect", "stewart", "--drive", "a=1"}, "--drive: is for models of MuJoCo, files that end with .xml"},
      {{"run", kModels + "delta.xml", "--drive", "elbow=1"},
       "--drive elbow: there is no such hinge or slide; there are: shoulder_a, left_pitch_a"}};
  for (const auto& [arguments, message] : cases) {
    const Outcome outcome = run_command(arguments);
    EXPECT_NE(outcome.status, 0);
    EXPECT_EQ(outcome.out, "");
    EXPECT_TRUE(outcome.err.starts_with("error: " + message)) << outcome.err;
  }
  const Outcome wrong = run_command({"run", model, "--drive", "fast"});
  EXPECT_EQ(wrong.err, "error: --drive: expects joint=LAW, not \"fast\"\nSee assur run --help.\n");
}

}  // namespace
}  // namespace assur
