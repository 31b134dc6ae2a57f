#include "survey.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>

#include "assur/status.hpp"

namespace assur::bench {

int run_survey(int argc, char** argv, const std::string& about, int (*survey)(const SurveyOptions&)) {
  SurveyOptions o;
  CLI::App app(about);
  app.add_flag("--quick", o.quick, "Fewer and smaller measurements");
  app.add_option("--threads", o.threads, "Number of threads; default: the machine's budget");
  app.add_option("--only", o.only, "Only scenes whose text contains this");
  app.add_option("--csv", o.csv, "Write all rows to a CSV file");
  CLI11_PARSE(app, argc, argv);
  try {
    return survey(o);
  } catch (const Error& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 1;
  }
}

}  // namespace assur::bench
