// Runs any number of mechanisms of one structure in tiles.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "runs/side_by_side.hpp"

namespace assur {

// Threads of the plan that `runs` mechanisms keep busy.
[[nodiscard]] int threads_for(const Plan& plan, std::size_t runs);

// Gives runs that no thread has begun, because the run was stopped, the status `interrupted`.
void mark_not_begun(std::span<LaneRun> runs);

// The tiles of the threads of a team, each made by the thread that first needs it.
class Tiles {
 public:
  // runs: largest number of runs in one call of run(); limits the lanes. threads: size of the team. members: as in
  // SideBySide. Throws Error (environment) if a backend of the plan cannot run here.
  Tiles(Preparation prepared, const StepSettings& settings, std::size_t runs, int threads,
        const BoundMembers* members = nullptr);

  [[nodiscard]] SideBySide& first() { return *workers_[0]; }

  // Number of tiles that `runs` mechanisms fill.
  [[nodiscard]] std::size_t tiles(std::size_t runs) const;
  // Runs the mechanisms of one tile on the thread `rank`. The result depends neither on the thread nor on the order of
  // the tiles. proceed: called after each step with the rows of this tile that are done; false stops.
  void run(int rank, std::span<LaneRun> runs, std::size_t tile, const std::function<bool(std::size_t rows)>& proceed);

  // Sums and errors since clear().
  [[nodiscard]] Totals totals() const;
  void clear();

 private:
  Preparation prepared_;
  StepSettings settings_;
  const BoundMembers* members_;
  std::vector<std::unique_ptr<SideBySide>> workers_;  // threads; null: not needed so far
};

}  // namespace assur
