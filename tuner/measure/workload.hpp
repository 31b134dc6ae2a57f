// What can be timed: the same work again and again.
#pragma once

#include <chrono>

namespace assur::measure {

class Workload {
 public:
  virtual ~Workload() = default;

  // Before a timed block of so many calls, untimed: what a run in its steady state would find done, such as warm
  // caches.
  virtual void get_ready(int /*calls*/) {}

  // False if a call failed.
  [[nodiscard]] virtual bool run(int calls) = 0;
};

// What several threads do is repeated for so long before it is timed: until those that slept are awake, and, where the
// system has put two of them on one core, until it has found another.
inline constexpr double kUntilAwake = 0.0005, kUntilSpread = 0.01;  // s
template <class Run>
void repeat_for(double seconds, const Run& run) {
  const auto begin = std::chrono::steady_clock::now();
  while (std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() < seconds) run();
}

}  // namespace assur::measure
