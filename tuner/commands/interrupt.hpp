// Interrupts of a run: Ctrl-C, or a request of the system to end.
#pragma once

#include <array>
#include <csignal>

namespace assur::command {

// During its lifetime, the first SIGINT or SIGTERM sets a flag only; the second one of the same kind ends the program.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  [[nodiscard]] static bool requested() { return flag_ != 0; }

 private:
  static void note(int) { flag_ = 1; }

  static constexpr std::array<int, 2> kSignals = {SIGINT, SIGTERM};
  static inline volatile std::sig_atomic_t flag_ = 0;
  std::array<struct sigaction, kSignals.size()> before_{};
};

}  // namespace assur::command
