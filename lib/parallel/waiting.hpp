// How a thread waits for another: it spins for a few microseconds, since the other mostly works on a core of its own
// and is nearly done; then it yields, so that more threads than cores get on; then it sleeps, so that an idle thread
// costs nothing.
#pragma once

#include <atomic>
#include <cstdint>

namespace assur {

// Where those that wait for each other run.
enum class Waiting : std::uint8_t {
  shared,   // a core for each thread, as a rule: spins, yields, sleeps
  crowded,  // more threads than cores: yields at once, then sleeps
  pinned,   // a core of its own, that nobody else needs: spins only
};

// Returns once `word` is no longer `old`; acquires what was written before it changed.
void wait_while(const std::atomic<std::uint32_t>& word, std::uint32_t old, Waiting waiting = Waiting::shared);

// Changes `word` and wakes who waits for it; releases what was written before.
inline void advance(std::atomic<std::uint32_t>& word) {
  word.fetch_add(1, std::memory_order_acq_rel);
  word.notify_all();
}

}  // namespace assur
