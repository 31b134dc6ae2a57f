// Runs a case with every strategy that can, and holds what comes out against what is expected.
#pragma once

#include <functional>

#include "check/case.hpp"
#include "check/result.hpp"

namespace assur::check {

struct RunnerOptions {
  bool quick = false;
  // Asked between runs and steps; true: stop, and keep what is done.
  std::function<bool()> stop = [] { return false; };
};

// Never throws for what a scene does, which is a verdict; throws Error (environment) where a forced strategy of the
// case's own file cannot run here, and whatever a case's file has wrong.
[[nodiscard]] Result run(const Case& c, const RunnerOptions& options = {});

// The scene of a case, in its time grid and with its outputs. Throws as reading it does.
[[nodiscard]] Scene scene_of(const Case& c);

}  // namespace assur::check
