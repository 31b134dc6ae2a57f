// `assur sweep linkages`. The test sweep.linkages reads the data set.
#include <gtest/gtest.h>

#include <cmath>

#include "commands/command.hpp"

namespace assur {
namespace {

std::vector<std::string> linkages(const std::string& out, const std::vector<std::string>& more = {}) {
  std::vector<std::string> all = {"sweep", "linkages:joints=5..9,times=50", "--out", out, "--json"};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

// Skips the test in a build without HDF5.
#define ASSUR_NEEDS_HDF5(outcome) \
  if ((outcome).err.find("HDF5 was not found") != std::string::npos) GTEST_SKIP() << (outcome).err

TEST(SweepLinkages, CountsAllSamples) {
  const Scratch scratch;
  const Outcome all = run_command(linkages(scratch.file("all.h5"), {"--samples", "10000"}));
  ASSUR_NEEDS_HDF5(all);
  ASSERT_EQ(all.status, 0) << all.err;
  const auto json = all.json();
  EXPECT_EQ(json["samples"], 10000);
  EXPECT_GT(json["done"], 1000);
  EXPECT_GT(json["jammed"], 1000);
  const auto sum = [](const nlohmann::json& j) {
    return j["done"].get<int>() + j["jammed"].get<int>() + j["not_assembled"].get<int>() + j["inaccurate"].get<int>();
  };
  EXPECT_EQ(sum(json), 10000);
  int done = 0;
  for (const std::string range : {"0:5000", "5000:5001", "5001:10000"}) {
    const Outcome part = run_command(
        linkages(scratch.file("part" + range.substr(0, 4) + ".h5"), {"--samples", "10000", "--range", range}));
    ASSERT_EQ(part.status, 0) << part.err;
    done += part.json()["done"].get<int>();
  }
  EXPECT_EQ(json["done"], done);
}

// Of many joints, so that few linkages are done and the files are small.
TEST(SweepLinkages, AnInterruptedSweepGoesOn) {
  const Scratch scratch;
  const auto sweep_to = [](const std::string& out) -> std::vector<std::string> {
    return {"sweep", "linkages:joints=30,times=50", "--samples", "500000", "--threads", "1", "--json", "--out", out};
  };
  const Outcome once = run_command(sweep_to(scratch.file("once.h5")));
  ASSUR_NEEDS_HDF5(once);
  ASSERT_EQ(once.status, 0) << once.err;
  const std::string out = scratch.file("all.h5");
  const Outcome first = run_command(sweep_to(out), {.interrupt_when_err = "%"});
  EXPECT_EQ(first.status, 130) << first.err;
  const Outcome rest = run_command(sweep_to(out));
  ASSERT_EQ(rest.status, 0) << rest.err;
  for (const char* figure : {"samples", "done", "jammed", "not_assembled", "inaccurate"}) {
    EXPECT_EQ(rest.json()[figure], once.json()[figure]) << figure;
  }
  EXPECT_LT(first.json()["samples"], 500000);
  EXPECT_GT(first.json()["samples"], 0);
  EXPECT_EQ(content(out).size(), content(scratch.file("once.h5")).size());
}

// Half of an ellipse with its chord.
std::string a_curve() {
  std::string text = "x,y\n";
  for (int i = 0; i < 40; ++i) text += std::to_string(-1 + i / 20.0) + ",0\n";
  for (int i = 0; i < 40; ++i) {
    text += std::to_string(std::cos(0.0785 * i)) + "," + std::to_string(0.5 * std::sin(0.0785 * i)) + "\n";
  }
  return text;
}

TEST(SweepLinkages, FindsPathsLikeACurve) {
  const Scratch scratch;
  const std::string target = scratch.file("curve.csv", a_curve()), out = scratch.file("all.h5");
  const std::string page = scratch.file("page.html");
  const std::vector<std::string> arguments =
      linkages(out, {"--samples", "6000", "--target", target, "--best", "4", "--html", page});
  const Outcome first = run_command(arguments);
  ASSUR_NEEDS_HDF5(first);
  ASSERT_EQ(first.status, 0) << first.err;
  const auto best = first.json()["best"];
  ASSERT_EQ(best.size(), 4u);
  double before = 0;
  for (const auto& row : best) {
    EXPECT_GE(row["figures"]["distance"], before);
    before = row["figures"]["distance"];
  }
  EXPECT_LT(before, 0.2) << "a random path is 0.3 to 0.5 away";
  EXPECT_EQ(run_command(arguments).json()["best"], best) << "also of rows of an earlier call";
  const std::string text = content(page);
  std::size_t pictures = 0;
  for (std::size_t at = 0; (at = text.find("data:image/svg+xml;base64,", at)) != std::string::npos; ++at) ++pictures;
  EXPECT_EQ(pictures, 4u);
  const Outcome other = run_command(linkages(out, {"--samples", "6000"}));
  EXPECT_EQ(other.status, 2);
  EXPECT_NE((other.out + other.err).find("has another target"), std::string::npos) << other.out << other.err;
  for (const std::string bad : {"x,y\n1,2\n", "x,z\n1,2\n3,4\n5,6\n", "x,y\n1,a\n"}) {
    EXPECT_EQ(
        run_command(linkages(scratch.file("bad.h5"), {"--samples", "9", "--target", scratch.file("bad.csv", bad)}))
            .status,
        2)
        << bad;
  }
}

TEST(SweepLinkages, RefusesOtherFiles) {
  const Scratch scratch;
  const std::string out = scratch.file("all.h5");
  const std::vector<std::string> arguments = linkages(out, {"--samples", "100"});
  const Outcome first = run_command(arguments);
  ASSUR_NEEDS_HDF5(first);
  ASSERT_EQ(first.status, 0) << first.err;
  EXPECT_EQ(run_command(arguments).json()["samples"], 100) << "nothing is left to do";
  const auto refusal = [&](const std::vector<std::string>& of) {
    const Outcome outcome = run_command(of);
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    return outcome.out + outcome.err;
  };
  const auto expect = [&](const std::vector<std::string>& of, const std::string& what) {
    EXPECT_NE(refusal(of).find(what), std::string::npos) << what << "\n" << refusal(of);
  };
  const std::string remedy = "; choose another file or remove it";
  expect(linkages(out, {"--samples", "100", "--seed", "3"}), "has seed 0, this sweep 3" + remedy);
  expect(linkages(out, {"--samples", "101"}), "has last_sample 100, this sweep 101" + remedy);
  expect({"sweep", "linkages:joints=5..9,times=51", "--samples", "100", "--out", out}, "has other times" + remedy);
  expect({"sweep", "linkages:joints=5..9,times=50,precision=double", "--samples", "100", "--out", out},
         "has another precision" + remedy);
  expect(linkages(scratch.file("no.h5", "no data set"), {"--samples", "100"}),
         "is not an HDF5 file that can be continued" + remedy);
}

TEST(SweepLinkages, RefusesWrongOptions) {
  const Scratch scratch;
  const std::string out = scratch.file("all.h5");
  const auto expect = [&](std::vector<std::string> of, const std::string& what) {
    of.insert(of.begin(), "sweep");
    const Outcome outcome = run_command(of);
    EXPECT_EQ(outcome.status, 2) << what;
    EXPECT_NE(outcome.err.find(what), std::string::npos) << what << "\n" << outcome.err;
  };
  const std::string scene = "linkages";
  expect({scene, "--samples", "9", "--out", out, "--set", "a=1"}, "--set: random linkages have no parameters");
  expect({scene, "--samples", "9", "--out", out, "--reduce", "min"}, "--reduce: linkages have no figures");
  expect({scene, "--samples", "9", "--out", scratch.file("a.csv")}, "--out: linkages are written as HDF5");
  expect({scene, "--samples", "9", "--out", out, "--vary", "a=1:2"}, "--vary: random linkages have no parameters");
  expect({scene, "--samples", "9", "--out", out, "--sampler", "sobol"}, "--sampler: linkages are random");
  expect({scene, "--samples", "9", "--out", out, "--outputs", "C"}, "--outputs: ");
  expect({scene, "--samples", "9", "--out", out, "--best", "3"}, "--best: ");
  expect({scene, "--samples", "9", "--out", out, "--html", scratch.file("a.html")}, "--html: ");
  expect({scene, "--samples", "9", "--out", out, "--strategy", "groups/eigen"}, "--strategy: ");
  expect({scene, "--samples", "9", "--out", out, "--range", "3:10"}, "--range: expects I:J");
  expect({"linkages:joints=3..9", "--samples", "9", "--out", out}, "joints= expects a whole number from 4 to 1000");
  expect({"linkages:joints=9..5", "--samples", "9", "--out", out}, "joints=.. expects a whole number from 9 to 1000");
  expect({"linkages:times=1", "--samples", "9", "--out", out}, "times= expects a whole number from 2 to 1000000");
  expect({"linkages:bars=5", "--samples", "9", "--out", out}, "linkages has the options joints=5..20, times=200");
  expect({"four_bar", "--samples", "9", "--out", out}, "--vary: give the parameters to vary");
  expect({"four_bar", "--samples", "9", "--out", out, "--vary", "omega=1:2", "--target", "a.csv"},
         "--target: give the point whose path is compared with the curve: --trace POINT");
}

}  // namespace
}  // namespace assur
