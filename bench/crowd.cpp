#include "crowd.hpp"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "assur/status.hpp"

namespace assur::bench {
namespace {

constexpr unsigned kLongest = 120;  // s: a process ends after this time, even if its parent was killed

// A child of fork() in a process with threads may call few functions, so this is all that it does.
[[noreturn]] void keep_busy(pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(0);
  alarm(kLongest);
  const volatile bool busy = true;
  while (busy) {
  }
  _exit(0);
}

}  // namespace

Crowd::Crowd(int processes) {
  const pid_t parent = getpid();
  for (int i = 0; i < processes; ++i) {
    const pid_t process = fork();
    if (process == 0) keep_busy(parent);
    if (process < 0) {
      const std::string why = std::strerror(errno);
      disperse();
      throw Error(Error::Kind::environment, "cannot start a busy process: " + why);
    }
    processes_.push_back(process);
  }
}

Crowd::~Crowd() { disperse(); }

void Crowd::disperse() {
  for (const pid_t process : processes_) kill(process, SIGKILL);
  for (const pid_t process : processes_) waitpid(process, nullptr, 0);
  processes_.clear();
}

}  // namespace assur::bench
