// Number of random scenes of a test.
#pragma once

#include <algorithm>
#include <cstdlib>

namespace assur::test {

// `usual`, or the value of the variable ASSUR_RANDOM_SCENES.
inline int random_count(int usual) {
  const char* const wanted = std::getenv("ASSUR_RANDOM_SCENES");
  return wanted != nullptr ? std::max(std::atoi(wanted), 1) : usual;
}

}  // namespace assur::test
