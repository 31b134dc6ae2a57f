// Benchmark programs that go through many scenes and write a table: their options and their main().
#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <string>

#include "assur/performance.hpp"
#include "assur/scene.hpp"

namespace assur::bench {

struct Survey {
  bool quick = false;
  int threads = 0;   // budget
  std::string only;  // scenes whose text contains it
  std::shared_ptr<const PerformanceModel> model;

  [[nodiscard]] bool wants(const std::string& scene) const { return scene.find(only) != std::string::npos; }
};

// Reads the command line, describes the machine and its model, and runs `survey`; `csv` is opened before the survey;
// without --csv its output is discarded. Errors go to standard error. Returns the exit status.
int run_survey(int argc, char** argv, const std::string& about, void (*survey)(const Survey&, std::ostream& csv));

}  // namespace assur::bench
