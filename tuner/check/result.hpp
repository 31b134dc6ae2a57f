// Results of a case.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "check/case.hpp"

namespace assur::check {

// Result of one strategy.
struct Run {
  std::string strategy;
  Verdict verdict;
  std::string message;  // message of a refusal, or description of the error
  std::optional<double> forward_error, backward_error;
};

struct Result {
  Case what;
  std::int64_t runs = 0;
  Verdict verdict;              // of the first run, or of the first unexpected one
  std::vector<Run> unexpected;  // runs
  std::vector<std::string>
      notes;  // strategies that were left out, with reasons; the substitute for a missing true motion
  std::set<std::string> left_out;                       // backends that failed to start, with the reason
  std::optional<double> forward_error, backward_error;  // the worst of all runs
  std::optional<double> condition;                      // condition of the worst posture
  std::optional<double> bound;                          // forward error that theory allows
  bool interrupted = false;                             // not all strategies were run

  [[nodiscard]] bool passed() const { return unexpected.empty() && !verdict.empty(); }
  // Adds a run, and compares it with the expected verdicts.
  void add(Run run);
};

}  // namespace assur::check
