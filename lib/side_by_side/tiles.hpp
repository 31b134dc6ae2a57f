// Runs any number of mechanisms in tiles, on the threads of a plan.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "parallel/team.hpp"
#include "side_by_side/side_by_side.hpp"

namespace assur {

// One tile for each thread.
class Tiles {
 public:
  // runs: largest number of runs in one call of run(); limits lanes and threads. members: as in SideBySide. Throws
  // Error (environment) if a backend of the plan cannot run here.
  Tiles(Prepared prepared, const StepLimits& limits, std::size_t runs, const BoundMembers* members = nullptr);

  [[nodiscard]] SideBySide& first() { return *workers_[0]; }

  // Runs all mechanisms, tile after tile; each free thread takes the next tile. The result depends neither on the
  // number of threads nor on their order. `observer` is called with up to `rows` rows in all.
  void run(std::span<LaneRun> runs, const Simulator::Observer& observer, std::int64_t rows);

  // Sums and errors since clear().
  [[nodiscard]] Totals totals() const;
  void clear();

 private:
  std::vector<std::unique_ptr<SideBySide>> workers_;  // threads
  Team team_;
};

}  // namespace assur
