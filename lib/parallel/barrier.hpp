// Barrier for the threads of a team. Each team has its own barrier, so that no team waits for another.
#pragma once

#include <atomic>
#include <cstdint>

#include "parallel/waiting.hpp"

namespace assur {

// The barrier.
class Barrier {
 public:
  explicit Barrier(int threads, Waiting waiting = Waiting::shared)
      : threads_(static_cast<std::uint32_t>(threads)), waiting_(waiting), missing_(threads_) {}

  // Returns when `threads` threads have arrived; earlier writes of each thread are then visible to all. Can be used
  // again at once. False if the barrier was broken: not all threads have arrived, and none waits any more.
  bool arrive_and_wait() {
    const std::uint32_t round = round_.load(std::memory_order_acquire);  // cannot end before this thread has arrived
    if (broken()) return false;
    if (missing_.fetch_sub(1, std::memory_order_acq_rel) == 1) {
      missing_.store(threads_, std::memory_order_relaxed);
      advance(round_);
      return true;
    }
    wait_while(round_, round, waiting_);
    return !broken();
  }

  // Breaks the barrier, because one thread will not come: releases all threads that wait or will wait.
  void break_up() {
    broken_.store(true, std::memory_order_release);
    advance(round_);
  }
  [[nodiscard]] bool broken() const { return broken_.load(std::memory_order_acquire); }

  // Makes a broken barrier usable again. No thread may be at the barrier.
  void mend() {
    missing_.store(threads_, std::memory_order_relaxed);
    broken_.store(false, std::memory_order_relaxed);
  }

 private:
  const std::uint32_t threads_;
  const Waiting waiting_;
  alignas(64) std::atomic<std::uint32_t> missing_;
  alignas(64) std::atomic<std::uint32_t> round_{0};  // number of the next meeting
  std::atomic<bool> broken_ = false;
};

}  // namespace assur
