// How much a posture enlarges errors.
#pragma once

#include <functional>
#include <optional>

#include "assur/simulator.hpp"

namespace assur::check {

// The condition of a scene's worst posture: if every equation holds to a relative residual r (ErrorFigures::position),
// no coordinate is off by more than r times this, relative to the largest: max |J^-1| s / max |q| with s_i = sum_j
// |dPhi_i/dq_j| |q_j| + |constant|, as in docs/accuracy.md. Of a run as far as it gets, over some of its postures where
// they are large; nothing beyond 400 unknowns, or where nothing is solved.
[[nodiscard]] std::optional<double> worst_condition(const Prepared& prepared, const std::function<bool()>& stop);

}  // namespace assur::check
