// Numbers beyond a limit. The message comes before any work and names the limit.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <regex>

#include "commands/command.hpp"
#include "sanitizers.hpp"

namespace assur {
namespace {

// Removes the amount of free memory, which depends on the machine.
std::string without_free(const std::string& text) {
  return std::regex_replace(text, std::regex(", [0-9]+ free"), ", F free");
}

Setting with_address_space(rlim_t bytes) {
  return {.before = [bytes] {
    setenv("OMP_NUM_THREADS", "1", 1);
    const rlimit limit{bytes, bytes};
    setrlimit(RLIMIT_AS, &limit);
  }};
}

TEST(Limits, MessagesNameTheLargestWholeNumber) {
  for (const std::string bad : {"-1", "1.5", "1e9", "2147483648", "1000000000000000000", "1e400", "nan", "x"}) {
    const Outcome outcome = run_command({"run", "four_bar", "--steps", bad});
    EXPECT_EQ(outcome.status, 2);
    EXPECT_EQ(outcome.err, "error: --steps: expects a whole number from 0 to 2147483647, not \"" + bad +
                               "\"\nSee assur run --help.\n");
  }
}

TEST(Limits, BudgetIsAtMostElevenDays) {
  for (const std::string command : {"tune", "report"}) {
    const Outcome outcome = run_command({command, "--budget", "1e300"});
    EXPECT_EQ(outcome.status, 2);
    EXPECT_EQ(
        outcome.err,
        "error: --budget: expects a number > 0 and at most 1000000, which are 11 days, not \"1e300\"\nSee assur " +
            command + " --help.\n");
  }
}

TEST(Limits, RefusesResultsThatDoNotFitIntoMemory) {
#if defined(ASSUR_ADDRESS_SANITIZER) || defined(ASSUR_THREAD_SANITIZER)
  GTEST_SKIP() << "sanitizers reserve more address space than there is memory";
#endif
  const std::string remedy = "; ask for fewer outputs or a shorter run\n";
  const Setting no_more = with_address_space(rlim_t{1} << 36);  // needed on machines with much memory
  for (const std::string command : {"run", "compare"}) {
    const Outcome outcome = run_command({command, "four_bar", "--steps", "2147483647"}, no_more);
    EXPECT_EQ(outcome.status, 3);
    EXPECT_EQ(without_free(outcome.err),
              "error: no memory for 2147483648 times x 17 values (278528 MiB, F free)" + remedy);
  }
  const Outcome outcome = run_command({"run", "four_bar", "--set", "steps=1e12"}, no_more);
  EXPECT_EQ(outcome.status, 3);
  EXPECT_EQ(without_free(outcome.err),
            "error: no memory for 1000000000001 times x 17 values (129699707 MiB, F free)" + remedy);
}

TEST(Limits, CountsAddressSpaceLimitsAsMemory) {
#if defined(ASSUR_ADDRESS_SANITIZER) || defined(ASSUR_THREAD_SANITIZER)
  GTEST_SKIP() << "sanitizers reserve more address space than there is memory";
#endif
  const Outcome outcome = run_command({"run", "four_bar", "--steps", "10000000"}, with_address_space(rlim_t{1} << 30));
  EXPECT_EQ(outcome.status, 3);
  EXPECT_EQ(without_free(outcome.err),
            "error: no memory for 10000001 times x 17 values (1297 MiB, F free); ask for fewer outputs or a shorter "
            "run\n");
}

TEST(Limits, LimitsTheNumbersOfStepsAndTimes) {
  const Outcome many = run_command({"run", "four_bar", "--dt", "1e-300"});
  EXPECT_EQ(many.status, 2);
  EXPECT_EQ(many.err,
            "error: /time/step: (end - start) / step is 9.999999999999999e+299; more than 1e+12 steps are not "
            "possible\n");
  const Outcome late = run_command({"run", "four_bar", "--start", "1e18", "--steps", "3"});
  EXPECT_EQ(late.status, 2);
  EXPECT_EQ(late.err,
            "error: /time/step: the step of 0.001 s is lost in rounding: around 1e+18 s doubles are 128 s apart; take "
            "times nearer to 0, or longer steps\n");
}

TEST(Limits, RefuseGeneratedMechanismsThatAreTooLarge) {
#if defined(ASSUR_ADDRESS_SANITIZER) || defined(ASSUR_THREAD_SANITIZER)
  GTEST_SKIP() << "sanitizers reserve more address space than there is memory";
#endif
  const Outcome rings = run_command({"inspect", "rings:legs=10000000,n=10000000"});
  EXPECT_EQ(rings.status, 2);
  EXPECT_EQ(rings.err, "error: sample 'rings': 100000000000024 unknowns are too many; the limit is 1e+08\n");
  const Outcome loops = run_command({"inspect", "four_bar:10000000"}, with_address_space(rlim_t{4} << 30));
  EXPECT_EQ(loops.status, 3);
  EXPECT_EQ(without_free(loops.err),
            "error: no memory for 2e+07 unknowns (9537 MiB, F free); ask for a smaller mechanism\n");
}

TEST(Limits, LimitsScenes) {
#if defined(ASSUR_ADDRESS_SANITIZER) || defined(ASSUR_THREAD_SANITIZER)
  GTEST_SKIP() << "sanitizers reserve more address space than there is memory";
#endif
  const Scratch scratch;
  std::string values = "[0";
  for (int i = 0; i < 6'000'000; ++i) values += ",0";
  const std::string scene = scratch.file("zeros.json", values + "]");
  const Outcome outcome = run_command({"inspect", scene}, with_address_space(rlim_t{300} << 20));
  EXPECT_EQ(outcome.status, 3);
  EXPECT_EQ(without_free(outcome.err), "error: " + scene +
                                           ": no memory for the scene of 6000002 values (366 MiB, F free); write a "
                                           "smaller scene\n");
}

TEST(Limits, RefusesTooManyMembersBeforePreparingAll) {
#if defined(ASSUR_ADDRESS_SANITIZER) || defined(ASSUR_THREAD_SANITIZER)
  GTEST_SKIP() << "sanitizers reserve more address space than there is memory";
#endif
  const Scratch scratch;
  std::string rows = "omega\n";
  for (int i = 0; i < 20'000; ++i) rows += "1\n";
  const std::string file = scratch.file("variants.csv", rows);
  const Outcome results = run_command({"run", "stewart", "--steps", "1000000000", "--quiet", "--ensemble", file});
  EXPECT_EQ(results.status, 3);
  EXPECT_EQ(without_free(results.err),
            "error: no memory for 2e+13 times x 432 values of 20,000 members (65917968816 MiB, F free); ask for fewer "
            "outputs, a shorter run or fewer members\n");
  const Outcome members = run_command({"run", "stewart", "--steps", "1", "--quiet", "--ensemble", file},
                                      with_address_space(rlim_t{700} << 20));
  EXPECT_EQ(members.status, 3);
  EXPECT_TRUE(std::regex_match(members.err, std::regex("error: no memory for 20,000 members \\([0-9]+ MiB, [0-9]+ "
                                                       "free\\); run fewer at a time\n")))
      << members.err;
  rows = "omega\n";
  for (int i = 0; i < 10'000'000; ++i) rows += "1\n";
  const std::string many = scratch.file("many.csv", rows);
  const Outcome variants = run_command({"run", "stewart", "--ensemble", many}, with_address_space(rlim_t{700} << 20));
  EXPECT_EQ(variants.status, 3);
  EXPECT_EQ(without_free(variants.err), "error: no memory for the variants of " + many +
                                            ", about 10000001 (1221 MiB, F free); give fewer at a time\n");
}

}  // namespace
}  // namespace assur
