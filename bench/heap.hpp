// The heap of this program, counted at malloc and free. The count is exact, unlike the resident set, and includes the
// allocations of C libraries.
#pragma once

#include <cstdint>

namespace assur::bench {

struct Heap {
  std::int64_t live = 0;  // bytes handed out and not yet given back
  std::int64_t peak = 0;  // largest value of `live` since forget_peak()
};

[[nodiscard]] Heap heap();
void forget_peak();

}  // namespace assur::bench
