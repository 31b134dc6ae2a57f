// Options, help, and wrong arguments.
#include <gtest/gtest.h>

#include "assur/version.hpp"
#include "commands/command.hpp"
#include "output/format.hpp"

namespace assur {
namespace {

struct Misuse {
  std::vector<std::string> arguments;
  std::string message, help;
};

TEST(Usage, ReportsWrongArgumentsAndNamesTheHelp) {
  const std::vector<Misuse> cases = {
      {{}, "a command is missing", "assur"},
      {{"rum"}, "there is no command rum", "assur"},
      {{"--bogus"}, "there is no option --bogus", "assur"},
      {{"run"}, "SCENE is required", "assur run"},
      {{"run", "stewart", "gough"}, "unexpected argument: gough", "assur run"},
      {{"run", "stewart", "--cores", "2"}, "there is no option --cores", "assur run"},
      {{"run", "stewart", "--threads", "0"},
       "--threads: expects a whole number from 1 to 2147483647, not \"0\"",
       "assur run"},
      {{"backends", "--threads", "1.5"},
       "--threads: expects a whole number from 1 to 2147483647, not \"1.5\"",
       "assur backends"},
      {{"run", "stewart", "--steps", "-3"},
       "--steps: expects a whole number from 0 to 2147483647, not \"-3\"",
       "assur run"},
      {{"run", "stewart", "--steps", "1.5"},
       "--steps: expects a whole number from 0 to 2147483647, not \"1.5\"",
       "assur run"},
      {{"run", "stewart", "--iterations", "0"},
       "--iterations: expects a whole number from 1 to 2147483647, not \"0\"",
       "assur run"},
      {{"run", "stewart", "--dt", "nan"}, "--dt: expects a number > 0, not \"nan\"", "assur run"},
      {{"run", "stewart", "--dt", "0"}, "--dt: expects a number > 0, not \"0\"", "assur run"},
      {{"run", "stewart", "--start", "soon"}, "--start: expects a number, not \"soon\"", "assur run"},
      {{"run", "stewart", "--set", "omega"}, "--set: expects name=number, not \"omega\"", "assur run"},
      {{"run", "stewart", "--set", "omega=1x"}, "--set: expects name=number, not \"omega=1x\"", "assur run"},
      {{"run", "stewart", "--set", "omega=1", "--set", "omega=2"}, "--set: is given twice for \"omega\"", "assur run"},
      {{"run", "stewart", "--mode", "fast"}, "--mode: expects latency or throughput, not \"fast\"", "assur run"},
      {{"run", "stewart", "--ensemble", ""}, "--ensemble: expects a file name", "assur run"},
      {{"run", "stewart", "--csv", ""}, "--csv: expects a file name", "assur run"},
      {{"run", "stewart", "--errors", ""}, "--errors: expects a file name", "assur run"},
      {{"run", "stewart", "--animate", ""}, "--animate: expects a file name", "assur run"},
      {{"run", "stewart", "--plot", ""}, "--plot: expects a file name", "assur run"},
      {{"run", "stewart", "--accuracy", "-1e-6"}, "--accuracy: expects a number > 0, or 0, not \"-1e-6\"", "assur run"},
      {{"plan", "stewart", "--accuracy", "fine"}, "--accuracy: expects a number > 0, or 0, not \"fine\"", "assur plan"},
      {{"run", "stewart", "--outputs", ""}, "--outputs: expects names such as A,B, not \"\"", "assur run"},
      {{"run", "stewart", "--outputs", ","}, "--outputs: expects names such as A,B, not \",\"", "assur run"},
      {{"inspect", "stewart", "--outputs", "O,,B1"},
       "--outputs: expects names such as A,B, not \"O,,B1\"",
       "assur inspect"},
      {{"inspect", "stewart", "--formulation", "dense"},
       "--formulation: expects global, groups or irreducible, not \"dense\"",
       "assur inspect"},
      {{"inspect", "stewart", "--modes", "--outputs", "O"},
       "--modes: shows all groups; leave out --outputs, --formulation and --range",
       "assur inspect"},
      {{"inspect", "stewart", "--formulation", "global", "--modes"},
       "--modes: shows all groups; leave out --outputs, --formulation and --range",
       "assur inspect"},
      {{"backends", "eigen"}, "unexpected argument: eigen", "assur backends"},
      {{"backends", "--db", ""}, "--db: expects a file name", "assur backends"},
      {{"db"}, "a command is missing", "assur db"},
      {{"db", "bogus"}, "there is no command db bogus", "assur db"},
      {{"db", "--all"}, "there is no option --all", "assur db"},
      {{"db", "info", "now"}, "unexpected argument: now", "assur db info"},
      {{"db", "export"}, "FILE is required", "assur db export"},
      {{"db", "forget", "--run", "one"},
       "--run: expects a whole number from 1 to 2147483647, not \"one\"",
       "assur db forget"},
  };
  for (const Misuse& c : cases) {
    const Outcome outcome = run_command(c.arguments);
    EXPECT_EQ(outcome.status, 2) << c.message;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(outcome.err, "error: " + c.message + "\nSee " + c.help + " --help.\n");
  }
}

TEST(Usage, ReportsWrongArgumentsAsJson) {
  const Outcome outcome = run_command({"run", "stewart", "--json", "--csv", "-"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.err, "");
  const auto error = outcome.json()["error"];
  EXPECT_EQ(error["kind"], "input");
  EXPECT_EQ(error["diagnostics"][0]["what"], "--csv: cannot share standard output with --json; give a file");
}

TEST(Usage, HelpFitsEightyColumnsAndNamesEveryOption) {
  const std::vector<std::string> common = {"--json", "--quiet", "--threads", "--db", "--help", "--version"};
  const std::vector<std::pair<std::vector<std::string>, std::vector<std::string>>> cases = {
      {{"--help"},
       {"run", "inspect", "import", "plan", "sweep", "compare", "backends", "samples", "tune", "db", "check",
        "report"}},
      {{"run", "--help"},
       {"SCENE",    "--set",      "--start",    "--dt",         "--steps",      "--outputs", "--strategy",
        "--mode",   "--accuracy", "--ensemble", "--iterations", "--start-mode", "--guess",   "--csv",
        "--errors", "--animate",  "--picture",  "--plot",       "--reference",  "--pin"}},
      {{"compare", "--help"}, {"SCENE", "--set", "--outputs", "--steps", "--accuracy", "--strategies", "--html"}},
      {{"inspect", "--help"}, {"SCENE", "--set", "--outputs", "--formulation", "--modes"}},
      {{"import", "--help"}, {"FILE", "--out", "--key", "--drive"}},
      {{"plan", "--help"}, {"SCENE", "--set", "--outputs", "--without", "--mode", "--accuracy", "--save", "--machine"}},
      {{"sweep", "--help"}, {"SCENE", "--vary", "--samples", "--sampler", "--reduce", "--best", "--out"}},
      {{"tune", "--help"}, {"--profile", "--budget", "--scene", "--csv"}},
      {{"backends", "--help"}, {}},
      {{"check", "--help"}, {"SCENE", "--set", "--quick", "--case"}},
      {{"report", "--help"}, {"--out", "--quick", "--budget", "--watts", "--peers"}},
      {{"db", "--help"}, {"info", "samples", "best", "crossovers", "models", "export", "import", "check", "forget"}},
      {{"db", "samples", "--help"}, {"--run", "--machine", "--library", "--kernel", "--strategy", "-n", "--csv"}},
      {{"db", "forget", "--help"}, {"--run", "--machine", "--library", "--all"}},
  };
  for (const auto& [arguments, words] : cases) {
    const Outcome outcome = run_command(arguments);
    EXPECT_EQ(outcome.status, 0);
    EXPECT_EQ(outcome.err, "");
    for (const std::string& line : outcome.lines()) EXPECT_LE(output::display_width(line), 80u) << line;
    for (const auto* list : {&common, &words}) {
      for (const std::string& word : *list) EXPECT_NE(outcome.out.find(word), std::string::npos) << word;
    }
  }
}

TEST(Usage, PrintsTheVersionOfTheProject) {
  for (const auto& arguments : {std::vector<std::string>{"--version"}, {"run", "--version"}}) {
    const Outcome outcome = run_command(arguments);
    EXPECT_EQ(outcome.status, 0);
    EXPECT_EQ(outcome.out, "assur " ASSUR_VERSION "\n");
  }
}

TEST(Usage, AcceptsCommonOptionsBeforeTheCommand) {
  EXPECT_EQ(run_command({"--json", "backends"}).json(), run_command({"backends", "--json"}).json());
}

TEST(Usage, AFullStandardOutputIsAnEnvironmentError) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  const Outcome outcome = run_command({"backends"}, {{}, "/dev/full", {}});
  EXPECT_EQ(outcome.status, 3);
  EXPECT_EQ(outcome.err, "error: cannot write to standard output: No space left on device\n");
}

}  // namespace
}  // namespace assur
