// Numerical rank of equations at several postures: finds redundant equations and undetermined unknowns.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "assur/structure.hpp"
#include "equations/system.hpp"

namespace assur {

// Steps of the time grid that are examined behind the start. A choice: enough to leave a singular start.
inline constexpr int kStepsOnPath = 7;
// Displacement of drivers to other postures, rad or internal units. A choice: far above the errors of postures and far
// below typical lengths, which are 1.
inline constexpr double kNearby = 0.05;
// Pivots of rows of length 1 below this count as 0. A choice: errors of postures, up to kConsistent, are far smaller.
inline constexpr double kDependentRows = 1e-7;

// The result of study_rank().
struct RankStudy {
  std::vector<Index> kept;            // an independent subset of the equations
  std::vector<Index> dropped;         // the others
  std::vector<Redundancy> redundant;  // one for each dropped equation
  std::vector<Index> undetermined;    // unknowns that take part in the null space at every posture
  Index rank = 0;                     // the largest over the postures
  bool singular_start = false;        // the rank at the start is smaller than elsewhere on the path
  double residual = 0;                // relative residual of all equations at the start; large: contradictory
};

// Examines the posture q, which is fitted to the equations first. If `laws_from` has a time, also examines two later
// postures of the laws; empty if a program may move the drivers elsewhere. rather_dropped: equations; the choice begins
// with them, unless the matrix is large.
[[nodiscard]] RankStudy study_rank(const System& system, std::span<const Index> equations,
                                   std::span<const Index> unknowns, std::optional<double> laws_from,
                                   std::span<const Index> rather_dropped, std::vector<double>& q,
                                   std::vector<Index>& column);

}  // namespace assur
