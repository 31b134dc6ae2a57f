// Scales of residuals; see also residual_scale() in system.hpp.
#pragma once

#include <span>

#include "equations/system.hpp"

namespace assur {

// Largest relative residual at which a redundant equation counts as satisfied.
inline constexpr double kConsistent = 1e-10;

// Least magnitude of a factor of a product, and of an argument of a callback, in a scale; internal units.
inline constexpr double kLeastFactor = 0x1p-10;

// sum_j |dPhi/dq_j| |q_j| + |constant|: rounding of a residual is relative to it. residual_scale() is the same with a
// lower bound, for terms that vanish because directions are perpendicular: about |d| |e| for d . e, and one internal
// unit for each coordinate of a linear form. Squares have no lower bound, because they vanish with the quantity that
// they measure.
[[nodiscard]] double size_of_terms(const System& s, Index equation, std::span<const double> q);

}  // namespace assur
