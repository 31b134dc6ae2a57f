// Runs work in the child of a fork().
#pragma once

#include <sys/wait.h>
#include <unistd.h>

namespace assur::test {

// Runs `work` in the child of a fork. Returns its exit status, or 127 if a signal ended it, as happens after a minute.
template <class Work>
int in_a_child(Work&& work) {
  const pid_t child = fork();
  if (child == 0) {
    alarm(60);
    _exit(work());
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 127;
}

}  // namespace assur::test
