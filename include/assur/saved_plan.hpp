// A plan as a file: a program that loads one needs assur::core only.
#pragma once

#include <iosfwd>
#include <optional>
#include <span>

#include "assur/backend.hpp"
#include "assur/plan.hpp"

namespace assur {

// Writes all that a Simulator or an Ensemble needs: text, with every number exact and a checksum at its end. Throws
// Error: input for laws and constraints that are C++ functions, which no file can hold; environment if `out` fails.
void save_plan(std::ostream& out, const Prepared& prepared);

struct LoadOptions {
  std::span<const Backend> table = core_backends();  // where the plan's backends are looked up
  // Threads to use at most; empty: Machine::budget() of this machine. A plan with larger p runs with fewer threads,
  // which changes no bit of the motion, and its `reason` says so.
  std::optional<ThreadBudget> budget = std::nullopt;
};

// What save_plan() wrote, with nothing chosen anew: the same strategies, the same motion bit by bit where the library
// is the same. Without Prepared::scene (so that forward_error() has nothing to compare with), without what of the
// structure only people read, and without Prepared::reselect: where redundant equations would be chosen anew, a step
// fails with the status of its singularity. Throws Error: input if this is no saved plan, of another format version,
// truncated or altered; environment if `in` fails, or if a backend of the plan is not in the table or cannot run here,
// or takes more threads than the budget has.
[[nodiscard]] Prepared load_plan(std::istream& in, const LoadOptions& options = {});

}  // namespace assur
