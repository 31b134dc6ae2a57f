// The command with scarce resources: memory, disk, terminal, time.
#include <gtest/gtest.h>
#include <sched.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <functional>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "commands/command.hpp"
#include "output/format.hpp"
#include "sanitizers.hpp"

namespace assur {
namespace {

namespace fs = std::filesystem;

std::function<void()> limited_to(int what, std::size_t bytes) {
  return [what, bytes] {
    const rlimit limit{bytes, bytes};
    if (setrlimit(what, &limit) != 0) _exit(96);
    alarm(120);  // ends a command that hangs
  };
}

std::size_t files_in(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

// With too little address space the command reports this and does not hang in a library.
TEST(Operations, EndsWithAnErrorWithoutMemory) {
#if defined(ASSUR_ADDRESS_SANITIZER) || defined(ASSUR_THREAD_SANITIZER)
  GTEST_SKIP() << "sanitizers reserve more address space than there is memory";
#endif
  const std::vector<std::vector<std::string>> calls = {{"run", "stewart", "--quiet"},
                                                       {"run", "stewart", "--strategy", "groups/lapack", "--quiet"},
                                                       {"plan", "stewart", "--json"}};
  int begun = 0;
  for (const std::size_t megabytes : {100, 200, 300, 400, 450, 500, 600}) {
    for (const auto& words : calls) {
      SCOPED_TRACE(words[0] + " " + words.back() + " in " + std::to_string(megabytes) + " MB");
      Setting setting;
      setting.before = limited_to(RLIMIT_AS, megabytes * 1'000'000);
      const Outcome outcome = run_command(words, setting);
      if (outcome.err.find("error while loading shared libraries") != std::string::npos) continue;  // it did not begin
      ASSERT_TRUE(outcome.status == 0 || outcome.status == 3) << outcome.status << outcome.err;
      ++begun;
      if (outcome.status == 0) continue;
      if (words.back() == "--json") {
        EXPECT_EQ(outcome.json()["error"]["kind"], "environment");
      } else {
        EXPECT_TRUE(outcome.err.starts_with("error: ")) << outcome.err;
      }
    }
  }
  EXPECT_GE(begun, 12);
}

// OpenBLAS for OpenMP ignores these settings and takes all its memory. The check of the command must know this.
TEST(Operations, EndsWithAnErrorIfOpenBlasIgnoresSettings) {
#if defined(ASSUR_ADDRESS_SANITIZER) || defined(ASSUR_THREAD_SANITIZER)
  GTEST_SKIP() << "sanitizers reserve more address space than there is memory";
#endif
  const std::vector<std::function<void()>> ways = {[] { setenv("OPENBLAS_NUM_THREADS", "1", 1); },
                                                   [] {
                                                     cpu_set_t one;
                                                     CPU_ZERO(&one);
                                                     CPU_SET(sched_getcpu(), &one);
                                                     sched_setaffinity(0, sizeof one, &one);
                                                   }};
  for (std::size_t way = 0; way < ways.size(); ++way) {
    for (const std::size_t megabytes : {200, 250, 300, 350}) {
      SCOPED_TRACE(std::to_string(way) + " in " + std::to_string(megabytes) + " MB");
      Setting setting;
      setting.before = [&] {
        ways[way]();
        limited_to(RLIMIT_AS, megabytes * 1'000'000)();
      };
      const Outcome outcome = run_command({"--version"}, setting);
      ASSERT_TRUE(outcome.status == 0 || outcome.status == 3) << outcome.status << outcome.err;
      if (outcome.status == 3) {
        EXPECT_TRUE(outcome.err.starts_with("error: out of memory: ")) << outcome.err;
      }
    }
  }
}

TEST(Operations, TunerEndsWithLittleMemory) {
#if defined(ASSUR_ADDRESS_SANITIZER) || defined(ASSUR_THREAD_SANITIZER)
  GTEST_SKIP() << "sanitizers reserve more address space than there is memory";
#endif
  const Scratch scratch;
  Setting setting;
  setting.before = limited_to(RLIMIT_AS, 500'000'000);
  const Outcome outcome = run_command({"tune", "--budget", "2", "--quiet", "--db", scratch.file("tuning.db")}, setting);
  EXPECT_TRUE(outcome.status == 0 || outcome.status == 3) << outcome.status << outcome.err;
}

class Written : public testing::TestWithParam<std::pair<const char*, std::vector<std::string>>> {};

TEST_P(Written, ReportsAFullDevice) {
  const auto& [option, before] = GetParam();
  std::vector<std::string> words = before;
  words.insert(words.end(), {option, "/dev/full"});
  const Outcome outcome = run_command(words);
  EXPECT_EQ(outcome.status, 3);
  EXPECT_NE(outcome.err.find("error: " + std::string(option) + ": cannot write /dev/full: No space left on device\n"),
            std::string::npos)
      << outcome.err;
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

TEST_P(Written, KeepsTheOldFileIfTheDiskFillsUp) {
  const auto& [option, before] = GetParam();
  const Scratch scratch;
  const std::string file = scratch.file("out", "old");
  std::vector<std::string> words = before;
  words.insert(words.end(), {option, file});
  Setting setting;
  setting.before = [] {
    signal(SIGXFSZ, SIG_IGN);
    limited_to(RLIMIT_FSIZE, 1000)();
  };
  setting.out = "/dev/null";
  const Outcome outcome = run_command(words, setting);
  EXPECT_EQ(outcome.status, 3);
  EXPECT_NE(outcome.err.find("error: " + std::string(option) + ": cannot write " + file + ": File too large\n"),
            std::string::npos)
      << outcome.err;
  EXPECT_EQ(content(file), "old");
  EXPECT_EQ(files_in(fs::path(file).parent_path()), 1u);
}

INSTANTIATE_TEST_SUITE_P(Operations, Written,
                         testing::Values(std::pair("--csv", std::vector<std::string>{"run", "four_bar"}),
                                         std::pair("--plot", std::vector<std::string>{"run", "four_bar"}),
                                         std::pair("--animate", std::vector<std::string>{"run", "four_bar"}),
                                         std::pair("--picture", std::vector<std::string>{"run", "four_bar"}),
                                         std::pair("--errors",
                                                   std::vector<std::string>{"run", "four_bar", "--steps", "100"}),
                                         std::pair("--save", std::vector<std::string>{"plan", "four_bar"})),
                         [](const auto& of) { return std::string(of.param.first).substr(2); });

TEST(Operations, FollowsLinksAndWritesToPipes) {
  const Scratch scratch;
  const std::string target = scratch.file("target", "old"), link = scratch.file("link");
  fs::create_symlink(target, link);
  EXPECT_EQ(run_command({"run", "four_bar", "--steps", "5", "--quiet", "--csv", link}).status, 0);
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_TRUE(content(target).starts_with("t,"));
  EXPECT_EQ(run_command({"run", "four_bar", "--steps", "5", "--quiet", "--csv", "/dev/null"}).status, 0);
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

// After every kind of interrupt the samples are kept, and a message explains how to continue.
TEST(Operations, AnInterruptedTunerSaysHowToContinue) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const Scratch scratch;
    Setting setting;
    setting.interrupt_when_err = "of 60 seconds";
    setting.signal = signal;
    const Outcome outcome = run_command({"tune", "--budget", "60", "--db", scratch.file("tuning.db")}, setting);
    EXPECT_EQ(outcome.status, 130);
    EXPECT_NE(outcome.out.find("the samples are kept; the same command continues the run"), std::string::npos)
        << outcome.out;
  }
}

TEST(Operations, AnInterruptedReportIsWritten) {
  const Scratch scratch;
  Setting setting;
  setting.interrupt_when_err = " seconds";
  setting.signal = SIGTERM;
  const Outcome outcome = run_command({"report", "--quick", "--out", scratch.file("report")}, setting);
  EXPECT_EQ(outcome.status, 130);
  EXPECT_NE(outcome.err.find("interrupted: the report holds what was measured until then\n"), std::string::npos)
      << outcome.err;
  EXPECT_NE(content(scratch.file("report") + "/index.html").find("Interrupted after"), std::string::npos);
}

// The tuner is interrupted at its first bar, so that the speed of the machine does not matter.
TEST(Operations, ProgressBarFitsTheTerminal) {
  const Scratch scratch;
  const std::vector<std::string> words = {"tune", "--budget", "60", "--db", scratch.file("t.db")};
  const std::string erase = "\r\x1b[K";
  Setting setting;
  setting.columns = 20;
  setting.before = [] { setenv("TERM", "xterm", 1); };
  setting.interrupt_when_err = erase;
  const std::string drawn = run_command(words, setting).err;
  ASSERT_NE(drawn.find(erase), std::string::npos);
  int bars = 0;
  for (std::size_t at = 0, next = 0; next != std::string::npos; at = next + erase.size()) {
    next = drawn.find(erase, at);
    const std::string piece = drawn.substr(at, next == std::string::npos ? next : next - at);
    if (piece.find('\n') != std::string::npos) continue;  // a note, e.g. on the kernels that OpenBLAS has taken
    EXPECT_LT(piece.size(), 20u) << piece;
    bars += piece.find(" of ") != std::string::npos;
  }
  EXPECT_GT(bars, 0);
  setting.before = [] { setenv("TERM", "dumb", 1); };
  setting.interrupt_when_err = " of ";
  const std::string lines = run_command(words, setting).err;
  EXPECT_NE(lines.find(" of "), std::string::npos);
  EXPECT_EQ(lines.find('\x1b'), std::string::npos);
}

// A page on a terminal fits its columns and keeps its words. A wide terminal gets the same page as a file.
TEST(Operations, PagesFitTheTerminal) {
  const std::vector<std::vector<std::string>> calls = {
      {"plan", "stewart"},
      {"inspect", "rings:legs=6,n=120,terminal=24"},
      {"backends"},
      {"compare", "four_bar", "--steps", "20", "--strategies", "groups/eigen"},
      {"db", "info"}};
  const auto lines_of = [](std::string text) {
    text.erase(std::remove(text.begin(), text.end(), '\r'), text.end());
    return Outcome{0, text, ""}.lines();
  };
  const auto words_of = [](const std::string& text) {
    std::istringstream stream(text);
    return std::vector<std::string>(std::istream_iterator<std::string>(stream), {});
  };
  for (const auto& words : calls) {
    SCOPED_TRACE(words[0]);
    const bool repeats = words[0] != "compare";  // `compare` measures anew
    const std::string file = run_command(words).out;
    ASSERT_FALSE(file.empty());
    for (const unsigned short columns : std::initializer_list<unsigned short>{40, 80, 300}) {
      Setting setting;
      setting.columns = columns;
      setting.terminal = STDOUT_FILENO;
      const std::string drawn = run_command(words, setting).out;
      ASSERT_FALSE(drawn.empty());
      if (repeats) {
        EXPECT_EQ(words_of(drawn), words_of(file)) << columns;
      }
      if (repeats && columns == 300) {
        EXPECT_EQ(lines_of(drawn), lines_of(file));
      }
      for (const std::string& line : lines_of(drawn)) {
        const std::size_t text = std::min(line.find_first_not_of(' '), line.size());
        const bool one_word = line.find(' ', text) == std::string::npos;  // a single word is not shortened
        EXPECT_TRUE(one_word || output::display_width(line) <= columns) << columns << ": " << line;
      }
    }
  }
}

// The command ignores the locale of the environment.
TEST(Operations, NoLocaleChangesAPlan) {
  const Scratch scratch;
  const std::string here = scratch.file("here"), there = scratch.file("there");
  EXPECT_EQ(run_command({"plan", "stewart", "--quiet", "--save", here}).status, 0);
  Setting setting;
  setting.before = [] {
    for (const char* name : {"LC_ALL", "LANG", "LC_NUMERIC"}) setenv(name, "de_DE.UTF-8", 1);
  };
  EXPECT_EQ(run_command({"plan", "stewart", "--quiet", "--save", there}, setting).status, 0);
  EXPECT_EQ(content(here), content(there));
}

}  // namespace
}  // namespace assur
