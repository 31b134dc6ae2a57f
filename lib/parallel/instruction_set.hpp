// The instruction set of the inner loops.
#pragma once

namespace assur {

// The widest set of this processor that the library is compiled for, named as in Highway: "AVX2", "NEON", ...
[[nodiscard]] const char* instruction_set();

}  // namespace assur
