// No file on the command line makes the command wait or read forever.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>

#include "commands/command.hpp"
#include "sanitizers.hpp"

namespace assur {
namespace {

class StrangersFilesInCommands : public testing::Test {
 protected:
  void SetUp() override { ASSERT_EQ(::mkfifo(pipe_.c_str(), 0600), 0); }

  [[nodiscard]] std::string scene(const std::string& table) const {
    return scratch_.file("scene.json", R"({"assur": 1, "dimension": 2, "points": {"A": {"at": [0, 0]}},
      "drivers": {"push": {"coordinate": "A.x", "law": {"table": ")" +
                                           table + R"("}},
                  "lift": {"coordinate": "A.y", "law": {"constant": 0}}},
      "time": {"start": 0, "end": 1, "step": 0.5}})");
  }

  Scratch scratch_;
  std::string pipe_ = scratch_.file("pipe");
};

TEST_F(StrangersFilesInCommands, RefusesPipesAndDevicesAtOnce) {
  for (const std::string command : {"run", "inspect", "plan", "compare", "check"}) {
    const Outcome of_pipe = run_command({command, pipe_});
    EXPECT_EQ(of_pipe.status, 3) << command;
    EXPECT_EQ(of_pipe.err,
              "error: " + pipe_ + ": the scene file cannot be read: it is a pipe; only regular files are read\n");
    EXPECT_EQ(run_command({command, "/dev/zero"}).err,
              "error: /dev/zero: the scene file cannot be read: it is a device; only regular files are read\n");
  }
  EXPECT_EQ(run_command({"tune", "--scene", pipe_}).err,
            "error: " + pipe_ + ": the scene file cannot be read: it is a pipe; only regular files are read\n");
  EXPECT_EQ(run_command({"run", "stewart", "--ensemble", pipe_}).err,
            "error: " + pipe_ + ": the file of variants cannot be read: it is a pipe; only regular files are read\n");
  EXPECT_EQ(run_command({"report", "--out", scratch_.file("r"), "--peers", pipe_}).err,
            "error: --peers: cannot read " + pipe_ + ": it is a pipe; only regular files are read\n");
}

TEST_F(StrangersFilesInCommands, ADatabaseIsARegularFile) {
  const std::string why = ": it is a pipe; only regular files are read\n";
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"run", "stewart"}, {"plan", "stewart"}, {"db", "samples"}, {"db", "check"}, {"tune", "--budget", "1"}}) {
    std::vector<std::string> all = words;
    all.insert(all.end(), {"--db", pipe_});
    const Outcome outcome = run_command(all);
    EXPECT_EQ(outcome.status, 3) << words[0];
    EXPECT_EQ(outcome.err, "error: " + pipe_ + why) << words[0];
  }
  EXPECT_EQ(run_command({"db", "import", pipe_, "--db", scratch_.file("new.db")}).err, "error: " + pipe_ + why);
}

TEST_F(StrangersFilesInCommands, AllowsTablesInNamedFolders) {
  std::filesystem::create_directory(scratch_.file("data"));
  (void)scratch_.file("data/good.csv", "0,0\n1,1\n");
  std::filesystem::create_directory(scratch_.file("mine"));
  std::filesystem::rename(scene("../data/good.csv"), scratch_.file("mine/scene.json"));
  const Outcome refused = run_command({"run", scratch_.file("mine/scene.json")});
  EXPECT_EQ(refused.status, 2);
  EXPECT_EQ(refused.err,
            "error: " + scratch_.file("mine/scene.json") +
                ": /drivers/push/law/table: the file '../data/good.csv' is outside the folder of the scene; "
                "tables are read only from there, or from folders that you allow (--tables FOLDER)\n");
  for (const std::string command : {"run", "inspect", "plan"}) {
    EXPECT_EQ(run_command({command, scratch_.file("mine/scene.json"), "--tables", scratch_.file("data")}).status, 0);
  }
  const Outcome absent = run_command({"run", scratch_.file("mine/scene.json"), "--tables", scratch_.file("none")});
  EXPECT_EQ(absent.status, 2);
  EXPECT_EQ(absent.err.substr(0, absent.err.find('\n')),
            "error: --tables: Directory does not exist: " + scratch_.file("none"));
}

#if !defined(ASSUR_ADDRESS_SANITIZER) && !defined(ASSUR_THREAD_SANITIZER)

// A crank with dyads at its end.
std::string dyads(int count) {
  std::string points, constraints;
  for (int i = 0; i < count; ++i) {
    const std::string n = std::to_string(i);
    points += R"(, "G)" + n + R"(": {"at": [)" + std::to_string(3 + 0.001 * i) + R"(, 0], "fixed": true}, "P)" + n +
              R"(": {"at": [)" + std::to_string(1.5 + 0.0005 * i) + ", 1.7]}";
    constraints += R"(, "a)" + n + R"(": {"distance": ["T", "P)" + n + R"("]}, "b)" + n + R"(": {"distance": ["G)" + n +
                   R"(", "P)" + n + R"("]})";
  }
  return R"({"assur": 1, "dimension": 2, "points": {"O": {"at": [0, 0], "fixed": true}, "T": {"at": [0, 1]})" + points +
         R"(}, "constraints": {"crank": {"distance": ["O", "T"], "value": 1})" + constraints +
         R"(}, "drivers": {"m": {"angle": ["O", "T"], "law": {"polynomial": ["=pi/2", 1]}}},
             "time": {"start": 0, "end": 0.02, "step": 0.01}})";
}

TEST(BigScenes, AMillionDyadsNeedLessThan1500Megabytes) {
  constexpr int kMore = 80000;
  const Scratch scratch;
  const auto memory = [](const std::string& scene) {
    // Freed memory goes back to the system at once, as for larger arrays.
    const Outcome outcome = run_command({"plan", scene, "--threads", "1"},
                                        {.before = [] { setenv("MALLOC_MMAP_THRESHOLD_", "1000000", 1); }});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.memory;
  };
  const auto of_each = [&](const std::string& few, const std::string& many) {
    return static_cast<double>(memory(many) - memory(few)) / kMore;
  };
  EXPECT_LT(of_each(scratch.file("few.json", dyads(20000)), scratch.file("many.json", dyads(20000 + kMore))), 1500);
  EXPECT_LT(of_each("four_bar:20000", "four_bar:" + std::to_string(20000 + kMore)), 1500);
}

#endif

}  // namespace
}  // namespace assur
