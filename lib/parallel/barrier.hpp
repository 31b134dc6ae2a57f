// Where the threads of a team meet. p teams have p barriers, so that no team waits for another.
#pragma once

#include <atomic>
#include <cstdint>

#include "parallel/waiting.hpp"

namespace assur {

class Barrier {
 public:
  explicit Barrier(int threads) : threads_(static_cast<std::uint32_t>(threads)), missing_(threads_) {}

  // Returns when `threads` have arrived; what each wrote before is then seen by all. Can be used again at once.
  void arrive_and_wait() {
    const std::uint32_t round = round_.load(std::memory_order_relaxed);  // cannot end before this thread has arrived
    if (missing_.fetch_sub(1, std::memory_order_acq_rel) == 1) {
      missing_.store(threads_, std::memory_order_relaxed);
      advance(round_);
    } else {
      wait_while(round_, round);
    }
  }

 private:
  const std::uint32_t threads_;
  alignas(64) std::atomic<std::uint32_t> missing_;
  alignas(64) std::atomic<std::uint32_t> round_{0};  // the sense, as a number: which meeting is next
};

}  // namespace assur
