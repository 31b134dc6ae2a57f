// Processes that keep the processors busy during the lifetime of the object.
#pragma once

#include <sys/types.h>

#include <vector>

namespace assur::bench {

class Crowd {
 public:
  // Throws Error (environment) if a process cannot be started.
  explicit Crowd(int processes);
  ~Crowd();
  Crowd(const Crowd&) = delete;
  Crowd& operator=(const Crowd&) = delete;

 private:
  void disperse();

  std::vector<pid_t> processes_;
};

}  // namespace assur::bench
