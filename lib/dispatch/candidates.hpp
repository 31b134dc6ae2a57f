// Candidate strategies for the groups of a class, with their expected costs.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "assur/plan.hpp"

namespace assur {

// Unknowns from which a GPU is considered; fewer are solved before a copy to it and back has ended.
inline constexpr std::int32_t kWorthDevice = 100;

// Data for the comparison of candidates.
struct Scales {
  const PerformanceModel& model;
  std::span<const Backend> table;
  std::span<const std::string> without;
  double tie = 0.02;  // costs with a smaller relative difference are equal; times are hardly known better
};

// Groups of a class that are solved at the same time.
struct Load {
  std::int32_t groups = 1;
  std::int32_t threads = 1;   // threads that share the groups
  std::int32_t unknowns = 1;  // of each group
};

// Time of work that p threads share. makespan: time of the longest share; work: time of all work on one thread;
// contention: factor for each thread while all of them are busy.
[[nodiscard]] double together(double makespan, double work, std::int32_t p, double contention);

// Candidates with up to `most_lanes` lanes and `most_q` threads within the linear algebra, with the time of one call
// for W groups; 0 for candidates that cannot run. In no particular order.
[[nodiscard]] std::vector<Candidate> offers(const Shape& shape, std::int32_t most_lanes, std::int32_t most_q,
                                            const Scales& scales);

// The offers with up to `most_q` threads within the linear algebra, each with its time for all loads.
[[nodiscard]] std::vector<Candidate> weigh(const std::vector<Candidate>& offers, std::span<const Load> loads,
                                           std::int32_t most_q, const Scales& scales);

// True if a solver can solve groups of this shape here, is not left out, and was accurate.
[[nodiscard]] bool can_run(const Strategy& strategy, const Shape& shape, const Scales& scales);

// Sorts: the fastest first, those that cannot run last. Among candidates within the tie, one with the fewest threads is
// first; then one that computes in double.
void rank(std::vector<Candidate>& candidates, double tie);

// Throws Error (input) if one of the names is not a backend.
void check_names(std::span<const std::string> without, std::span<const Backend> table);

}  // namespace assur
