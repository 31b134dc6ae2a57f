// The whole report with artificial parts: its files after each part, interrupted, and with parts that fail.
#include "report/report.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

namespace assur::report {
namespace {

namespace fs = std::filesystem;

std::string content(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

class MakeReport : public testing::Test {
 protected:
  MakeReport() {
    knowledge_.known.model = std::make_shared<PerformanceModel>();
    const testing::TestInfo* const test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / (std::string("assur_report_") + test->name());
    fs::remove_all(folder_);
    whole_.seconds = 100;
  }
  ~MakeReport() override { fs::remove_all(folder_); }

  Planned part(const std::string& id, double share = 1) {
    return {"Chapter <A>", "Part " + id, share, [this, id](const Conditions& conditions) {
              given_.push_back(conditions.seconds);
              pages_.push_back(content(folder_ / "index.html"));
              Section s{id, "Section " + id, "<p>body of " + id + "</p>"};
              s.measurements.push_back({"thing", "groups/klu", "seconds", "s", 1, "measured", 3, 0, 0});
              return std::vector{s};
            }};
  }
  [[nodiscard]] std::string index() const { return content(folder_ / "index.html"); }

  Knowledge knowledge_;
  fs::path folder_;
  Conditions whole_;
  std::vector<double> given_;       // s, the time given to each part
  std::vector<std::string> pages_;  // the page as each part found it
};

TEST_F(MakeReport, WritesThreeFilesAndLeavesNothingElse) {
  const Outcome outcome = make_report(folder_ / "new", {part("one"), part("two")}, knowledge_, whole_);
  EXPECT_FALSE(outcome.interrupted);
  EXPECT_TRUE(outcome.failures.empty());
  ASSERT_EQ(outcome.files.size(), 3u);
  for (const fs::path& file : outcome.files) EXPECT_TRUE(fs::exists(file)) << file;
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "new"), fs::directory_iterator()), 3);
  const std::string page = content(folder_ / "new/index.html");
  EXPECT_TRUE(has(page, "<h2>Chapter &lt;A&gt;</h2>"));
  EXPECT_EQ(page.find("<h2>Chapter"), page.rfind("<h2>Chapter"));
  for (const char* id : {"one", "two"}) {
    EXPECT_TRUE(has(page, std::string("<a href=\"#") + id + "\">Section " + id));
    EXPECT_TRUE(has(page, std::string("<section id=\"") + id + "\">"));
    EXPECT_TRUE(has(page, std::string("body of ") + id));
  }
  EXPECT_FALSE(has(page, "not made"));
  EXPECT_TRUE(has(page, "Made in "));
}

TEST_F(MakeReport, IsCompleteAfterEachPart) {
  (void)make_report(folder_, {part("one"), part("two")}, knowledge_, whole_);
  ASSERT_EQ(pages_.size(), 2u);
  EXPECT_TRUE(has(pages_[0], "Part one: not made yet"));
  EXPECT_TRUE(has(pages_[1], "body of one"));
  EXPECT_TRUE(has(pages_[1], "Part two: not made yet"));
  EXPECT_TRUE(has(pages_[1], "Not finished"));
  EXPECT_TRUE(has(pages_[1], "</html>"));
}

TEST_F(MakeReport, SharesTheTime) {
  (void)make_report(folder_, {part("one", 1), part("two", 2), part("three", 1)}, knowledge_, whole_);
  // The test itself takes far less than a second for parts and files.
  ASSERT_EQ(given_.size(), 3u);
  EXPECT_NEAR(given_[0], 25, 1);
  EXPECT_NEAR(given_[1], 100.0 * 2 / 3, 1);
  EXPECT_NEAR(given_[2], 100, 1);
}

TEST_F(MakeReport, KeepsFinishedPartsAndNamesMissingOnesIfInterrupted) {
  bool stop = false;
  whole_.interrupted = [&] { return stop; };
  Planned second = part("two");
  second.make = [&, make = second.make](const Conditions& c) {
    stop = true;
    return make(c);
  };
  const Outcome outcome = make_report(folder_, {part("one"), second, part("three")}, knowledge_, whole_);
  EXPECT_TRUE(outcome.interrupted);
  EXPECT_EQ(given_.size(), 2u);
  const std::string page = index();
  EXPECT_TRUE(has(page, "Interrupted after"));
  EXPECT_TRUE(has(page, "body of one"));
  EXPECT_TRUE(has(page, "body of two"));
  EXPECT_TRUE(has(page, "Part two: interrupted: incomplete"));
  EXPECT_TRUE(has(page, "Part three: not made, because the report was interrupted"));
  EXPECT_TRUE(has(page, "<li class=\"faint\">Part three: missing</li>"));
  EXPECT_TRUE(has(content(folder_ / "report.csv"), "\"two\""));
}

TEST_F(MakeReport, AFailedPartIsReportedOnThePage) {
  Planned broken = part("broken");
  broken.make = [](const Conditions&) -> std::vector<Section> {
    throw Error(Error::Kind::numerical, "it broke <here>");
  };
  const Outcome outcome = make_report(folder_, {broken, part("two")}, knowledge_, whole_);
  ASSERT_EQ(outcome.failures.size(), 1u);
  EXPECT_EQ(outcome.failures[0], "Part broken: it broke <here>");
  EXPECT_TRUE(has(index(), "Part broken: could not be made: it broke &lt;here&gt;"));
  EXPECT_TRUE(has(index(), "body of two"));
}

TEST_F(MakeReport, AnUnwritableFolderIsAnEnvironmentError) {
  fs::create_directories(folder_);
  std::ofstream(folder_ / "file") << "a file";
  try {
    (void)make_report(folder_ / "file", {part("one")}, knowledge_, whole_);
    FAIL() << "a file was taken for a folder";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::environment);
  }
  EXPECT_TRUE(given_.empty()) << "the work was done before it was known to be in vain";
}

TEST_F(MakeReport, PageExplainsHowToTuneWithoutSamples) {
  (void)make_report(folder_, {part("one")}, knowledge_, whole_);
  EXPECT_TRUE(has(index(), "There are no samples of this machine yet"));
  EXPECT_TRUE(has(index(), "assur tune"));
}

}  // namespace
}  // namespace assur::report
