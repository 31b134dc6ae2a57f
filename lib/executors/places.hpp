// Where an executor without registers keeps the values of a phase: few places, so that they stay in the cache.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "program/step_program.hpp"

namespace assur {

struct Places {
  std::vector<std::uint32_t> of;  // each instruction
  std::size_t count = 0;
};

// A place is used again after the last use of its value. An instruction never writes to a place that it reads, because
// it processes its lanes one vector after the other.
[[nodiscard]] Places places_of(const Phase& phase);

}  // namespace assur
