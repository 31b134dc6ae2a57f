// The sections about this machine, a file each.
#pragma once

#include "report/conditions.hpp"
#include "report/knowledge.hpp"
#include "report/section.hpp"

namespace assur::report {

// Which strategy is expected to win for how many groups of how many unknowns, and where another one begins to.
[[nodiscard]] Section winners(const Knowledge& knowledge, const Conditions& conditions);

// The regret of `auto` and of the best constant strategy over mechanisms that no tuner has seen.
[[nodiscard]] Section regret(const Knowledge& knowledge, const Conditions& conditions);

// Error against run time of some mechanisms, with the front and what `auto` takes.
[[nodiscard]] Section work_precision(const Knowledge& knowledge, const Conditions& conditions);

// Speed-up by threads, lanes and members of an ensemble.
[[nodiscard]] Section scaling(const Knowledge& knowledge, const Conditions& conditions);

// How long single steps take: their histogram.
[[nodiscard]] Section step_histogram(const Knowledge& knowledge, const Conditions& conditions);

// Regret on what was held out, over the seconds that a tuning run has taken.
[[nodiscard]] Section tuning_cost(const Knowledge& knowledge, const Conditions& conditions);

// Expected against measured times of what a tuning run has held out.
[[nodiscard]] Section model_fit(const Knowledge& knowledge, const Conditions& conditions);

}  // namespace assur::report
