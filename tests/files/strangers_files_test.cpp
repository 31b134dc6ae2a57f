// Files of unknown origin: pipes, devices, huge files, tables outside the folder, and very long texts.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include "assur/saved_plan.hpp"
#include "assur/scene.hpp"
#include "files/input_file.hpp"
#include "scene/names.hpp"

namespace assur {
namespace {

namespace fs = std::filesystem;

class StrangersFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "scene/below");
    fs::create_directories(folder_ / "data");
    std::ofstream(folder_ / "data/secret.csv") << "the first line\nof a file\n";
    std::ofstream(folder_ / "data/good.csv") << "0,0\n1,1\n";
    ASSERT_EQ(::mkfifo((folder_ / "scene/pipe").c_str(), 0600), 0);
  }
  void TearDown() override { fs::remove_all(folder_); }

  // Makes a sparse file of this size.
  [[nodiscard]] fs::path huge(const std::string& name, std::uintmax_t bytes) const {
    const fs::path file = folder_ / "scene" / name;
    std::ofstream(file).flush();
    fs::resize_file(file, bytes);
    return file;
  }

  [[nodiscard]] fs::path with_table(const std::string& table) const {
    const fs::path file = folder_ / "scene/scene.json";
    std::ofstream(file) << R"({"assur": 1, "dimension": 2, "points": {"A": {"at": [0, 0]}}, "drivers":
      {"push": {"coordinate": "A.x", "law": {"table": ")"
                        << table << R"("}}, "lift": {"coordinate": "A.y", "law": {"constant": 0}}}})";
    return file;
  }

  // The message for a scene with this table, from the path of the driver on.
  [[nodiscard]] std::string of_table(const std::string& table) const {
    const std::string said = refusal([&] { (void)read_scene(with_table(table)); });
    const std::size_t at = said.find("/drivers");
    return at == std::string::npos ? said : said.substr(at);
  }

  [[nodiscard]] static std::string refusal(const std::function<void()>& read) {
    try {
      read();
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  }

  fs::path folder_;
};

TEST_F(StrangersFiles, ReadsOnlyRegularFilesAsScenes) {
  const auto why_not = [](const fs::path& file) {
    const std::string said = refusal([&] { (void)open_scene(file.string()); });
    const std::string begin = file.string() + ": the scene file cannot be read: ";
    return said.starts_with(begin) ? said.substr(begin.size()) : said;
  };
  EXPECT_EQ(why_not(folder_ / "scene/pipe"), "it is a pipe; only regular files are read");
  EXPECT_EQ(why_not("/dev/zero"), "it is a device; only regular files are read");
  EXPECT_EQ(why_not(folder_), "it is a folder; only regular files are read");
  EXPECT_EQ(why_not(huge("scene.json", kLargestScene + 1)), "it is larger than 1000 MB, the limit");
}

TEST_F(StrangersFiles, ReadsOnlyRegularFilesAsVariants) {
  const fs::path pipe = folder_ / "scene/pipe", large = huge("v.csv", kLargestTable + 1);
  EXPECT_EQ(refusal([&] { (void)read_variants(pipe); }),
            pipe.string() + ": the file of variants cannot be read: it is a pipe; only regular files are read");
  EXPECT_EQ(refusal([&] { (void)read_variants(large); }),
            large.string() + ": the file of variants cannot be read: it is larger than 256 MB, the limit");
}

TEST_F(StrangersFiles, ReadsOnlyRegularFilesAsTables) {
  EXPECT_EQ(of_table("pipe"),
            "/drivers/push/law/table: the file 'pipe' cannot be read: it is a pipe; only regular files are read; "
            "its path is relative to the scene file");
  (void)huge("large.csv", kLargestTable + 1);
  EXPECT_EQ(of_table("large.csv"),
            "/drivers/push/law/table: the file 'large.csv' cannot be read: it is larger than 256 MB, the "
            "limit; its path is relative to the scene file");
}

TEST_F(StrangersFiles, LimitsTheSizeOfAFile) {
  const fs::path file = folder_ / "data/good.csv";  // 8 bytes
  EXPECT_EQ(read_input(file, 8).text, "0,0\n1,1\n");
  EXPECT_EQ(read_input(file, 7).text, "");
  EXPECT_NE(read_input(file, 7).why_not, "");
  if (!fs::exists("/proc/self/status")) return;  // a regular file without a size
  EXPECT_EQ(read_input("/proc/self/status", 1'000'000).why_not, "");
  EXPECT_NE(read_input("/proc/self/status", 1'000'000).text, "");
  EXPECT_NE(read_input("/proc/self/status", 100).why_not, "");
}

TEST_F(StrangersFiles, ReadsTablesOnlyInTheFolderOfTheScene) {
  fs::copy_file(folder_ / "data/good.csv", folder_ / "scene/below/good.csv");
  EXPECT_EQ(of_table("below/good.csv"), "accepted");
  EXPECT_EQ(of_table("./below/../below/good.csv"), "accepted");
  fs::create_symlink(folder_ / "data/secret.csv", folder_ / "scene/link.csv");
  fs::create_symlink(folder_ / "data", folder_ / "scene/out");
  for (const std::string& table :
       {std::string("../data/secret.csv"), std::string("../data/none.csv"), std::string("below/../../data/good.csv"),
        (folder_ / "data/secret.csv").string(), std::string("/dev/zero"), std::string("/etc/passwd"),
        std::string("link.csv"), std::string("out/secret.csv"), std::string("../scene2/x.csv")}) {
    EXPECT_EQ(of_table(table), "/drivers/push/law/table: the file " + in_quotes(table) +
                                   " is outside the folder of the scene; tables are read only from there, or from "
                                   "folders that you allow (--tables FOLDER)");
  }
}

TEST_F(StrangersFiles, TheCallerMayAllowMoreFolders) {
  const auto read = [&](const std::string& table, const std::vector<fs::path>& more) {
    return refusal([&] { (void)read_scene(with_table(table), {}, more); });
  };
  EXPECT_EQ(read("../data/good.csv", {folder_ / "none", folder_ / "data/"}), "accepted");
  EXPECT_EQ(read((folder_ / "data/good.csv").string(), {"/"}), "accepted");
  EXPECT_NE(read("../data/good.csv", {folder_ / "dat"}).find("is outside the folder"), std::string::npos);
  EXPECT_NE(read("../data/good.csv", {folder_ / "scene"}).find("is outside the folder"), std::string::npos);
}

TEST_F(StrangersFiles, ShortensQuotationsWithoutControlCharacters) {
  EXPECT_EQ(excerpt(std::string(140, 'x')), std::string(140, 'x'));
  EXPECT_EQ(excerpt(std::string(141, 'x')), std::string(100, 'x') + "... (141 characters)");
  EXPECT_EQ(excerpt("a\nb\tc\x1b[2J\x7f"
                    "d"),
            "a\\nb\\tc\\x1b[2J\\x7f"
            "d");
  EXPECT_EQ(excerpt("\xc2\x9b"
                    "2J \xc3\xa9 \xc2\xb5"),
            "\\x9b"
            "2J \xc3\xa9 \xc2\xb5");  // U+009B, e acute, micro
  const std::string accents = [] {
    std::string text = "x";
    while (text.size() < 200) text += "\xc3\xa9";
    return text;
  }();
  EXPECT_EQ(excerpt(accents), accents.substr(0, 99) + "... (201 characters)");  // byte 100 is within a character
  std::string escapes;
  while (escapes.size() < 100) escapes += "\\xa5";
  EXPECT_EQ(excerpt(std::string(200, '\xa5')), escapes + "... (200 characters)");
}

// An excerpt is UTF-8 whatever the text is, and its own excerpt: names of scenes are read and written as excerpts.
TEST_F(StrangersFiles, AnExcerptIsItsOwnExcerpt) {
  const std::string euro = "\xe2\x82\xac", clef = "\xf0\x9d\x84\x9e";  // of three and of four bytes
  EXPECT_EQ(excerpt(euro + clef), euro + clef);
  EXPECT_EQ(excerpt(euro.substr(0, 2) + clef.substr(0, 3)), "\\xe2\\x82\\xf0\\x9d\\x84");
  EXPECT_EQ(excerpt("\xc0\xaf \xe0\x80\xaf \xed\xa0\x80 \xf4\x90\x80\x80"),
            "\\xc0\\xaf \\xe0\\x80\\xaf \\xed\\xa0\\x80 \\xf4\\x90\\x80\\x80");  // too long, a half, too large
  for (const std::string& unit : {std::string("x"), std::string("\n"), std::string("\x1b"), std::string("\xe2"), euro,
                                  clef, std::string("x\xe2\x82"), std::string("\xc2\x9b")}) {
    for (const int count : {1, 30, 47, 100, 120, 121, 140, 141, 1000, 100'000}) {
      std::string text;
      for (int i = 0; i < count; ++i) text += unit;
      const std::string once = excerpt(text);
      EXPECT_LE(once.size(), 140u);
      EXPECT_EQ(excerpt(once), once);
    }
  }
}

TEST_F(StrangersFiles, MessagesDoNotGrowWithTheInput) {
  std::string sum = "=1";
  while (sum.size() < 10'000) sum += "+1";
  sum += "+";
  const std::string long_name(500'000, 'n');
  const auto said = [](const std::string& rest) {
    return refusal([&] { (void)parse_scene(R"({"assur": 1, "dimension": 2, )" + rest + "}"); });
  };
  const std::string cut = long_name.substr(0, 100) + "... (500000 characters)";
  EXPECT_EQ(said(R"("time": {"start": 0, "end": ")" + sum + R"(", "step": 1})"),
            "scene: /time/end: '" + sum.substr(0, 100) +
                "... (10001 characters)' cannot be read: unexpected end of expression");
  EXPECT_EQ(said(R"("parameters": {"a": "=)" + long_name.substr(0, 10'000) + R"("})"),
            "scene: /parameters/a: there is no parameter '" + long_name.substr(0, 100) + "... (10000 characters)'");
  EXPECT_EQ(said(R"("points": {")" + long_name + R"(": {"at": [0, 0]}})"),
            "scene: /points/" + long_name.substr(0, 99) + "... (500001 characters): '" + cut +
                "' is too long for a name: 255 characters at most");
  EXPECT_EQ(said(R"("outputs": [")" + long_name + R"("])"),
            "scene: /outputs/0: there is no point, vector or measure '" + cut + "'");
  for (std::string rest :
       {R"("x": 1, "@": 1)", R"("name": ["@"])", R"("points": {"A": {"at": ["@", 0]}})",
        R"("points": {"A": {"at": [0, 0], "@": 0}})", R"("bodies": {"b": {"origin": "@"}})",
        R"("constraints": {"c": {"@": 0}})", R"("constraints": {"c": {"coordinate": "@", "value": 0}})",
        R"("drivers": {"d": {"coordinate": "A.x", "law": {"table": "@"}}})",
        R"("drivers": {"d": {"coordinate": "A.x", "law": {"@": 1}}})", R"("measures": {"m": {"distance": ["A", "@"]}})",
        R"("groups": {"g": {"unknowns": ["@"]}})", R"("parameters": {"a": "=@"})", R"x("parameters": {"a": "=@(1)"})x",
        R"("parameters": {"a": "=1 @"})", R"("parameters": {"a": "=\"@\""})", R"("time": {"@": "@)"}) {
    for (std::size_t at = 0; (at = rest.find('@', at)) != std::string::npos; at += long_name.size()) {
      rest.replace(at, 1, long_name);
    }
    const std::string what = said(rest);
    EXPECT_NE(what, "accepted");
    EXPECT_LT(what.size(), 1000u) << what.substr(0, 1000);
  }
  EXPECT_LT(parse_scene(R"({"assur": 1, "dimension": 2, "points": {}, "name": ")" + long_name + "\"}").name().size(),
            150u);
  EXPECT_EQ(parse_scene(R"({"assur": 1, "dimension": 2, "points": {}, "name": "a\u001b[2Jb\nc"})").name(),
            "a\\x1b[2Jb\\nc");
}

TEST_F(StrangersFiles, LimitsTheNumberOfFindings) {
  std::string points;
  for (int i = 0; i < 3000; ++i) points += (i == 0 ? "\"P" : ", \"P") + std::to_string(i) + "\": {}";
  const std::string said =
      refusal([&] { (void)parse_scene(R"({"assur": 1, "dimension": 2, "points": {)" + points + "}}"); });
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1000);
  EXPECT_TRUE(said.ends_with("\nscene: and 2000 more findings")) << said.substr(said.size() - 100);
}

TEST_F(StrangersFiles, ShortensACycleOfManyParameters) {
  std::string parameters;
  for (int i = 0; i < 100; ++i) {
    parameters += (i == 0 ? "\"p" : ", \"p") + std::to_string(i) + "\": \"=p" + std::to_string((i + 1) % 100) + "\"";
  }
  EXPECT_EQ(refusal([&] { (void)parse_scene(R"({"assur": 1, "dimension": 2, "parameters": {)" + parameters + "}}"); }),
            "scene: /parameters/p0: parameters define each other in a circle: p0 -> p1 -> p2 -> p3 -> p4 -> p5 -> p6 "
            "-> p7 -> p8 -> p9 -> (90 more) -> p0");
}

// Items with commas between them: `item` with each @ replaced by a number.
std::string many(int count, const std::string& item) {
  std::string text;
  for (int i = 0; i < count; ++i) {
    text += i == 0 ? "" : ", ";
    for (const char c : item) c == '@' ? text += std::to_string(i) : text += c;
  }
  return text;
}

// Each of these files of a few MB would take from ten minutes to many hours, if time grew with the square of its size.
TEST_F(StrangersFiles, ReadsFilesInTimeThatGrowsWithTheirSize) {
  const auto said = [](const std::string& rest) {
    return refusal([&] { (void)parse_scene(R"({"assur": 1, "dimension": 2, )" + rest + "}"); });
  };
  EXPECT_EQ(said(R"("points": {"A": {"at": [0, 0]}}, "drivers": {"push": {"coordinate": "A.x", "law": [)" +
                 many(50'000, R"({"constant": 1})") + R"(]}, "lift": {"coordinate": "A.y", "law": {"constant": 0}}})"),
            "accepted");
  const std::string a(2'000'000, 'a'), b(2'000'000, 'b');
  EXPECT_NE(said(R"("points": {")" + a + R"(": {"at": [0, 0]}}, "outputs": [")" + b + R"("])").find("too long"),
            std::string::npos);
  const std::string unknown =
      said(R"("parameters": {)" + many(10'000, R"("a_parameter_with_a_name_@": 1)") + R"(}, "points": {)" +
           many(10'000, R"("P@": {"at": ["=b_parameter_with_a_name_@", 0]})") + "}");
  EXPECT_EQ(unknown.substr(0, unknown.find('\n')),
            "scene: /points/P0/at/0: there is no parameter 'b_parameter_with_a_name_0'; did you mean "
            "'a_parameter_with_a_name_0'?");
  EXPECT_TRUE(unknown.ends_with("scene: and 9000 more findings"));
  EXPECT_TRUE(said(R"("points": {}, )" + many(80'000, R"("key_@": 1)")).ends_with("and 79000 more findings"));
}

TEST_F(StrangersFiles, RefusesSumsOfTablesThatNeedTooMuchMemory) {
  std::ofstream table(folder_ / "scene/large.csv");
  for (int i = 0; i < 300'000; ++i) table << i << ",0\n";
  table.close();
  const std::string text = R"({"assur": 1, "dimension": 2, "points": {"A": {"at": [0, 0]}}, "drivers": {"push":
    {"coordinate": "A.x", "law": [)" +
                           many(300'000, R"({"table": "large.csv"})") + "]}}}";
  const std::string said = refusal([&] { (void)parse_scene(text, "scene", folder_ / "scene"); });
  EXPECT_TRUE(said.starts_with("scene: no memory for a sum of laws with tables of 90000000000 rows in all (")) << said;
  EXPECT_TRUE(said.ends_with("; add fewer tables")) << said;
}

TEST_F(StrangersFiles, ReadsOnlyPlanFilesAsPlans) {
  std::ifstream endless("/dev/zero");
  if (!endless) GTEST_SKIP() << "no /dev/zero here";
  EXPECT_EQ(refusal([&] { (void)load_plan(endless); }),
            "saved plan: this is not a saved plan: it does not begin with \"assur plan \"");
  std::ifstream folder(folder_);
  EXPECT_EQ(refusal([&] { (void)load_plan(folder); }).substr(0, 27), "the plan could not be read:");
}

}  // namespace
}  // namespace assur
