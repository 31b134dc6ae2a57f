// Where a run of the command starts and ends: assembly modes by number and by a guess, and limits of the scene.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "commands/command.hpp"

namespace assur {
namespace {

// Two dyads in a row: C over or under BD, and F over or under CE.
constexpr const char* kDyads = R"({"assur": 1, "name": "dyads", "dimension": 2,
  "parameters": {"length": 1},
  "points": {"A": {"at": [0, 0], "fixed": true}, "D": {"at": [2, 0], "fixed": true}, "B": {"at": [0.8, 0]},
             "C": {"at": [1.6, 1.2]}, "E": {"at": [3, 0], "fixed": true}, "F": {"at": [2.4, 1]}},
  "constraints": {"coupler": {"distance": ["B", "C"], "value": 1}, "rocker": {"distance": ["D", "C"], "value": "=length"},
                  "link": {"distance": ["C", "F"], "value": 1.2}, "lever": {"distance": ["E", "F"], "value": 1}},
  "drivers": {"motor": {"angle": ["A", "B"], "law": {"polynomial": [0, 0.1]}}},
  "outputs": ["C", "F"], "time": {"start": 0, "end": 0.1, "step": 0.1}})";

class StartModes : public testing::Test {
 protected:
  // The first row of the motion: C.x, C.y, F.x, F.y.
  std::vector<double> row(std::vector<std::string> options) {
    options.insert(options.begin(), {"run", scene_, "--csv", "-", "--quiet", "--outputs", "C.position,F.position"});
    const Outcome outcome = run_command(options);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    std::vector<double> numbers;
    if (outcome.lines().size() < 2) return std::vector<double>(4, NAN);
    std::string line = outcome.lines()[1] + ",";
    for (std::size_t comma; (comma = line.find(',')) != std::string::npos; line.erase(0, comma + 1)) {
      numbers.push_back(std::stod(line.substr(0, comma)));
    }
    return {numbers.begin() + 1, numbers.end()};
  }
  std::string refusal(std::vector<std::string> options) {
    options.insert(options.begin(), {"run", scene_});
    const Outcome outcome = run_command(options);
    EXPECT_EQ(outcome.status, 2);
    return outcome.err;
  }

  Scratch scratch_;
  std::string scene_ = scratch_.file("dyads.json", kDyads);
};

TEST_F(StartModes, AreChosenByNumberAndByAGuess) {
  const std::vector<double> start = row({});
  EXPECT_NEAR(start[0], 1.4, 1e-15);
  EXPECT_NEAR(start[1], 0.8, 1e-15);
  const std::vector<double> zero = row({"--start-mode", "C=0"});
  for (std::size_t k = 0; k < start.size(); ++k) EXPECT_NEAR(zero[k], start[k], 1e-14);
  for (const std::vector<std::string>& below :
       std::vector<std::vector<std::string>>{{"--start-mode", "C=1"}, {"--guess", "C=1.2,-0.5"}}) {
    const std::vector<double> at = row(below);
    EXPECT_NEAR(at[0], 1.4, 1e-15);
    EXPECT_NEAR(at[1], -0.8, 1e-15);
  }
  // The mode of F is that at the chosen posture of C, in whatever order the options are written.
  const std::vector<double> one = row({"--guess", "F=3,-2", "--guess", "C=1.4,-1"});
  const std::vector<double> other = row({"--guess", "C=1.4,-1", "--guess", "F=3,-2"});
  EXPECT_EQ(one, other);
  EXPECT_NEAR(one[1], -0.8, 1e-15);
  EXPECT_NEAR(std::hypot(one[2] - 3, one[3]), 1, 1e-14);
  EXPECT_NEAR(std::hypot(one[2] - one[0], one[3] - one[1]), 1.2, 1e-14);
  EXPECT_LT(one[3], row({"--guess", "C=1.4,-1", "--guess", "F=3,2"})[3]);
}

TEST_F(StartModes, OfMembersAreChosenByAGuess) {
  const std::string members = scratch_.file("members.csv", "length\n1\n1.1\n");
  const Outcome outcome =
      run_command({"run", scene_, "--ensemble", members, "--guess", "C=1.4,-1", "--csv", "-", "--quiet"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  ASSERT_EQ(outcome.lines().size(), 5u);
  for (std::size_t i = 1; i < 5; ++i) {
    const std::string line = outcome.lines()[i];
    const std::size_t x = line.find(',', line.find(',') + 1), y = line.find(',', x + 1);
    EXPECT_LT(std::stod(line.substr(y + 1)), 0) << line;
  }
  EXPECT_EQ(run_command({"run", scene_, "--ensemble", members, "--start-mode", "C=1"}).status, 2);
}

TEST_F(StartModes, AreRefusedWithTheRemedy) {
  EXPECT_EQ(
      refusal({"--start-mode", "1"}),
      "error: --start-mode: several groups have modes to choose; name one of them: C, F, as in --start-mode C=1\n");
  EXPECT_EQ(refusal({"--start-mode", "C=2"}),
            "error: --start-mode C: group C has no mode 2; its modes are 0 to 1 (assur inspect SCENE --modes)\n");
  EXPECT_EQ(refusal({"--guess", "G=0,0"}),
            "error: --guess: no group has the name 'G' or solves a point of that name; there are: C, F\n");
  EXPECT_EQ(refusal({"--guess", "C=0,0,0"}), "error: --guess C: the scene has dimension 2; give x,y\n");
  EXPECT_EQ(refusal({"--guess", "C=1,-1", "--start-mode", "C=1"}),
            "error: --start-mode C: the mode of group C is chosen twice\n");
  EXPECT_NE(refusal({"--guess", "C=1.4,0"}).find("are equally near to the place given for 'C'"), std::string::npos);
  EXPECT_NE(refusal({"--start-mode", "C=x"}).find("expects a number from 0"), std::string::npos);
  EXPECT_NE(refusal({"--guess", "C=1"}).find("expects a point with its place"), std::string::npos);
}

TEST(CommandStops, EndWithTheirStatusAndTheirPlace) {
  const Scratch scratch;
  const std::string text = R"({"assur": 1, "name": "arm", "dimension": 2, "angles": "deg",
    "bodies": {"arm": {"points": {"P": {"at": [1, 0]}}}},
    "joints": {"J": {"revolute": ["ground", "arm"], "at": [0, 0]}},
    "drivers": {"motor": {"coordinate": "J.angle", "law": {"polynomial": [0, 90]}}},
    "limits": {"J.angle": {"max": 45REACTION}},
    "outputs": ["P.position"], "time": {"start": 0, "end": 1, "step": 0.1}})";
  const auto scene = [&](const std::string& reaction) {
    std::string own = text;
    own.replace(own.find("REACTION"), 8, reaction);
    return scratch.file("arm" + std::to_string(reaction.size()) + ".json", own);
  };
  const Outcome ended = run_command({"run", scene(""), "--json"});
  EXPECT_EQ(ended.status, 1);
  const auto json = ended.json();
  EXPECT_EQ(json["status"], "limit_reached");
  EXPECT_EQ(json["steps"], 5);
  ASSERT_EQ(json["events"].size(), 1u);
  const auto& event = json["events"][0];
  EXPECT_EQ(event["kind"], "limit_reached");
  EXPECT_EQ(event["group"], "J.angle");
  EXPECT_EQ(event["unit"], "rad");
  EXPECT_NEAR(event["time"], 0.5, 1e-12);
  EXPECT_NEAR(event["until"], 0.5, 1e-12);
  const Outcome page = run_command({"run", scene("")});
  EXPECT_NE(page.err.find("error: t = 0.5 ... 0.5 s, limit of J.angle: a limit of the scene ends the motion "
                          "(limit_reached): the largest allowed value is 0.7853981634 rad"),
            std::string::npos)
      << page.err;
  const auto flagged = run_command({"run", scene(R"(, "reaction": "flag")"), "--json"});
  EXPECT_EQ(flagged.status, 0);
  EXPECT_EQ(flagged.json()["status"], "ok");
  EXPECT_EQ(flagged.json()["events"][0]["kind"], "limit_exceeded");
  EXPECT_EQ(flagged.json()["steps"], 10);
  const auto range = run_command({"inspect", scene(""), "--range", "--json"}).json()["range"];
  EXPECT_EQ(range["high"]["status"], "limit_reached");
  EXPECT_EQ(range["high"]["group"], "J.angle");
  EXPECT_NEAR(range["high"]["reached"], std::acos(0.0) / 2, 1e-12);
  const auto passed = run_command({"inspect", scene(R"(, "reaction": "flag")"), "--range", "--json"}).json()["range"];
  ASSERT_EQ(passed["limits_passed"].size(), 1u);
  EXPECT_EQ(passed["limits_passed"][0]["limit"], "J.angle");
  const Outcome shown = run_command({"inspect", scene("")});
  EXPECT_NE(shown.out.find("limits          J.angle up to 0.785398 rad, ends the motion\n"), std::string::npos)
      << shown.out;
  const std::string members = scratch.file("members.csv", "speed\n90\n-90\n");
  std::string with_speed = text;
  with_speed.replace(with_speed.find("REACTION"), 8, "");
  with_speed.replace(with_speed.find("[0, 90]"), 7, "[0, \"=speed\"]");
  with_speed.replace(with_speed.find("\"bodies\""), 8, "\"parameters\": {\"speed\": 1}, \"bodies\"");
  const Outcome both = run_command({"run", scratch.file("speed.json", with_speed), "--ensemble", members, "--json"});
  EXPECT_EQ(both.status, 1);
  ASSERT_EQ(both.json()["failed"].size(), 1u);
  EXPECT_EQ(both.json()["failed"][0]["member"], 1);
}

}  // namespace
}  // namespace assur
