// Workloads: work that can be repeated and timed.
#pragma once

#include <chrono>

namespace assur::measure {

class Workload {
 public:
  virtual ~Workload() = default;

  // Called before each timed block of this many calls, untimed. Restores the steady state of a run, e.g. warm caches.
  virtual void get_ready(int /*calls*/) {}

  // False if a call failed.
  [[nodiscard]] virtual bool run(int calls) = 0;
};

// Work of several threads is repeated for this long before it is timed: until sleeping threads are awake, and until the
// system has moved two threads on one core to different cores.
inline constexpr double kUntilAwake = 0.0005, kUntilSpread = 0.01;  // s
template <class Run>
void repeat_for(double seconds, const Run& run) {
  const auto begin = std::chrono::steady_clock::now();
  while (std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() < seconds) run();
}

}  // namespace assur::measure
