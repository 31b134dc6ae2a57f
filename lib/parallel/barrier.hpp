// Where the threads of a team meet. p teams have p barriers, so that no team waits for another.
#pragma once

#include <atomic>
#include <cstdint>

#include "parallel/waiting.hpp"

namespace assur {

class Barrier {
 public:
  explicit Barrier(int threads, Waiting waiting = Waiting::shared)
      : threads_(static_cast<std::uint32_t>(threads)), waiting_(waiting), missing_(threads_) {}

  // Returns when `threads` have arrived; what each wrote before is then seen by all. Can be used again at once. False
  // if it was broken: then not all have arrived, and nobody waits here any more.
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

  // Sends home who waits here or will, because one will not come.
  void break_up() {
    broken_.store(true, std::memory_order_release);
    advance(round_);
  }
  [[nodiscard]] bool broken() const { return broken_.load(std::memory_order_acquire); }

  // As new. Call while nobody is here.
  void mend() {
    missing_.store(threads_, std::memory_order_relaxed);
    broken_.store(false, std::memory_order_relaxed);
  }

 private:
  const std::uint32_t threads_;
  const Waiting waiting_;
  alignas(64) std::atomic<std::uint32_t> missing_;
  alignas(64) std::atomic<std::uint32_t> round_{0};  // the sense, as a number: which meeting is next
  std::atomic<bool> broken_ = false;
};

}  // namespace assur
