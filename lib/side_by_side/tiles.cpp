#include "side_by_side/tiles.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <utility>

#include "index.hpp"

namespace assur {
namespace {

std::size_t lanes_for(const Plan& plan, std::size_t runs) {
  return std::min(idx(plan.lanes), std::bit_ceil(std::max<std::size_t>(runs, 1)));
}

int threads_for(const Plan& plan, std::size_t runs) {
  const std::size_t lanes = lanes_for(plan, runs), tiles = (runs + lanes - 1) / lanes;
  return static_cast<int>(std::clamp<std::size_t>(tiles, 1, idx(plan.run.threads)));
}

}  // namespace

Tiles::Tiles(Prepared prepared, const StepLimits& limits, std::size_t runs, const BoundMembers* members)
    : team_(threads_for(prepared.plan, runs), limits.pin_to) {
  prepared.plan.lanes = static_cast<std::int32_t>(lanes_for(prepared.plan, runs));
  for (int rank = 0; rank < team_.size(); ++rank) {
    workers_.push_back(std::make_unique<SideBySide>(prepared, limits, members));
  }
}

void Tiles::run(std::span<LaneRun> runs, const Simulator::Observer& observer, std::int64_t rows) {
  const std::size_t lanes = idx(first().lanes());
  std::atomic<std::size_t> next{0};
  std::atomic<std::int64_t> done{0};
  std::atomic<bool> stopped{false};
  std::int64_t heard = 0;
  for (LaneRun& run : runs) run.reached = run.times[0];
  team_.run([&](int rank) {
    try {
      std::vector<LaneRun*> together;
      std::int64_t counted = 0;  // of this tile
      const auto proceed = [&] {
        std::int64_t now = 0;
        for (const LaneRun* run : together) now += static_cast<std::int64_t>(run->done);
        done.fetch_add(now - std::exchange(counted, now), std::memory_order_relaxed);
        if (rank == 0 && observer && !observer(heard = done.load(std::memory_order_relaxed), rows)) stopped = true;
        return !stopped.load(std::memory_order_relaxed);
      };
      while (!stopped) {
        const std::size_t begin = next.fetch_add(lanes);
        if (begin >= runs.size()) break;
        together.clear();
        counted = 0;
        for (LaneRun& run : runs.subspan(begin, std::min(lanes, runs.size() - begin))) together.push_back(&run);
        workers_[idx(rank)]->run(together, proceed);
        for (LaneRun* run : together) {
          if (run->taker != nullptr && run->done > 0) run->taker->finish();
        }
      }
    } catch (...) {
      stopped = true;  // the other threads need not continue
      throw;
    }
  });
  for (LaneRun& run : runs) {
    if (run.done == 0 && run.status.ok() && !run.unbound) run.status = {Code::interrupted, {}, run.reached};
  }
  if (observer && !stopped && heard < done) (void)observer(done, rows);
}

Totals Tiles::totals() const {
  Totals sum;
  for (const auto& worker : workers_) sum.merge(worker->totals());
  return sum;
}

void Tiles::clear() {
  for (const auto& worker : workers_) worker->clear_totals();
}

}  // namespace assur
