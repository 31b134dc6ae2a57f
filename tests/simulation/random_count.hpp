// How many random scenes a test draws.
#pragma once

#include <algorithm>
#include <cstdlib>

namespace assur::test {

// So many; the variable ASSUR_RANDOM_SCENES asks for more.
inline int random_count(int usual) {
  const char* const wanted = std::getenv("ASSUR_RANDOM_SCENES");
  return wanted != nullptr ? std::max(std::atoi(wanted), 1) : usual;
}

}  // namespace assur::test
