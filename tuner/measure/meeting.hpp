// The kernel `meeting`: p threads start together, hand numbers over, and wait for each other.
#pragma once

#include "measure/workload.hpp"
#include "parallel/team.hpp"

namespace assur::measure {

class Meeting final : public Workload {
 public:
  // doubles: total of the numbers that the first thread hands to the others and gets back. Throws Error like Team.
  Meeting(int threads, std::int32_t doubles) : numbers_(static_cast<std::size_t>(doubles), 1.0), team_(threads) {}

  void get_ready(int) override {
    repeat_for(kUntilSpread, [this] { (void)run(1); });
  }
  bool run(int calls) override;

 private:
  std::vector<double> numbers_;
  Team team_;
};

}  // namespace assur::measure
