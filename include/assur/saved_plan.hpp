// Plans as files. A program that loads a plan needs the library assur::core only.
#pragma once

#include <iosfwd>
#include <optional>
#include <span>

#include "assur/backend.hpp"
#include "assur/plan.hpp"

namespace assur {

// Writes everything that a Simulator or an Ensemble needs, as text: all numbers are exact, and a checksum ends it.
// Throws Error: input if a law or constraint is a C++ function, because a file cannot hold it; environment if `out`
// fails.
void save_plan(std::ostream& out, const Prepared& prepared);

// Options of load_plan().
struct LoadOptions {
  std::span<const Backend> table = core_backends();  // backends that the plan may use; must outlive the plan
  // Largest number of threads; empty: as Machine::budget() of this machine, found without assur::assur. A plan for a
  // larger P runs with fewer threads: its motion is the same bit by bit, and Plan::reason mentions the change. A plan
  // with a larger Q is refused.
  std::optional<ThreadBudget> budget = std::nullopt;
};

// Reads a plan that save_plan() wrote. All sizes and indices are checked, so a file from strangers may be read. The
// plan uses the same strategies; with the same version of assur on the same kind of processor the motion is the same
// bit by bit. A loaded plan has no scene, so that forward_error() and certify() refuse it; redundant equations are not
// chosen anew: near their singularities the run passes a change point with an event, or ends with a status; and
// structure() lacks counts, notes and lists that are only for people. Throws Error: input if the text is not a saved
// plan, has another format version, is truncated or altered, or if the budget has no thread; environment if `in` fails,
// or if a backend of the plan is not in the table, cannot run here, or needs more threads (Q) than the budget has.
[[nodiscard]] Prepared load_plan(std::istream& in, const LoadOptions& options = {});

}  // namespace assur
