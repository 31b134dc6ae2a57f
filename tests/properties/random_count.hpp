// Number of random scenes of a test, and the seed of the first one.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "sanitizers.hpp"

namespace assur::test {

// The value of the variable ASSUR_RANDOM_SCENES; without it `usual`, and a quarter of it with sanitizers, which
// multiply the time of a test.
inline int random_count(int usual) {
  const char* const wanted = std::getenv("ASSUR_RANDOM_SCENES");
  if (wanted != nullptr) return std::max(std::atoi(wanted), 1);
#ifdef ASSUR_ADDRESS_SANITIZER
  return (usual + 3) / 4;
#else
  return usual;
#endif
}

// The value of the variable ASSUR_RANDOM_SEED; without it 1.
inline std::uint64_t first_seed() {
  const char* const wanted = std::getenv("ASSUR_RANDOM_SEED");
  return wanted != nullptr ? std::strtoull(wanted, nullptr, 10) : 1;
}

}  // namespace assur::test
