// Every file of tests/data/bad_scenes is refused with exactly the lines of the .expected file beside it.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "assur/scene.hpp"

namespace assur {
namespace {

const std::filesystem::path kFolder = std::filesystem::path(ASSUR_SOURCE_DIR) / "tests/data/bad_scenes";

std::string content(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::vector<std::string> scenes() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(kFolder)) {
    if (entry.path().extension() == ".json") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

class BadScene : public testing::TestWithParam<std::string> {};

TEST_P(BadScene, IsRefusedWithTheExpectedLines) {
  std::filesystem::current_path(kFolder);  // messages name the file as it was asked for
  ASSERT_TRUE(std::filesystem::exists(GetParam() + ".expected"));
  try {
    (void)read_scene(GetParam() + ".json");
    FAIL() << "was read without a complaint";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::input);
    EXPECT_EQ(std::string(error.what()) + "\n", content(GetParam() + ".expected"));
  }
}

INSTANTIATE_TEST_SUITE_P(Folder, BadScene, testing::ValuesIn(scenes()), [](const auto& test) { return test.param; });

TEST(BadScenes, AreEnough) { EXPECT_GE(scenes().size(), 60u); }

TEST(BadScenes, EveryExpectationHasItsScene) {
  for (const auto& entry : std::filesystem::directory_iterator(kFolder)) {
    if (entry.path().extension() != ".expected") continue;
    EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(entry.path()).replace_extension(".json")))
        << entry.path();
  }
}

}  // namespace
}  // namespace assur
