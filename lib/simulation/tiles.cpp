#include "simulation/tiles.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <exception>

namespace assur {
namespace {

std::size_t idx(std::int32_t i) { return static_cast<std::size_t>(i); }

std::size_t lanes_for(const Plan& plan, std::size_t runs) {
  return std::min(idx(plan.lanes), std::bit_ceil(std::max<std::size_t>(runs, 1)));
}

int threads_for(const Plan& plan, std::size_t runs) {
  const std::size_t lanes = lanes_for(plan, runs), tiles = (runs + lanes - 1) / lanes;
  return static_cast<int>(std::clamp<std::size_t>(tiles, 1, idx(plan.threads)));
}

}  // namespace

Tiles::Tiles(Prepared prepared, const StepLimits& limits, std::size_t runs) : team_(threads_for(prepared.plan, runs)) {
  prepared.plan.lanes = static_cast<std::int32_t>(lanes_for(prepared.plan, runs));
  for (int rank = 0; rank < team_.size(); ++rank) workers_.push_back(std::make_unique<SideBySide>(prepared, limits));
}

void Tiles::run(std::span<LaneRun> runs, const Simulator::Observer& observer, std::int64_t rows) {
  const std::size_t lanes = idx(first().lanes());
  std::atomic<std::size_t> next{0};
  std::atomic<std::int64_t> done{0};
  std::atomic<bool> stopped{false};
  std::vector<std::exception_ptr> thrown(workers_.size());
  team_.run([&](int rank) noexcept {
    try {
      std::vector<LaneRun*> together;
      const auto proceed = [&] {
        done.fetch_add(static_cast<std::int64_t>(together.size()), std::memory_order_relaxed);
        if (rank == 0 && observer && !observer(done.load(std::memory_order_relaxed), rows)) stopped = true;
        return !stopped.load(std::memory_order_relaxed);
      };
      while (!stopped) {
        const std::size_t begin = next.fetch_add(lanes);
        if (begin >= runs.size()) break;
        together.clear();
        for (LaneRun& run : runs.subspan(begin, std::min(lanes, runs.size() - begin))) together.push_back(&run);
        workers_[idx(rank)]->run(together, proceed);
      }
    } catch (...) {
      thrown[idx(rank)] = std::current_exception();
      stopped = true;
    }
  });
  for (const auto& e : thrown) {
    if (e) std::rethrow_exception(e);
  }
  for (LaneRun& run : runs) {
    if (run.done == 0 && run.status.ok()) run.status.code = Code::interrupted;
  }
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
