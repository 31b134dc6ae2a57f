#include "simulation/chunks.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "simulation/tiles.hpp"

namespace assur {
namespace {

constexpr std::size_t kOverlap = 2;  // rows of a chunk from the first of the next one on, at most

// Both postures solve the same equations; within the ball in which a solution is unique they are the same.
bool same_posture(const std::vector<double>& a, const std::vector<double>& b, const std::vector<double>& uniqueness) {
  if (a.size() != b.size() || uniqueness.size() != b.size()) return false;
  for (std::size_t c = 0; c < a.size(); ++c) {
    if (!(std::abs(a[c] - b[c]) <= uniqueness[c])) return false;
  }
  return true;
}

}  // namespace

ChunkGrid chunk_grid(std::size_t rows, std::size_t chunks) {
  const std::size_t steps = rows - 1;
  chunks = std::clamp<std::size_t>(chunks, 1, std::max<std::size_t>(steps, 1));
  ChunkGrid grid;
  const std::size_t length = (steps + chunks - 1) / chunks;
  grid.rows = length + 1;
  for (std::size_t c = 0; c < chunks; ++c) {
    grid.first.push_back(chunks == 1 ? 0 : c * (steps - length) / (chunks - 1));
  }
  return grid;
}

ChunkedRun run_in_chunks(const Prepared& prepared, const StepLimits& limits, std::span<const double> times,
                         const ChunkGrid& grid, std::vector<Variant> starts, const Simulator::Observer& observer) {
  const std::size_t chunks = grid.first.size();
  Tiles tiles(prepared, limits, chunks);
  const std::size_t columns = tiles.first().columns().size();
  ChunkedRun out;
  out.values.resize(times.size() * columns);
  std::vector<double> overlaps(chunks * kOverlap * columns);
  std::vector<LaneRun> runs(chunks);
  for (std::size_t c = 0; c < chunks; ++c) {
    runs[c].variant = std::move(starts[c]);
    runs[c].times = times.subspan(grid.first[c], grid.rows);
    runs[c].rows = out.values.data() + grid.first[c] * columns;
    runs[c].beyond = overlaps.data() + c * kOverlap * columns;
    if (c + 1 < chunks) runs[c].split = grid.first[c + 1] - grid.first[c];
    runs[c].posture_wanted = c + 1 < chunks ? runs[c].split : grid.rows - 1;
  }
  tiles.run(runs, observer, static_cast<std::int64_t>(chunks * grid.rows));

  const std::vector<std::size_t> angles = tiles.first().angles();
  for (std::size_t c = 0; c < chunks; ++c) {
    LaneRun& run = runs[c];
    if (c > 0) {
      const LaneRun& before = runs[c - 1];
      const double* const border = before.row(before.split, columns);
      if (!same_posture(before.posture, run.variant.posture, run.uniqueness)) {
        out.fallbacks.push_back("the chunk from t = " + std::to_string(run.times[0]) +
                                " s on began on another branch than the one before ended; it was run again");
        run.variant.posture = before.posture;
        run.done = 0;
        tiles.first().run_alone(run);
      }
      shift_by_turns(angles, border, std::vector<double>(run.rows, run.rows + columns).data(), run, 0, columns);
    }
    out.rows = grid.first[c] + run.done;
    out.status = run.status;
    out.posture = run.posture;
    out.events.insert(out.events.end(), run.events.begin(), run.events.end());
    if (run.alone) {
      out.fallbacks.push_back("the chunk from t = " + std::to_string(run.times[0]) + " s on was run alone from t = " +
                              std::to_string(run.alone_from) + " s on, where it could not keep step with others");
    }
    if (!run.status.ok() || run.done < grid.rows) break;
  }
  out.values.resize(out.rows * columns);
  out.totals = tiles.totals();
  return out;
}

}  // namespace assur
