// Runs a case with all strategies that can, and compares the results with the expected verdicts.
#pragma once

#include <functional>

#include "check/case.hpp"
#include "check/result.hpp"

namespace assur::check {

struct RunnerOptions {
  bool quick = false;
  // Called between runs and steps; true stops, and keeps the results so far.
  std::function<bool()> stop = [] { return false; };
};

// Runs a case. Failures of a scene are verdicts, not exceptions. Throws Error (environment) if a strategy that the file
// of the case names cannot run here, and Error for errors in that file.
[[nodiscard]] Result run(const Case& c, const RunnerOptions& options = {});

// The scene of a case with its time grid and outputs. Throws like the functions that read or make it.
[[nodiscard]] Scene scene_of(const Case& c);

}  // namespace assur::check
