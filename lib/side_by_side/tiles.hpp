// Runs in lanes, as many as there are, over the threads of a plan.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "parallel/team.hpp"
#include "side_by_side/side_by_side.hpp"

namespace assur {

class Tiles {
 public:
  // For up to `runs` runs at a time: no more lanes and threads than they fill. Throws Error (environment) if a backend
  // of the plan cannot run here.
  Tiles(Prepared prepared, const StepLimits& limits, std::size_t runs);

  [[nodiscard]] SideBySide& first() { return *workers_[0]; }

  // Tile after tile; whichever thread is free takes the next one. The result depends on neither their number nor their
  // order. `observer` hears of `rows` rows in all.
  void run(std::span<LaneRun> runs, const Simulator::Observer& observer, std::int64_t rows);

  // Of everything since clear().
  [[nodiscard]] Totals totals() const;
  void clear();

 private:
  std::vector<std::unique_ptr<SideBySide>> workers_;  // threads
  Team team_;
};

}  // namespace assur
