// Diagnosis of a pack that cannot go on: the block that is nearest to a singular posture, and the type of the posture.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "assur/status.hpp"
#include "groups/branch.hpp"
#include "groups/workspace.hpp"

namespace assur {

// The diagnosis.
struct Singularity {
  Status status;            // fold: the rates grow as they do towards a fold (no proof of a fold);
                            // change_point_passed: they do not grow, passing may be tried; else branch_unknown
  std::int32_t block = -1;  // -1: no block was examined
  int lane = 0;
  double smallest = 0;        // singular value of the block
  std::vector<double> reads;  // inputs of the block, internal units
};

// Memory of diagnoses.
struct DiagnosisMemory {
  std::vector<double> matrix;                            // of a block
  std::vector<double> diagonal, beside;                  // of its bidiagonal form
  std::vector<double> right_side, vector, image, spare;  // its unknowns
  LaneArray rates, rhs;
  std::size_t most_read = 0;  // inputs of a block

  // For all blocks of a class.
  void reserve(const Workspace& work, const BlockConditions& blocks);
};

// Allocates nothing if `memory` is reserved for the class, and into.reads for DiagnosisMemory::most_read. state[d]:
// d-th derivative of all coordinates.
void nearest_singularity(Workspace& work, const BlockConditions& blocks, const Pack& pack, double* const (&state)[3],
                         DiagnosisMemory& memory, Singularity& into);

}  // namespace assur
