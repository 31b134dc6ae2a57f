// What can be timed: the same work again and again.
#pragma once

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

}  // namespace assur::measure
