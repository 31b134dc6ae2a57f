// assur run --animate and --plot.
#include <gtest/gtest.h>

#include "commands/command.hpp"
#include "commands/fold.hpp"

namespace assur {
namespace {

TEST(RunPictures, WritesBothPicturesWithoutChangingTheRun) {
  const Scratch scratch;
  const std::string page = scratch.file("motion.html"), picture = scratch.file("motion.svg");
  const std::vector<std::string> call = {"run",     "stewart", "--steps", "20",     "--outputs",
                                         "handle2", "--csv",   "-",       "--quiet"};
  const Outcome plain = run_command(call);
  std::vector<std::string> with = call;
  with.insert(with.end(), {"--animate", page, "--plot", picture});
  const Outcome drawn = run_command(with);
  ASSERT_EQ(drawn.status, 0) << drawn.err;
  EXPECT_EQ(drawn.out, plain.out);
  EXPECT_EQ(content(page).find("<!DOCTYPE html>"), 0u);
  EXPECT_NE(content(page).find("\"name\":\"P6\""), std::string::npos);  // shown, although it is not an output
  EXPECT_NE(content(page).find("20 steps of 0.01 s from t = 0 s; strategy auto; assur "), std::string::npos);
  EXPECT_EQ(content(picture).find("<svg xmlns=\"http://www.w3.org/2000/svg\""), 0u);
  EXPECT_NE(content(picture).find("handle2, rate, rad/s"), std::string::npos);
}

// Output B depends only on the driver, which can turn on. The picture also shows C, which cannot follow.
TEST(RunPictures, ShowsWhyAMotionEndsEarly) {
  const Scratch scratch;
  const std::string scene = scratch.file("fold.json", kFold), page = scratch.file("motion.html");
  ASSERT_EQ(run_command({"run", scene, "--quiet", "--outputs", "B"}).status, 0);
  const Outcome cut = run_command({"run", scene, "--quiet", "--outputs", "B", "--animate", page});
  EXPECT_EQ(cut.status, 0) << cut.err;
  EXPECT_NE(content(page).find("The motion ends early: t = 1.3181"), std::string::npos);
  EXPECT_NE(content(page).find("group C: the mechanism cannot move further"), std::string::npos);

  const std::string picture = scratch.file("motion.svg");
  const Outcome whole = run_command({"run", scene, "--quiet", "--outputs", "C", "--plot", picture});
  EXPECT_EQ(whole.status, 1);
  EXPECT_NE(content(picture).find("The motion ends early: t = 1.3181"), std::string::npos);
}

TEST(RunPictures, ShowsAStartPostureThatCannotBeAssembled) {
  const Scratch scratch;
  const std::string page = scratch.file("motion.html");
  const std::string scene = scratch.file("short.json", R"({"assur": 1, "dimension": 2,
      "points": {"A": {"at": [0, 0], "fixed": true}, "B": {"at": [4, 0], "fixed": true}, "P": {"at": [1, 1]}},
      "constraints": {"PA": {"distance": ["P", "A"], "value": 1.5}, "PB": {"distance": ["P", "B"], "value": 1.5}},
      "time": {"start": 0, "end": 1, "step": 0.1}})");
  const Outcome o = run_command({"run", scene, "--quiet", "--animate", page});
  EXPECT_EQ(o.status, 1);
  EXPECT_NE(o.err.find("group P cannot be assembled"), std::string::npos) << o.err;
  const std::string text = content(page);
  EXPECT_NE(text.find("The mechanism cannot be assembled: group P cannot be assembled: "), std::string::npos);
  EXPECT_NE(text.find("Shown are the guess and the closest posture, which violates P"), std::string::npos);
  EXPECT_NE(text.find("by 0.4375 m"), std::string::npos);
  EXPECT_NE(text.find("\"postures\":[\"the guess\",\"the closest posture\"],\"violated\":[\"P"), std::string::npos);
}

TEST(RunPictures, AnimatesEveryStrategy) {
  const Scratch scratch;
  for (const std::string strategy : {"global/eigen", "irreducible/lanes:8+once", "groups/eigen+chunks=4"}) {
    const std::string page = scratch.file("motion.html");
    const Outcome o = run_command({"run", "four_bar:2", "--quiet", "--strategy", strategy, "--animate", page});
    EXPECT_EQ(o.status, 0) << o.err;
    EXPECT_NE(content(page).find("strategy " + strategy), std::string::npos);
  }
}

TEST(RunPictures, ReportsUnwritableFilesBeforeTheRun) {
  const Scratch scratch;
  for (const std::string option : {"--animate", "--picture", "--plot"}) {
    const Outcome o = run_command({"run", "stewart", option, scratch.file("no_such_folder/file")});
    EXPECT_EQ(o.status, 3);
    EXPECT_EQ(o.out, "");
    EXPECT_NE(o.err.find(option + ": cannot write"), std::string::npos) << o.err;
    EXPECT_NE(o.err.find("no_such_folder"), std::string::npos) << o.err;
  }
}

TEST(RunPictures, AreRefusedForEnsembles) {
  const Scratch scratch;
  const std::string speeds = scratch.file("speeds.csv", "omega\n0.5\n1\n");
  for (const std::string option : {"--animate", "--picture", "--plot"}) {
    const Outcome o = run_command({"run", "stewart", "--ensemble", speeds, option, scratch.file("file")});
    EXPECT_EQ(o.status, 2);
    EXPECT_NE(o.err.find(option + ": it shows a single mechanism"), std::string::npos) << o.err;
  }
}

}  // namespace
}  // namespace assur
