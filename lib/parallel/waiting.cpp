#include "parallel/waiting.hpp"

#include <thread>

namespace assur {
namespace {

// Some 2.5 us. Where the system puts two threads on one core, each wait wastes all of it: Team::run() by two threads
// then takes 7 us, with 400 spins 22 (a core each: 0.23 us).
constexpr int kSpins = 100;
constexpr int kYields = 500;  // some 200 us on a free core: what one takes for a panel that the others wait for

void relax() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

}  // namespace

void wait_while(const std::atomic<std::uint32_t>& word, std::uint32_t old, Waiting waiting) {
  const auto changed = [&] { return word.load(std::memory_order_acquire) != old; };
  while (waiting == Waiting::pinned) {
    if (changed()) return;
    relax();
  }
  for (int i = 0; i < kSpins && waiting == Waiting::shared; ++i) {
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
