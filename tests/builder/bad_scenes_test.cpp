// Every file of tests/data/bad_scenes is refused with exactly the lines of the .expected file beside it.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "assur/scene.hpp"
#include "builder/bad_scenes.hpp"

namespace assur {
namespace {

using bad_scenes::kFolder;

class BadScene : public testing::TestWithParam<std::string> {};

TEST_P(BadScene, IsRefusedWithTheExpectedLines) {
  std::filesystem::current_path(kFolder);  // messages name the file as the caller does
  ASSERT_TRUE(std::filesystem::exists(GetParam() + ".expected"));
  try {
    (void)read_scene(GetParam() + ".json");
    FAIL() << "was read without a complaint";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::input);
    EXPECT_EQ(std::string(error.what()) + "\n", bad_scenes::expected(GetParam()));
  }
}

INSTANTIATE_TEST_SUITE_P(Folder, BadScene, testing::ValuesIn(bad_scenes::names()),
                         [](const auto& test) { return test.param; });

TEST(BadScenes, CoverEnoughErrors) { EXPECT_GE(bad_scenes::names().size(), 60u); }

TEST(BadScenes, EveryExpectationHasItsScene) {
  for (const auto& entry : std::filesystem::directory_iterator(kFolder)) {
    if (entry.path().extension() != ".expected") continue;
    EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(entry.path()).replace_extension(".json")))
        << entry.path();
  }
}

}  // namespace
}  // namespace assur
