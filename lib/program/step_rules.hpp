// Rules for the step of a group, also in registers (SmallStep): when an equation counts as solved, when a step stays on
// its branch, and when a linear solution is good enough.
#pragma once

#include <array>

#include "numbers.hpp"

namespace assur {

// ---- equations: |Phi_i| against sum_j |dPhi_i/dq_j| |q_j| + |constant|

inline constexpr double kConverged = 8 * kEps;    // the equation counts as solved
inline constexpr double kRoundingLevel = 1e-12;   // below this, a residual that no longer falls counts as rounding
inline constexpr double kSumRounding = 2 * kEps;  // rounding of a sum, relative to its terms

// True if the last iteration did not reduce the residual to a quarter.
[[nodiscard]] inline bool falls_slowly(double relative, double before) { return relative > before / 4; }
[[nodiscard]] inline bool only_rounding_is_left(double relative, double before) {
  return relative <= kRoundingLevel && falls_slowly(relative, before);
}

inline constexpr int kSlowIterations = 2;    // steps seldom take this many iterations
inline constexpr int kMostSearching = 40;    // iterations at a fold, where each one gains one bit
inline constexpr double kContraction = 0.1;  // ratio of successive corrections, if it is the only test of convergence

// ---- branch: see branch.hpp

inline constexpr double kBall = 0.7;          // part of the ball that a step may use
inline constexpr double kRoundingRoom = 0.1;  // part of the ball that rounding of the posture may take
inline constexpr std::array kAlongTheTube = {0.0, 0.25, 0.5, 0.75};  // parts of the way from the anchor

// Newton's method converges to the one solution nearby if omega |first correction| is at most 1/4 of the rest of the
// ball.
[[nodiscard]] inline double largest_first_correction(double ball_used) { return 0.25 * (1 - ball_used); }

// True if the next step of this length stays inside the ball, too.
[[nodiscard]] inline bool ball_lasts(double used, double before) {
  return used + 2 * (used > before ? used - before : 0.0) <= kBall;
}

// ---- linear systems: normwise residuals

inline constexpr int kWithoutPivots = 3;      // so many unknowns are solved by cofactors, which need no pivots
inline constexpr double kLinear = 8 * kEps;   // of a refined solution
inline constexpr double kPivotsGrew = 1e-13;  // a direct solution has a smaller residual unless pivots grew
inline constexpr int kMostRefinements = 6;    // a choice: each gains digits, or the pivots are bad

}  // namespace assur
