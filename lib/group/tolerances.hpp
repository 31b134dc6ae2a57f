// When an equation counts as solved: |Phi_i| against sum_j |dPhi_i/dq_j| |q_j| + |constant|.
#pragma once

#include "numbers.hpp"

namespace assur {

inline constexpr double kConverged = 8 * kEps;
inline constexpr double kRoundingLevel = 1e-12;  // where a residual that no longer falls is taken for rounding

inline constexpr double kSumRounding = 2 * kEps;  // of a sum, relative to its terms

// It did not fall to a quarter in the last iteration.
[[nodiscard]] inline bool only_rounding_is_left(double relative, double before) {
  return relative <= kRoundingLevel && relative > before / 4;
}

}  // namespace assur
