// Figures that no measurement gives.
#pragma once

#include <string_view>

#include "assur/performance.hpp"

namespace assur {

// Times outside these bounds are no measurements, s. Between them, squares and quotients of times and their conversion
// to any possible pace are finite.
inline constexpr double kLeastTime = 1e-15, kMostTime = 1e9;

[[nodiscard]] inline bool is_possible_time(double seconds) { return seconds >= kLeastTime && seconds <= kMostTime; }

// What is impossible in a sample and what is wanted, e.g. "its time must be 1e-15 to 1e9 s"; "" if nothing is. The
// slowness is not checked, because its unit differs.
[[nodiscard]] std::string_view why_impossible(const Sample& sample);

}  // namespace assur
