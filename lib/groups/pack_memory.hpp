// The numbers of a pack as memory of a step program (program/group_step.hpp).
#pragma once

#include <cstddef>
#include <span>

#include "groups/pack.hpp"
#include "program/step_program.hpp"

namespace assur {

// Points to the arrays of a pack that a program may read and write in place. memory: kMemories
inline void point_to(const Pack& pack, double** memory) {
  const auto put = [&](Memory m, std::span<const double> numbers) {
    memory[static_cast<std::size_t>(m)] = const_cast<double*>(numbers.data());
  };
  put(Memory::coefficients, pack.coefficients);
  put(Memory::anchor, pack.anchor);
  put(Memory::anchor_rates, pack.anchor_rates);
  put(Memory::anchor_time, pack.anchor_time);
  put(Memory::omega, pack.omega);
  put(Memory::ball_used, pack.ball_used);
  put(Memory::lipschitz, pack.lipschitz);
}

// The same of its unknowns in a state. [d]: d-th derivatives
inline void point_to_unknowns(const Pack& pack, double* const (&state)[3], double** memory) {
  memory[static_cast<std::size_t>(Memory::unknowns)] = state[0] + pack.unknowns;
  memory[static_cast<std::size_t>(Memory::rates)] = state[1] + pack.unknowns;
  memory[static_cast<std::size_t>(Memory::accelerations)] = state[2] + pack.unknowns;
}

}  // namespace assur
