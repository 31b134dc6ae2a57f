// The kernel `meeting`: what p threads lose by starting together and waiting for each other.
#pragma once

#include "measure/workload.hpp"
#include "parallel/team.hpp"

namespace assur::measure {

class Meeting final : public Workload {
 public:
  // Throws Error as Team does.
  explicit Meeting(int threads) : team_(threads) {}

  void get_ready(int) override {
    repeat_for(kUntilSpread, [this] { (void)run(1); });
  }
  bool run(int calls) override;

 private:
  Team team_;
};

}  // namespace assur::measure
