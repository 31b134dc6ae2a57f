#include "parallel/waiting.hpp"

#include <thread>

namespace assur {
namespace {

// About 2.5 us. If two threads share one core, each wait wastes all of it: Team::run() by two threads then takes 7 us,
// and 22 us with 400 spins (0.23 us on separate cores).
constexpr int kSpins = 100;
constexpr int kYields =
    500;  // about 200 us on a free core: one thread factorises a panel in this time while others wait

void relax() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__) || (defined(__ARM_ARCH) && __ARM_ARCH >= 7)
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

void advance(std::atomic<std::uint32_t>& word) {
  word.fetch_add(1, std::memory_order_acq_rel);
  word.notify_all();
}

}  // namespace assur
