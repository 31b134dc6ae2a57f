// Waiting for another thread. A thread first spins for a few microseconds, because the other one mostly runs on another
// core and is nearly done; then it yields, for the case of more threads than cores; then it sleeps, so that an idle
// thread costs nothing.
#pragma once

#include <atomic>
#include <cstdint>

namespace assur {

// Placement of the threads that wait for each other.
enum class Waiting : std::uint8_t {
  shared,   // usually a core for each thread: spins, yields, sleeps
  crowded,  // more threads than cores: yields at once, then sleeps
  pinned,   // a dedicated core for each thread: spins only
};

// Returns when `word` is no longer `old`; acquires the writes before the change.
void wait_while(const std::atomic<std::uint32_t>& word, std::uint32_t old, Waiting waiting = Waiting::shared);

// Changes `word` and wakes the threads that wait for it; releases the writes before the change. Not inline: each shared
// library would have its own list of waiting threads (std::atomic::notify_all), and would not wake those of another.
void advance(std::atomic<std::uint32_t>& word);

}  // namespace assur
