// The start posture of a whole system, and what it shows: equations that are redundant or contradict each other,
// unknowns that nothing fixes, blocks that cannot be assembled.
#pragma once

#include <vector>

#include "assur/structure.hpp"
#include "structure/blocks.hpp"

namespace assur {

// What is solved, and where.
struct Problem {
  std::vector<Index> unknowns;
  std::vector<Index> equations;
  Blocks blocks;          // of these two
  std::vector<double> q;  // all coordinates: the guess, then the start posture
  double time = 0;        // of q
  bool is_guess = true;   // q, before it is assembled: else it is a posture
};

// Given the unknowns, q and time, finds the equations and blocks and moves q to the start posture, in which every
// driver has the value of its law: the equations do not see the sign of all of them. Adds to `out`:
// checks, redundant, undetermined, cannot_assemble and notes. Its mobility is the drivers' freedoms before, and what
// the rank says after.
void assemble_start(const System& system, Problem& problem, Structure& out);

}  // namespace assur
