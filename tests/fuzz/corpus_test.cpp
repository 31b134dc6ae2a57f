// The fuzzed readers accept or refuse every kept input, without any other fault. Some inputs must be accepted, so that
// the code behind the first check is tested as well.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "fuzz/targets.hpp"
#include "source_dir.hpp"

namespace assur::fuzz {
namespace {

namespace fs = std::filesystem;

struct Target {
  const char* name;
  bool (*accepts)(std::string_view bytes);
};

class Corpus : public testing::TestWithParam<Target> {};

TEST_P(Corpus, IsReadOrRefused) {
  if (GetParam().accepts == model && !ASSUR_READS_MODELS) GTEST_SKIP() << "this build has no tinyxml2";
  int files = 0, accepted = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(ASSUR_SOURCE_DIR "/tests/fuzz/corpus") / GetParam().name)) {
    SCOPED_TRACE(entry.path());
    std::ifstream stream(entry.path(), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    EXPECT_NO_THROW(accepted += GetParam().accepts(bytes));
    ++files;
  }
  EXPECT_GT(accepted, 0) << "none is accepted: has the format changed? Then write its good files anew";
  EXPECT_LT(accepted, files);
}

INSTANTIATE_TEST_SUITE_P(Of, Corpus,
                         testing::Values(Target{"scene", scene}, Target{"model", model}, Target{"strategy", strategy},
                                         Target{"plan", plan}, Target{"table", table}, Target{"variants", variants},
                                         Target{"database", database}),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace assur::fuzz
