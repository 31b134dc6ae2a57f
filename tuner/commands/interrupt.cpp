#include "commands/interrupt.hpp"

namespace assur::command {

Interrupt::Interrupt() {
  flag_ = 0;
  struct sigaction action {};
  action.sa_handler = note;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigaction(SIGINT, &action, &before_);
}

Interrupt::~Interrupt() { sigaction(SIGINT, &before_, nullptr); }

}  // namespace assur::command
