// What kernels cost where nothing has been measured, and how often a step needs each.
#pragma once

#include "assur/performance.hpp"

namespace assur {

// Seconds of one call: operations and overheads as `assur tune` measured them on one processor of 2024 with AVX-512.
// Good to a factor of two or so, which is enough for a sensible plan and to share packs out.
[[nodiscard]] double prior_seconds(Kernel kernel, const Shape& shape, const Strategy& strategy);

// What a step of a mechanism takes beyond its packs. pieces: of its outputs, the terms of those that are linear, and
// for any other as many as take its time.
[[nodiscard]] double prior_around_seconds(std::int64_t unknowns, std::int64_t pieces = 0);

[[nodiscard]] double prior_meeting_seconds(std::int32_t p);
inline constexpr double kPriorHandover = 0.5e-9;  // s for each double that another thread changes: meetings, n = 4000
inline constexpr double kAloneBeforeMeeting = 5e-6;  // s, as in a step: threads that wait so long do not spin any more

// Calls for one step of a pack, with one Newton iteration as a good prediction needs.
struct StepCounts {
  double evaluations = 0, factorizations = 0, solutions = 0;
};
// `derivatives`: 0, 1 or 2.
[[nodiscard]] StepCounts step_counts(const Strategy& strategy, int derivatives);

// Small groups take their whole step in registers: no kernels to compose it from.
[[nodiscard]] bool in_registers(const Shape& shape, const Strategy& strategy);

[[nodiscard]] bool is_dense(const Strategy& strategy);

}  // namespace assur
