// Number of random scenes of a test.
#pragma once

#include <algorithm>
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

}  // namespace assur::test
