// Runs the independent parts of a large mechanism one after the other, each over all times, so that the numbers of a
// part stay in the cache.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "assur/simulator.hpp"
#include "side_by_side/side_by_side.hpp"

namespace assur {

// The result of a run in parts.
struct RunInParts {
  std::string refused;          // why the run must begin anew, step by step; "": it succeeded
  RowValues values;             // rows x columns
  std::vector<double> posture;  // of the whole mechanism, at the last time
  Totals totals;
};

// Empty if the mechanism is small, has no independent parts, or is run in another way. The P threads take parts in
// turn; results do not depend on P. Every step must succeed undivided, else the run is refused. Throws Error: numerical
// if a part cannot start, environment if a backend of the plan cannot run here.
[[nodiscard]] std::optional<RunInParts> run_in_parts(const Prepared& prepared, const StepLimits& limits,
                                                     std::span<const double> times, std::size_t columns);

}  // namespace assur
