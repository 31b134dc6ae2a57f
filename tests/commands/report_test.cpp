// `assur report` with a budget of seconds: its files, whether they agree, and Ctrl-C.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <sstream>

#include "commands/command.hpp"

namespace assur {
namespace {

const std::vector<std::string> kSections = {"winners", "regret",      "work-precision", "scaling",
                                            "steps",   "tuning-cost", "model-fit"};

// Rows of a CSV with quoted texts.
std::vector<std::map<std::string, std::string>> rows_of(const std::string& file) {
  std::istringstream in(content(file));
  const auto cells = [](const std::string& line) {
    std::vector<std::string> out(1);
    bool quoted = false;
    for (const char c : line) {
      if (c == '"') {
        quoted = !quoted;
      } else if (c == ',' && !quoted) {
        out.emplace_back();
      } else {
        out.back() += c;
      }
    }
    return out;
  };
  std::string line;
  std::getline(in, line);
  const std::vector<std::string> titles = cells(line);
  std::vector<std::map<std::string, std::string>> rows;
  while (std::getline(in, line)) {
    const std::vector<std::string> values = cells(line);
    EXPECT_EQ(values.size(), titles.size()) << line;
    for (std::size_t i = 0; i < std::min(values.size(), titles.size()); ++i) {
      if (i == 0) rows.emplace_back();
      rows.back()[titles[i]] = values[i];
    }
  }
  return rows;
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(ReportCommand, WritesPageCsvAndJsonWithTheSameNumbers) {
  const Scratch scratch;
  const std::string folder = scratch.file("deep/folder");
  const Outcome o = run_command({"report", "--quick", "--budget", "4", "--out", folder, "--json", "--quiet"});
  ASSERT_EQ(o.status, 0) << o.err << o.out;
  EXPECT_EQ(o.err, "");
  const auto json = o.json();
  ASSERT_EQ(json["files"].size(), 3u);
  for (const std::string file : json["files"]) EXPECT_TRUE(std::filesystem::exists(file)) << file;
  EXPECT_EQ(json["interrupted"], false);

  const std::string page = content(folder + "/index.html");
  for (const std::string& id : kSections) EXPECT_TRUE(has(page, "<section id=\"" + id + "\">")) << id;
  EXPECT_FALSE(has(page, "not made"));
  EXPECT_TRUE(has(page, "There are no samples of this machine yet")) << "tests run without a tuning database";
  for (const char* word : {"http://", "https://", "<script"}) {
    // The namespace of SVG looks like an address, but is not loaded.
    std::string rest = page;
    for (std::size_t at; (at = rest.find("http://www.w3.org/2000/svg")) != std::string::npos;) rest.erase(at, 26);
    EXPECT_FALSE(has(rest, word)) << word;
  }

  const bool has_reference =
      run_command({"run", "four_bar", "--steps", "2", "--quiet", "--reference", "--errors", scratch.file("errors.csv")})
          .status == 0;
  const auto rows = rows_of(folder + "/report.csv");
  ASSERT_EQ(nlohmann::json::parse(content(folder + "/report.json"))["benchmarks"].size(), rows.size());
  std::map<std::string, std::map<std::string, double>> regret;   // by question and quantity
  std::map<std::string, std::map<std::string, double>> seconds;  // per step, by scaled item and strategy
  int speed_ups = 0;
  for (const auto& row : rows) {
    const double value = std::stod(row.at("value"));
    EXPECT_NE(row.at("origin"), "");
    if (row.at("origin") == "measured") {
      EXPECT_GT(std::stoi(row.at("repetitions")), 0) << row.at("item");
      EXPECT_NE(row.at("strategy"), "");
      EXPECT_TRUE(row.at("error") != "" || !has_reference) << row.at("item");
    }
    if (row.at("section") == "regret" && row.at("strategy") != "best constant")
      regret[row.at("item")][row.at("quantity")] = value;
    if (row.at("section") != "scaling") continue;
    if (row.at("quantity") == "seconds per step") {
      EXPECT_TRUE(seconds[row.at("item")].emplace(row.at("strategy"), value).second) << row.at("item");
    } else if (row.at("quantity") == "speed-up") {
      ++speed_ups;
      // A speed-up is relative to one thread or one lane.
      const auto& of = seconds.at(row.at("item"));
      const double own = of.at(row.at("strategy"));
      EXPECT_TRUE(std::any_of(of.begin(), of.end(), [&](const auto& other) { return other.second / own == value; }))
          << row.at("item") << ' ' << row.at("strategy") << ": no time over its own is " << value;
    }
  }
  EXPECT_GT(speed_ups, 5);
  auto all = regret.extract("all questions");
  ASSERT_FALSE(regret.empty());
  std::vector<double> regrets;
  for (auto& [question, of] : regret) {
    EXPECT_DOUBLE_EQ(of["regret"], of["seconds per step, auto"] / of["seconds per step, fastest"] - 1) << question;
    regrets.push_back(of["regret"]);
  }
  std::sort(regrets.begin(), regrets.end());
  EXPECT_EQ(all.mapped().at("regret, median"), regrets[(regrets.size() + 1) / 2 - 1]);
  EXPECT_EQ(all.mapped().at("regret, max"), regrets.back());
}

TEST(ReportCommand, KeepsFinishedPartsIfInterrupted) {
  const Scratch scratch;
  Setting setting;
  setting.interrupt_when_err = "of 60 seconds";  // the first line of progress, after a second
  const Outcome o =
      run_command({"report", "--quick", "--budget", "60", "--out", scratch.file("report"), "--json"}, setting);
  EXPECT_EQ(o.status, 130);
  ASSERT_TRUE(o.json()["interrupted"]);
  const std::string page = content(scratch.file("report") + "/index.html");
  EXPECT_TRUE(has(page, "Interrupted after"));
  EXPECT_TRUE(has(page, "<section id=\"winners\">"));
  EXPECT_TRUE(has(page, "Accuracy of predicted times: not made, because the report was interrupted"));
  EXPECT_TRUE(has(page, "</html>"));
  EXPECT_GT(rows_of(scratch.file("report") + "/report.csv").size(), 50u);
}

TEST(ReportCommand, ShowsTheSamplesOfATuningRun) {
  const Scratch scratch;
  const std::string db = scratch.file("tuning.db");
  ASSERT_EQ(run_tuning(2, {"--db", db, "--quiet"}).status, 0);
  const Outcome o =
      run_command({"report", "--quick", "--budget", "1", "--out", scratch.file("r"), "--db", db, "--quiet"});
  ASSERT_EQ(o.status, 0) << o.err;
  const std::string page = content(scratch.file("r") + "/index.html");
  EXPECT_TRUE(has(page, db + ": run 1 (quick)"));
  EXPECT_FALSE(has(page, "no samples of this machine"));
}

TEST(ReportCommand, ReportsBadUsageAtOnce) {
  EXPECT_EQ(run_command({"report", "--budget", "0"}).status, 2);
  EXPECT_EQ(run_command({"report", "--out", ""}).status, 2);
  EXPECT_EQ(run_command({"report", "stewart"}).status, 2);
  const Scratch scratch;
  const std::string file = scratch.file("file", "not a folder");
  EXPECT_EQ(run_command({"report", "--out", file}).status, 3);
  EXPECT_EQ(run_command({"report", "--out", scratch.file("r"), "--peers", file}).status, 2);
  EXPECT_FALSE(std::filesystem::exists(scratch.file("r")));
  EXPECT_EQ(run_command({"report", "--out", scratch.file("r"), "--db", scratch.file("none.db")}).status, 3);
}

}  // namespace
}  // namespace assur
