// Cost of kernels without measurements, and the number of calls in a step.
#pragma once

#include "assur/performance.hpp"

namespace assur {

// Seconds of one call, from operations and overheads that `assur tune` measured on one processor of 2024 with AVX-512.
// The error is about a factor of two, which is enough for a sensible plan and for sharing packs among threads.
[[nodiscard]] double prior_seconds(Kernel kernel, const Shape& shape, const Strategy& strategy);

// Seconds of a step of a mechanism beyond its packs. pieces: terms of linear outputs; every other output is counted as
// the number of terms that take the same time.
[[nodiscard]] double prior_around_seconds(std::int64_t unknowns, std::int64_t pieces = 0);

[[nodiscard]] double prior_meeting_seconds(std::int32_t p);
inline constexpr double kPriorHandover =
    0.5e-9;  // s for each double that another thread changes; measured by meetings, n = 4000
inline constexpr double kAloneBeforeMeeting = 5e-6;  // s, as in a step; threads that wait this long no longer spin

// Number of calls in one step of a pack, with one Newton iteration.
struct StepCounts {
  double evaluations = 0, factorizations = 0, solutions = 0;
};
// `derivatives`: 0, 1 or 2.
[[nodiscard]] StepCounts step_counts(const Strategy& strategy, int derivatives);

// How a pack takes its step. Only the time of composed steps is that of kernels.
enum class StepPath : std::uint8_t {
  composed,      // evaluations, factorisations and solutions, one after another
  in_registers,  // a small group, or +together
  one_program,   // machine code for the step of the class, where the processor has it
};
[[nodiscard]] StepPath path_of(const Shape& shape, const Strategy& strategy);

[[nodiscard]] bool is_dense(const Strategy& strategy);

}  // namespace assur
