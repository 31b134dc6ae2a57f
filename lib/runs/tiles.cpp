#include "runs/tiles.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "index.hpp"

namespace assur {
namespace {

std::size_t lanes_for(const Plan& plan, std::size_t runs) {
  return std::min(idx(plan.lanes), std::bit_ceil(std::max<std::size_t>(runs, 1)));
}

}  // namespace

int threads_for(const Plan& plan, std::size_t runs) {
  const std::size_t lanes = lanes_for(plan, runs), tiles = (runs + lanes - 1) / lanes;
  return static_cast<int>(std::clamp<std::size_t>(tiles, 1, idx(plan.run.threads)));
}

void mark_not_begun(std::span<LaneRun> runs) {
  for (LaneRun& run : runs) {
    if (run.done > 0 || !run.status.ok() || run.unbound) continue;
    run.reached = run.times[0];
    run.status = {Code::interrupted, {}, run.reached};
  }
}

Tiles::Tiles(Preparation prepared, const StepSettings& settings, std::size_t runs, int threads,
             const BoundMembers* members)
    : prepared_(std::move(prepared)), settings_(settings), members_(members), workers_(idx(threads)) {
  prepared_.plan.lanes = static_cast<std::int32_t>(lanes_for(prepared_.plan, runs));
  workers_[0] = std::make_unique<SideBySide>(prepared_, settings_, members_);
}

std::size_t Tiles::tiles(std::size_t runs) const {
  const std::size_t lanes = idx(prepared_.plan.lanes);
  return (runs + lanes - 1) / lanes;
}

void Tiles::run(int rank, std::span<LaneRun> runs, std::size_t tile,
                const std::function<bool(std::size_t rows)>& proceed) {
  std::unique_ptr<SideBySide>& worker = workers_[idx(rank)];
  if (!worker) worker = std::make_unique<SideBySide>(prepared_, settings_, members_);
  const std::size_t lanes = idx(prepared_.plan.lanes), begin = tile * lanes;
  std::vector<LaneRun*> together;
  for (LaneRun& run : runs.subspan(begin, std::min(lanes, runs.size() - begin))) {
    run.reached = run.times[0];
    together.push_back(&run);
  }
  worker->run(together, [&] {
    std::size_t rows = 0;
    for (const LaneRun* run : together) rows += run->done;
    return proceed(rows);
  });
  for (const LaneRun* run : together) {
    if (run->consumer != nullptr && run->done > 0) run->consumer->finish();
  }
}

Totals Tiles::totals() const {
  Totals sum;
  for (const auto& worker : workers_) {
    if (worker) sum.merge(worker->totals());
  }
  return sum;
}

void Tiles::clear() {
  for (const auto& worker : workers_) {
    if (worker) worker->clear_totals();
  }
}

}  // namespace assur
