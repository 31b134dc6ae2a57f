// OPENBLAS_CORETYPE makes OpenBLAS use the kernels of another processor. The tests are skipped if this processor cannot
// run them, or if the library lacks them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <string>

#include "parallel/thread_state.hpp"

namespace assur::test {
namespace {

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

bool can_run([[maybe_unused]] const std::string& core) {
#if defined(__x86_64__)
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  const bool avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") &&
                      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
                      __builtin_cpu_supports("avx512vl");
  if (core == "haswell" || core == "zen") return avx2;
  if (core == "skylakex") return avx512;
  if (core == "cooperlake") return avx512 && __builtin_cpu_supports("avx512bf16");
#endif
  return true;  // kernels for every x86-64, or a core that only the user knows
}

class ImitatedCore : public testing::Environment {
  void SetUp() override {
    const char* const core = std::getenv("OPENBLAS_CORETYPE");
    if (core == nullptr || *core == '\0') return;
    if (!can_run(lower(core))) GTEST_SKIP() << "this processor lacks instructions of " << core;
    const std::string library = blas_version();
    if (!lower(library).ends_with(", " + lower(core))) GTEST_SKIP() << library << " has no kernels of " << core;
  }
};
const auto* const kAdded = testing::AddGlobalTestEnvironment(new ImitatedCore);

}  // namespace
}  // namespace assur::test
