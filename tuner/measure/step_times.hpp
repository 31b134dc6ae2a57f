// Times of single steps, measured inside a run. What a clock call costs is measured first and taken off; steps shorter
// than a microsecond are measured in blocks, so that the clock does not disturb what it measures.
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
    int block;                // steps measured together
  };
  struct Blocks {
    std::vector<double> seconds;  // for one step: of each block, in order
    int steps = 1;                // of a block
  };
  using Clock = std::function<double()>;  // s, monotonic

  // Takes its memory with the first tick: a run that is refused has none.
  explicit StepTimes(std::int64_t steps, Clock clock = steady);

  // Call at the start of the first step and at the end of each. Returns true if the clock was read: then, and only
  // then, the caller may do something of its own, and calls resume() after it.
  bool tick() {
    if (--until_read_ > 0) return false;
    read();
    return true;
  }
  void resume() { last_ = clock_(); }

  // Time of the last reading since the first tick, s.
  [[nodiscard]] double elapsed() const { return last_ - first_; }

  // Of the steps so far, all of them; without those that fill no block.
  [[nodiscard]] Blocks blocks() const;
  // Of the steps so far; times are 0 if there was none. p99 is the nearest rank.
  [[nodiscard]] Figures figures() const;

  [[nodiscard]] static double steady();

 private:
  void read();
  void consider_blocks();

  Clock clock_;
  std::int64_t steps_;           // that are expected
  double cost_ = 0;              // s of one clock call
  double first_ = 0, last_ = 0;  // readings
  bool started_ = false;
  int block_ = 1, until_read_ = 1;
  std::vector<double> samples_;  // s for `block_` steps
};

}  // namespace assur::measure
