// How a case ended with each strategy.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "check/case.hpp"

namespace assur::check {

// With one strategy.
struct Run {
  std::string strategy;
  Verdict verdict;
  std::string message;  // of a refusal, or what is wrong
  std::optional<double> forward_error, backward_error;
};

struct Result {
  Case what;
  std::int64_t runs = 0;
  Verdict verdict;              // of the first run, or of the first unexpected one
  std::vector<Run> unexpected;  // runs
  std::vector<std::string>
      notes;  // which strategies were left out and why, and what they were measured against instead
  std::optional<double> forward_error, backward_error;  // the worst of all runs
  std::optional<double> condition;                      // of the worst posture
  std::optional<double> bound;                          // what theory allows the forward error to be
  bool interrupted = false;                             // not all strategies were run

  [[nodiscard]] bool passed() const { return unexpected.empty() && !verdict.empty(); }
  // Counts a run, and judges it by what is expected.
  void add(Run run);
};

}  // namespace assur::check
