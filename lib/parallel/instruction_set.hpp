// The instructions that the inner loops are run with.
#pragma once

namespace assur {

// The widest set that this processor has and the library is compiled for, as Highway calls it: "SSE4", "AVX2", ...
[[nodiscard]] const char* instruction_set();

}  // namespace assur
