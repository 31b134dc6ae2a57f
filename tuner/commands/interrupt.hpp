// Ctrl-C while a run goes on.
#pragma once

#include <csignal>

namespace assur::command {

// From construction to destruction the first SIGINT only sets a flag; the second one ends the program.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  [[nodiscard]] static bool requested() { return flag_ != 0; }

 private:
  static void note(int) { flag_ = 1; }

  static inline volatile std::sig_atomic_t flag_ = 0;
  struct sigaction before_ {};
};

}  // namespace assur::command
