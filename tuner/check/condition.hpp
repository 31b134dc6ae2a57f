// The condition of postures: the amplification of errors.
#pragma once

#include <functional>
#include <optional>

#include "assur/simulator.hpp"

namespace assur::check {

// The condition of the worst posture of a run: max |J^-1| s / max |q| with s_i = sum_j |dPhi_i/dq_j| |q_j| + |constant|
// (docs/accuracy.md). If every equation holds to a relative residual r (ErrorFigures::position), the error of every
// coordinate, relative to the largest coordinate, is at most r times the condition. In large systems, only some
// postures are examined. Empty for more than 400 unknowns, or if nothing is solved.
[[nodiscard]] std::optional<double> worst_condition(const Prepared& prepared, const std::function<bool()>& stop);

}  // namespace assur::check
