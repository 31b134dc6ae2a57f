// The numbers of a pack as memory of a step program (program/group_step.hpp).
#pragma once

#include <cstddef>

#include "group/pack.hpp"
#include "program/step_program.hpp"

namespace assur {

// Sets what a program may read and write of a pack in a state, but for its inputs. memory: kMemories. [d]: d-th
// derivatives
inline void point_to(const Pack& pack, double* const (&state)[3], double** memory) {
  const auto put = [&](Memory m, const double* at) { memory[static_cast<std::size_t>(m)] = const_cast<double*>(at); };
  put(Memory::coefficients, pack.coefficients.data());
  put(Memory::unknowns, state[0] + pack.unknowns);
  put(Memory::rates, state[1] + pack.unknowns);
  put(Memory::accelerations, state[2] + pack.unknowns);
  put(Memory::pivots, pack.swaps.data());
  put(Memory::anchor, pack.anchor.data());
  put(Memory::omega, pack.omega.data());
  put(Memory::ball_used, pack.ball_used.data());
}

// The same for what new anchors change besides.
inline void point_to_anchor(const Pack& pack, double** memory) {
  const auto put = [&](Memory m, const LaneArray& at) {
    memory[static_cast<std::size_t>(m)] = const_cast<double*>(at.data());
  };
  put(Memory::lipschitz, pack.lipschitz);
  put(Memory::anchor_rates, pack.anchor_rates);
  put(Memory::anchor_time, pack.anchor_time);
}

}  // namespace assur
