// Times of single steps, measured within a run. The cost of a clock call is measured first and subtracted. Steps of
// less than a microsecond are measured in blocks, so that the clock does not disturb them.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <vector>

namespace assur::measure {

class StepTimes {
 public:
  struct Figures {
    double median, p99, max;  // s for one step
    int block;                // number of steps that were measured together
  };
  struct Blocks {
    std::vector<double> seconds;  // for one step, of each block in order
    int steps = 1;                // steps of a block
  };
  using Clock = std::function<double()>;  // s, monotonic

  // Allocates its memory at the first tick, so that a refused run needs none.
  explicit StepTimes(std::int64_t steps, Clock clock = steady);

  // To be called at the start of the first step and at the end of each step. True if the clock was read: only then the
  // caller may do other work, and must call resume() after it.
  bool tick() {
    if (--until_read_ > 0) return false;
    read();
    return true;
  }
  void resume() { last_ = clock_(); }

  // Time of the last reading since the first tick, s.
  [[nodiscard]] double elapsed() const { return last_ - first_; }

  // Times of all full blocks so far.
  [[nodiscard]] Blocks blocks() const;
  // Figures of the steps so far; all times are 0 if there were none. p99 by nearest rank.
  [[nodiscard]] Figures figures() const;

  [[nodiscard]] static double steady();

 private:
  void read();
  void consider_blocks();

  Clock clock_;
  std::int64_t steps_;           // expected number
  double cost_ = 0;              // s of one clock call
  double first_ = 0, last_ = 0;  // readings
  bool started_ = false;
  int block_ = 1, until_read_ = 1;
  std::vector<double> samples_;  // s for `block_` steps
};

}  // namespace assur::measure
