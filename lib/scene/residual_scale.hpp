// What the size of a residual is compared with, beside residual_scale() of system.hpp.
#pragma once

#include <span>

#include "scene/system.hpp"

namespace assur {

// Relative residual up to which an equation that depends on others, and is not solved, still holds.
inline constexpr double kConsistent = 1e-10;

// A factor of a product counts as this much at least, and so does each argument of a callback; internal units.
inline constexpr double kLeastFactor = 0x1p-10;

// sum_j |dPhi/dq_j| |q_j| + |constant|: the rounding of a residual is relative to it. residual_scale() is the same, but
// at least what the terms are where none of them vanishes by the directions at hand: |d| |e| and a little more for
// d . e, and for a linear form one internal unit for each of its coordinates. Squares vanish with what they measure and
// count as they are.
[[nodiscard]] double size_of_terms(const System& s, Index equation, std::span<const double> q);

}  // namespace assur
