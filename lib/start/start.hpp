// The start posture of a whole system, with its findings: redundant or contradictory equations, undetermined unknowns,
// blocks that cannot be assembled.
#pragma once

#include <vector>

#include "graph/blocks.hpp"
#include "start/findings.hpp"

namespace assur {

// Equations, unknowns and posture.
struct Problem {
  std::vector<Index> unknowns;
  std::vector<Index> equations;
  Blocks blocks;                   // irreducible blocks of these equations and unknowns
  std::vector<double> q;           // all coordinates: the guess, then the start posture
  double time = 0;                 // of q
  bool is_guess = true;            // true: q is a guess; false: q is a posture already
  std::vector<Index> checked;      // equations that are rather dropped than kept, if they are redundant
  std::vector<Index> left_behind;  // unknowns that cannot follow the drivers to the start, and that no output needs
};

// Given unknowns, q and time, finds equations and blocks, and moves q to the start posture. Checks that every driver
// has the value of its law there, because the equations may leave its sign open. Sets checks, redundant, undetermined,
// cannot_assemble and notes of `out`. out.mobility must hold the freedoms of the drivers, and becomes the mobility.
void assemble_start(const System& system, Problem& problem, StartFindings& out);

}  // namespace assur
