#include "output/replace_file.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <sstream>

#include "assur/status.hpp"

namespace assur::output {
namespace {

namespace fs = std::filesystem;

class ReplaceFile : public testing::Test {
 protected:
  ReplaceFile() {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~ReplaceFile() override { fs::remove_all(folder_); }
  [[nodiscard]] std::string content() const {
    std::ostringstream text;
    text << std::ifstream(folder_ / "file").rdbuf();
    return text.str();
  }
  [[nodiscard]] auto files() const { return std::distance(fs::directory_iterator(folder_), fs::directory_iterator()); }

  // Each test has its own folder, because tests run concurrently.
  fs::path folder_ = fs::path(testing::TempDir()) /
                     (std::string("assur_replace_") + testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(ReplaceFile, GivesTheNewContentTheName) {
  replace_file(folder_ / "file", "old");
  EXPECT_EQ(content(), "old");
  std::ifstream reader(folder_ / "file");
  replace_file(folder_ / "file", "new, and longer");
  EXPECT_EQ(content(), "new, and longer");
  // A reader that opened the file before gets the whole old content.
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(reader), {}), "old");
  EXPECT_EQ(files(), 1);
}

TEST_F(ReplaceFile, LeavesNoFileAfterAFailure) {
  fs::create_directories(folder_ / "file/full");  // a folder that is not empty has the name
  EXPECT_THROW(replace_file(folder_ / "file", "new"), Error);
  EXPECT_EQ(files(), 1);
  EXPECT_THROW(replace_file(folder_ / "nowhere/file", "new"), Error);
}

}  // namespace
}  // namespace assur::output
