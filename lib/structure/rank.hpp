// Numerical rank of a part of the equations at several postures: redundant equations and undetermined unknowns by name.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "assur/structure.hpp"
#include "scene/system.hpp"

namespace assur {

struct RankStudy {
  std::vector<Index> kept;            // an independent set of the equations
  std::vector<Index> dropped;         // the others
  std::vector<Redundancy> redundant;  // one for each dropped equation
  std::vector<Index> undetermined;    // unknowns in the null space of every posture
  Index rank = 0;                     // the largest over the postures
  bool singular_start = false;        // the rank at the start is smaller than elsewhere on the path
  double residual = 0;                // relative, of all equations at the start; large: inconsistent
};

// Looks at the posture q, which is fitted to the equations first, and at two further ones where the laws lead from a
// time on, if there is one: a program may lead elsewhere.
[[nodiscard]] RankStudy study_rank(const System& system, std::span<const Index> equations,
                                   std::span<const Index> unknowns, std::optional<double> laws_from,
                                   std::vector<double>& q, std::vector<Index>& column);

}  // namespace assur
