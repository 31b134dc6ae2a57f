// Benchmark programs that go through many scenes and write a table: their options and their main().
#pragma once

#include <string>

namespace assur::bench {

struct SurveyOptions {
  bool quick = false;
  int threads = 0;  // 0: the machine's budget
  std::string only, csv;
};

// Reads the command line and runs `survey`; its Errors go to standard error. Returns the exit status.
int run_survey(int argc, char** argv, const std::string& about, int (*survey)(const SurveyOptions&));

}  // namespace assur::bench
