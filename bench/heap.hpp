// The heap of this program, counted at malloc and free: exact, unlike the resident set, and it includes what the C
// libraries behind us take.
#pragma once

#include <cstdint>

namespace assur::bench {

struct Heap {
  std::int64_t live = 0;  // bytes handed out and not yet given back
  std::int64_t peak = 0;  // the most of it since forget_peak()
};

[[nodiscard]] Heap heap();
void forget_peak();

}  // namespace assur::bench
