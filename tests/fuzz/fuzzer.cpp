// A libFuzzer program. ASSUR_FUZZ is the function of targets.hpp that it calls.
#include <cstddef>
#include <cstdint>

#include "fuzz/targets.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  (void)assur::fuzz::ASSUR_FUZZ({reinterpret_cast<const char*>(data), size});
  return 0;
}
