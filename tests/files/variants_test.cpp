#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "assur/scene.hpp"

namespace assur {
namespace {

class Variants : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::vector<Parameters> read(const std::string& text) const {
    std::ofstream(folder_ / "v.csv", std::ios::binary) << text;
    return read_variants(folder_ / "v.csv");
  }

  // The message for the file, without the name of the file.
  [[nodiscard]] std::string refusal(const std::string& text) const {
    try {
      (void)read(text);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), Error::Kind::input);
      std::string what = error.what();
      const std::string name = (folder_ / "v.csv").string() + ": ";
      for (std::size_t at = 0; (at = what.find(name, at)) != std::string::npos;) what.erase(at, name.size());
      return what;
    }
    return "accepted";
  }

  std::filesystem::path folder_;
};

TEST_F(Variants, HaveOneSetOfParametersForEachRow) {
  EXPECT_EQ(read("crank,offset\n1,0\n+0.5,-2e-3\n"),
            (std::vector<Parameters>{{{"crank", 1}, {"offset", 0}}, {{"crank", 0.5}, {"offset", -0.002}}}));
  EXPECT_EQ(read("a\n7"), (std::vector<Parameters>{{{"a", 7}}}));
}

TEST_F(Variants, IgnoreSpacesWindowsLineEndsAndTrailingBlankLines) {
  const std::vector<Parameters> expected{{{"a", 1}, {"b", 2}}, {{"a", 3}, {"b", 4}}};
  EXPECT_EQ(read(" a , b \n 1 ,\t2\n3,4\n"), expected);
  EXPECT_EQ(read("a,b\r\n1,2\r\n3,4\r\n\r\n"), expected);
  EXPECT_EQ(read("\xEF\xBB\xBF"
                 "a,b\n1,2\n3,4\n  \n\n"),
            expected);
}

TEST_F(Variants, ReadNumbersExactly) {
  EXPECT_EQ(read("a\n0.1\n0.30000000000000004\n5e-324\n"),
            (std::vector<Parameters>{{{"a", 0.1}}, {{"a", 0.1 + 0.2}}, {{"a", 5e-324}}}));
}

TEST_F(Variants, ReportErrorsWithLineAndColumn) {
  EXPECT_EQ(refusal("a,b\n1,2\n3,fast\n"), "line 3, column 2 (b): 'fast' is not a finite number");
  EXPECT_EQ(refusal("a,b\n,2\n"), "line 2, column 1 (a): a number is missing");
  EXPECT_EQ(refusal("a,b\n1,2,3\n4\n"), "line 2: 3 values, but 2 columns\nline 3: 1 value, but 2 columns");
  EXPECT_EQ(refusal("a,b\n1,2\n1,2,\n"), "line 3: 3 values, but 2 columns");
  for (const std::string number : {"inf", "nan", "1e999", "1x", "0x10", "1 2", "--1", "#1"}) {
    EXPECT_EQ(refusal("a\n" + number + "\n"), "line 2, column 1 (a): '" + number + "' is not a finite number");
  }
}

TEST_F(Variants, TheFirstLineHasNames) {
  const std::string hint =
      " is not the name of a parameter; the first line names one for each column, separated by commas";
  EXPECT_EQ(refusal("1,2\n3,4\n"), "line 1, column 1: '1'" + hint + "\nline 1, column 2: '2'" + hint);
  EXPECT_EQ(refusal("a;b\n1;2\n"),
            "line 1, column 1: 'a;b'" + hint + "\nline 2, column 1 (a;b): '1;2' is not a finite number");
  EXPECT_EQ(refusal("# speeds\na\n1\n").substr(0, 30), "line 1, column 1: '# speeds' i");
  EXPECT_EQ(refusal("a,,b\n1,2,3\n"), "line 1, column 2: a name is missing");
  EXPECT_EQ(refusal("a,b,a\n1,2,3\n"), "line 1, column 3: 'a' names a column already");
}

TEST_F(Variants, AFileWithoutRowsIsRefused) {
  const std::string empty = "the file is empty; its first line names parameters, each further line has their values";
  EXPECT_EQ(refusal(""), empty);
  EXPECT_EQ(refusal("\r\n \n"), empty);
  EXPECT_EQ(refusal("a,b\n"), "the file names 2 parameters but has no line of values");
}

TEST_F(Variants, ABlankLineBetweenRowsIsRefused) {
  EXPECT_EQ(refusal("a\n1\n\n2\n"), "line 3: the line is blank; blank lines are allowed only at the end of the file");
  EXPECT_EQ(refusal("\na\n1\n"), "line 1: the line is blank; blank lines are allowed only at the end of the file");
}

TEST_F(Variants, StopReadingAFileThatIsNoTable) {
  std::string text = "a,b\n";
  for (int i = 0; i < 100'000; ++i) text += "x\n";
  const std::string what = refusal(text);
  EXPECT_EQ(std::count(what.begin(), what.end(), '\n'), 19) << what;
}

// The number of findings in one line is limited, too. Comparing the names of a line takes time in proportion to their
// number.
TEST_F(Variants, ReadLongLines) {
  std::string names = "a0", numbers = "0", none = "1";
  for (int i = 1; i < 1'000'000; ++i) {
    names += ",a" + std::to_string(i);
    numbers += ",0";
    none += ",1";
  }
  const std::vector<Parameters> variants = read(names + "\n" + numbers + "\n");
  ASSERT_EQ(variants.size(), 1u);
  EXPECT_EQ(variants.front().size(), 1'000'000u);
  for (const std::string& text : {none + "\n", names + "\nx" + std::string(999'999, ',') + "\n"}) {
    const std::string what = refusal(text);
    EXPECT_EQ(std::count(what.begin(), what.end(), '\n'), 19) << what.substr(0, 1000);
  }
}

TEST_F(Variants, AnUnreadableFileIsAnEnvironmentError) {
  for (const auto& [path, why] : {std::pair(folder_ / "none.csv", "no such file or directory"),
                                  std::pair(folder_, "it is a folder; only regular files are read")}) {
    try {
      (void)read_variants(path);
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), Error::Kind::environment);
      EXPECT_EQ(error.what(), path.string() + ": the file of variants cannot be read: " + why);
    }
  }
}

}  // namespace
}  // namespace assur
