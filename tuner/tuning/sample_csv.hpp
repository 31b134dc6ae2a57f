// Samples as CSV, for people and other programs.
#pragma once

#include <ostream>
#include <span>

#include "assur/performance.hpp"

namespace assur::tuning {

// kernel, n, nnz, fill, operations, depth, terms, pattern, groups, strategy, seconds, spread, repetitions,
// backward_error, forward_error, raw_seconds (by the clock), slowness; numbers with up to 17 digits, empty for NaN (not
// measured).
void write_csv(std::ostream& out, std::span<const Sample> samples);

}  // namespace assur::tuning
