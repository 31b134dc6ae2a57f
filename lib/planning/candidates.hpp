// Which strategies there are for the groups of a class, and what each would cost.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "assur/plan.hpp"

namespace assur {

// What candidates are weighed with.
struct Scales {
  const PerformanceModel& model;
  std::span<const Backend> table;
  std::span<const std::string> without;
  double tie = 0.02;  // costs this close are equal: times are hardly known better
};

// The groups of a class that are solved side by side.
struct Load {
  std::int32_t groups = 1;
  std::int32_t threads = 1;   // that share them
  std::int32_t unknowns = 1;  // of each group
};

// Of work that p threads share, if the longest share takes `makespan` and all of it `work` on one thread: where all of
// them are busy, each takes `contention` times as long.
[[nodiscard]] double together(double makespan, double work, std::int32_t p, double contention);

// Candidates with up to `most_lanes` lanes and `most_q` threads inside, with the time of one call for W groups. That of
// those that cannot run is not known: 0. In no order.
[[nodiscard]] std::vector<Candidate> offers(const Shape& shape, std::int32_t most_lanes, std::int32_t most_q,
                                            const Scales& scales);

// Of these offers, those with up to `most_q` threads inside; each with the sum over `loads`.
[[nodiscard]] std::vector<Candidate> weigh(const std::vector<Candidate>& offers, std::span<const Load> loads,
                                           std::int32_t most_q, const Scales& scales);

// The fastest first, but of those within the tie one with fewer threads, and then one that computes in double; those
// that cannot run last.
void rank(std::vector<Candidate>& candidates, double tie);

// Throws Error (input) if one of the names is no backend.
void check_names(std::span<const std::string> without, std::span<const Backend> table);

}  // namespace assur
