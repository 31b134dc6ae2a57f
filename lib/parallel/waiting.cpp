#include "parallel/waiting.hpp"

#include <thread>

namespace assur {
namespace {

constexpr int kSpins = 400;    // some 10 us: longer than threads of one team are apart as a rule
constexpr int kYields = 2000;  // about 1 ms on a free core: longer than what lies between two factorisations of a step

void relax() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

}  // namespace

void wait_while(const std::atomic<std::uint32_t>& word, std::uint32_t old) {
  const auto changed = [&] { return word.load(std::memory_order_acquire) != old; };
  for (int i = 0; i < kSpins; ++i) {
    if (changed()) return;
    relax();
  }
  for (int i = 0; i < kYields; ++i) {
    if (changed()) return;
    std::this_thread::yield();
  }
  while (!changed()) word.wait(old, std::memory_order_acquire);
}

}  // namespace assur
