// `assur sweep`.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "commands/command.hpp"
#include "source_dir.hpp"

namespace assur {
namespace {

const std::string kFourBar = ASSUR_SOURCE_DIR "/scenes/four_bar.json";

// Four-bars, some of which jam or cannot be assembled.
std::vector<std::string> sweep_of(const std::string& out, const std::vector<std::string>& more = {}) {
  std::vector<std::string> all = {"sweep", kFourBar,    "--set",  "steps=50",
                                  "--set", "step=0.02", "--vary", "crank_length=0.2:1.2,rocker_length=0.8:2",
                                  "--out", out};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

std::vector<std::vector<std::string>> cells_of(const std::string& file) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream in(content(file));
  for (std::string line; std::getline(in, line);) {
    rows.emplace_back();
    std::istringstream cells(line + ",");
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
  }
  return rows;
}

TEST(Sweep, ARowIsTheRunOfItsParameters) {
  const Scratch scratch;
  const std::string out = scratch.file("rows.csv");
  const Outcome outcome = run_command(sweep_of(
      out, {"--samples", "300", "--outputs", "B1", "--reduce", "min,max_time,last,range", "--best", "3", "--json"}));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto json = outcome.json();
  EXPECT_EQ(json["samples"], 300);
  EXPECT_GT(json["done"], 50);
  EXPECT_GT(json["jammed"], 10);
  EXPECT_GT(json["not_assembled"], 0);
  const auto rows = cells_of(out);
  ASSERT_EQ(rows.size(), 301u);
  EXPECT_EQ(rows[json["why_not"]["sample"].get<std::size_t>() + 1][3], "not_assembled");
  EXPECT_NE(json["why_not"]["why"].get<std::string>().find("assembled"), std::string::npos) << json["why_not"];
  ASSERT_EQ(rows[0].size(), 5u + 6 * 4);
  EXPECT_EQ(rows[0][1], "crank_length");
  EXPECT_EQ(rows[0][3], "status");
  EXPECT_EQ(rows[0][5], "B1.x.min");
  std::int64_t done = 0, compared = 0;
  double least = INFINITY;
  for (std::size_t k = 1; k < rows.size(); ++k) {
    const auto& row = rows[k];
    ASSERT_EQ(row[0], std::to_string(k - 1));
    if (row[3] == "ok") {
      ++done;
      least = std::min(least, std::stod(row[5]));
    }
    if (row[3] == "not_assembled") {
      EXPECT_EQ(row[4] + row[5], "");
    }
    if (k % 25 != 0) continue;
    ++compared;
    const std::string csv = scratch.file("one.csv");
    const Outcome one =
        run_command({"run", kFourBar, "--set", "steps=50", "--set", "step=0.02", "--set", "crank_length=" + row[1],
                     "--set", "rocker_length=" + row[2], "--outputs", "B1", "--csv", csv});
    if (row[3] == "not_assembled") {
      EXPECT_NE(one.status, 0) << k;
      continue;
    }
    EXPECT_EQ(one.status, row[3] == "ok" ? 0 : 1) << k << " " << one.err;
    const auto motion = cells_of(csv);
    double low = INFINITY, high = -INFINITY;
    for (std::size_t r = 1; r < motion.size(); ++r) {
      low = std::min(low, std::stod(motion[r][1]));
      high = std::max(high, std::stod(motion[r][1]));
    }
    EXPECT_NEAR(std::stod(row[5]), low, 1e-11) << k;
    EXPECT_NEAR(std::stod(row[7]), std::stod(motion.back()[1]), 1e-11) << k;
    EXPECT_NEAR(std::stod(row[8]), high - low, 1e-11) << k;
  }
  EXPECT_EQ(compared, 12);
  EXPECT_EQ(json["done"], done);
  ASSERT_EQ(json["best"].size(), 3u);
  EXPECT_EQ(json["best"][0]["figures"]["B1.x.min"], least);
  EXPECT_LE(json["best"][0]["figures"]["B1.x.min"], json["best"][1]["figures"]["B1.x.min"]);
}

// The rows are the same, bit by bit, for one range and several, and for every number of threads.
// The page has the rows of earlier calls, too.
TEST(Sweep, APageShowsAllRows) {
  const Scratch scratch;
  const std::string out = scratch.file("rows.csv"), page = scratch.file("page.html");
  const std::vector<std::string> what = {"--samples", "1500", "--best", "2"};
  ASSERT_EQ(run_command(sweep_of(out, what)).status, 0);
  std::vector<std::string> again = what;
  again.insert(again.end(), {"--html", page});
  ASSERT_EQ(run_command(sweep_of(out, again)).status, 0);
  const std::string text = content(page);
  EXPECT_NE(text.find("1,500 of 1,500 samples: "), std::string::npos);
  EXPECT_NE(text.find("Shown: 750 samples."), std::string::npos);
  EXPECT_NE(text.find(">sample 0, "), std::string::npos);
  EXPECT_NE(text.find(">sample 1498, "), std::string::npos);
  const std::size_t first = text.find("data:image/svg+xml;base64,PHN2Zy");  // "<svg"
  ASSERT_NE(first, std::string::npos);
  EXPECT_NE(text.find("data:image/svg+xml;base64,PHN2Zy", first + 1), std::string::npos);
  again.back() = out;
  EXPECT_EQ(run_command(sweep_of(out, again)).status, 2) << "the page would replace the rows";
}

TEST(Sweep, RangesAndThreadsDoNotMatter) {
  const Scratch scratch;
  for (const std::string sampler : {"random", "grid"}) {
    const std::vector<std::string> what = {"--samples", "3600", "--sampler",  sampler,
                                           "--seed",    "5",    "--strategy", "groups/lanes:8"};
    const auto rows_of = [&](const std::string& name, std::vector<std::string> more) {
      more.insert(more.end(), what.begin(), what.end());
      const Outcome outcome = run_command(sweep_of(scratch.file(name), more));
      EXPECT_EQ(outcome.status, 0) << outcome.err;
      const std::string all = content(scratch.file(name));
      return all.substr(all.find('\n') + 1);
    };
    const std::string all = rows_of("all" + sampler, {"--threads", "1"});
    EXPECT_EQ(rows_of("two" + sampler, {"--threads", "2"}), all);
    std::string parts;
    for (const std::string range : {"0:1", "1:1300", "1300:2048", "2048:3599", "3599:3600"}) {
      parts += rows_of(range + sampler, {"--range", range});
    }
    EXPECT_EQ(parts, all);
  }
}

// A file that ends anywhere is continued to the same file.
TEST(Sweep, ContinuesAFileThatWasCutAnywhere) {
  const Scratch scratch;
  const std::vector<std::string> what = {"--samples", "3000", "--range", "100:3000", "--best", "2", "--json"};
  const std::string out = scratch.file("rows.csv");
  const Outcome whole = run_command(sweep_of(out, what));
  ASSERT_EQ(whole.status, 0) << whole.err;
  const std::string all = content(out);
  auto expected = whole.json();
  for (const char* key : {"seconds", "why_not"}) expected.erase(key);  // reasons are not in the file
  for (const double share : {0.0, 0.001, 0.2, 0.31, 0.5, 0.77, 0.999, 1.0}) {
    std::ofstream(out, std::ios::binary) << all.substr(
        0, static_cast<std::size_t>(share * static_cast<double>(all.size())));
    const Outcome rest = run_command(sweep_of(out, what));
    ASSERT_EQ(rest.status, 0) << rest.err;
    EXPECT_TRUE(content(out) == all) << share;
    auto json = rest.json();
    for (const char* key : {"seconds", "why_not"}) json.erase(key);
    EXPECT_EQ(json, expected) << share;
  }
  // Another seed, other columns, another range, fewer samples, and a whole file of another seed.
  const std::string half = all.substr(0, all.size() / 2);
  struct Refused {
    std::vector<std::string> more;
    std::string before, text;
  };
  for (const Refused& r : {Refused{{"--range", "100:3000", "--seed", "1"}, half, "has another row for sample"},
                           Refused{{"--range", "100:3000", "--reduce", "max"}, half, "has not the columns"},
                           Refused{{"--range", "0:3000"}, half, "where this sweep has 0"},
                           Refused{{"--range", "100:3000", "--seed", "1"}, all, "has another row for sample"},
                           Refused{{"--range", "100:2999"}, all, "has more than the 2,899 samples"}}) {
    std::ofstream(out, std::ios::binary) << r.before;
    std::vector<std::string> more = {"--samples", "3000"};
    more.insert(more.end(), r.more.begin(), r.more.end());
    const Outcome refused = run_command(sweep_of(out, more));
    EXPECT_EQ(refused.status, 2);
    EXPECT_NE(refused.err.find(r.text), std::string::npos) << refused.err;
    EXPECT_TRUE(content(out) == r.before) << r.text;
  }
}

TEST(Sweep, AnInterruptedSweepKeepsItsRowsAndGoesOn) {
  const Scratch scratch;
  const std::string out = scratch.file("rows.csv"), other = scratch.file("other.csv");
  const std::vector<std::string> what = {"--samples", "3000000"};
  Setting setting;
  setting.interrupt_when_err = "%";
  const Outcome stopped = run_command(sweep_of(out, what), setting);
  if (stopped.status == 0) GTEST_SKIP() << "finished within a second";
  ASSERT_EQ(stopped.status, 130) << stopped.err;
  const auto rows = static_cast<std::int64_t>(cells_of(out).size()) - 1;
  EXPECT_GE(rows, 1024);
  EXPECT_LT(rows, 3000000);
  std::vector<std::string> part = what;
  part.insert(part.end(), {"--range", "0:" + std::to_string(rows)});
  ASSERT_EQ(run_command(sweep_of(other, part)).status, 0);
  EXPECT_TRUE(content(out) == content(other));
}

// The path of B1 of a four-bar with these lengths, at 51 times, by hand.
std::string path_of(double crank, double coupler, double rocker) {
  std::ostringstream text;
  text.precision(17);
  text << "x,y\n";
  for (int k = 0; k <= 50; ++k) {
    const double angle = 2 * 3.14159265358979323846 * 0.02 * k, x = crank * std::cos(angle),
                 y = crank * std::sin(angle);
    const double dx = 2 - x, dy = -y, square = dx * dx + dy * dy;
    const double u = (square + coupler * coupler - rocker * rocker) / (2 * square),
                 v = std::sqrt(coupler * coupler / square - u * u);
    text << x + u * dx - v * dy << ',' << y + u * dy + v * dx << '\n';
  }
  return text.str();
}

TEST(Sweep, ComparesAPathWithACurve) {
  const Scratch scratch;
  const std::string out = scratch.file("rows.csv"), target = scratch.file("target.csv");
  const std::vector<std::string> what = {
      "sweep",     kFourBar,    "--set",     "steps=50",
      "--set",     "step=0.02", "--vary",    "crank_length=0.6:0.8,rocker_length=1.2:1.4",
      "--sampler", "grid",      "--samples", "25",
      "--outputs", "B1",        "--trace",   "B1",
      "--target",  target,      "--best",    "1",
      "--json",    "--out",     out};
  std::ofstream(target) << path_of(0.7, 1.8, 1.3);  // sample 12 of the grid
  for (const std::string distance : {"nearest", "timed", "fitted", "shape"}) {
    std::remove(out.c_str());
    std::vector<std::string> all = what;
    all.insert(all.end(), {"--compare", distance});
    const Outcome outcome = run_command(all);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const auto best = outcome.json()["best"][0];
    EXPECT_EQ(best["sample"], 12) << distance;
    EXPECT_LT(best["figures"]["B1.distance"], 1e-12) << distance;
    const auto rows = cells_of(out);
    EXPECT_EQ(rows[0][5], "B1.distance");
    for (std::size_t k = 1; k < rows.size(); ++k) {
      EXPECT_EQ(rows[k][3], "ok");
      EXPECT_GT(std::stod(rows[k][5]), k == 13 ? -1 : 1e-4) << distance << " " << k;
    }
  }
  std::ofstream(target) << "x,y\n0,0\n1,0\n0,1\n";
  const auto refusal = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = what;
    all.insert(all.end(), more.begin(), more.end());
    std::erase(all, "--json");
    const Outcome outcome = run_command(all);
    EXPECT_EQ(outcome.status, 2);
    return outcome.err;
  };
  EXPECT_NE(refusal({"--compare", "timed"}).find("has 3 points, and the path 51"), std::string::npos);
  EXPECT_NE(refusal({"--compare", "far"}).find("--compare"), std::string::npos);
}

// The slider goes back and forth once a turn, so that it exceeds its limit once or twice, or never.
TEST(Sweep, CountsLimits) {
  const Scratch scratch;
  const std::string out = scratch.file("rows.csv"), scene = scratch.file("limited.json");
  std::string text = content(ASSUR_SOURCE_DIR "/scenes/slider_crank.json");
  text.insert(text.rfind('}'), ", \"limits\": {\"displacement\": {\"max\": 0.38, \"reaction\": \"flag\"}}");
  std::ofstream(scene) << text;
  const Outcome outcome =
      run_command({"sweep", scene, "--vary", "crank_length=0.05:0.1", "--sampler", "grid", "--samples", "6",
                   "--outputs", "displacement", "--reduce", "max", "--json", "--out", out});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto rows = cells_of(out);
  ASSERT_EQ(rows.size(), 7u);
  EXPECT_EQ(rows[0][4], "limits");
  for (std::size_t k = 1; k < rows.size(); ++k) {
    const double reach = std::stod(rows[k][1]) + 0.3;  // the start, and the end of the turn
    EXPECT_EQ(rows[k][4], reach > 0.38 ? "2" : "0") << reach;
  }
}

TEST(Sweep, RefusesWrongOptions) {
  const Scratch scratch;
  const std::string out = scratch.file("rows.csv");
  for (const auto& [more, text] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"--samples", "10", "--vary", "crank_length=1:2"}, "\"crank_length\" is given twice"},
           {{"--samples", "10", "--set", "crank_length=1"}, "\"crank_length\" is varied, too"},
           {{"--samples", "10", "--vary", "foo=1:2"}, "foo"},
           {{"--samples", "10", "--vary", "b"}, "expects a=0.2:0.8"},
           {{"--samples", "10", "--reduce", "median"}, "knows min, max"},
           {{"--samples", "10", "--range", "5:11"}, "0 <= I < J <= 10"},
           {{"--samples", "10", "--sampler", "grid"}, "such as 9 or 16"},
           {{"--samples", "0"}, "samples"},
           {{"--samples", "10", "--outputs", "nothing"}, "nothing"},
           {{"--samples", "10", "--trace", "B1"}, "--target FILE"},
           {{"--samples", "10", "--target", kFourBar}, "--trace POINT"},
           {{"--samples", "10", "--target", kFourBar, "--trace", "Z"}, "\"Z\" is not a point among the outputs"},
           {{"--samples", "10", "--strategy", "groups/lanes:8+chunks=8"}, "chunks"}}) {
    const Outcome outcome = run_command(sweep_of(out, more));
    EXPECT_EQ(outcome.status, 2) << text << ": " << outcome.err;
    EXPECT_NE(outcome.err.find(text), std::string::npos) << outcome.err;
  }
  const Outcome grid = run_command({"sweep", kFourBar, "--vary", "step=0.1:0.2", "--samples", "10", "--out", out});
  EXPECT_EQ(grid.status, 2);
  EXPECT_NE(grid.err.find("time grid"), std::string::npos) << grid.err;
  const Outcome stream = run_command({"sweep", kFourBar, "--vary", "omega=1:2", "--samples", "10", "--out", "-"});
  EXPECT_EQ(stream.status, 2);
  EXPECT_NE(stream.err.find("rows are kept in a file"), std::string::npos) << stream.err;
}

}  // namespace
}  // namespace assur
