// Why a pack cannot go on: the block that is nearest to a singular posture, and what kind of posture that is.
#pragma once

#include <cstdint>
#include <vector>

#include "assur/status.hpp"
#include "group/branch.hpp"
#include "group/workspace.hpp"

namespace assur {

struct Singularity {
  Status status;            // limit_reached: its rates grow as they do towards a fold, which is no evidence of one
                            // yet; change_point_passed: they do not, passing may be tried; else branch_unknown
  std::int32_t block = -1;  // -1: none was looked at
  int lane = 0;
  double smallest = 0;        // singular value of the block
  std::vector<double> reads;  // what the block reads of others, internal units
};

// By dense SVDs; allocates. state[d]: d-th derivative of all coordinates.
[[nodiscard]] Singularity nearest_singularity(Workspace& work, const BlockConditions& blocks, const Pack& pack,
                                              double* const (&state)[3]);

}  // namespace assur
