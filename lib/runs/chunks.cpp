#include "runs/chunks.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <utility>

#include "decimal.hpp"
#include "numbers.hpp"
#include "parallel/team.hpp"
#include "program/needs.hpp"
#include "runs/tiles.hpp"
#include "runs/work_queue.hpp"
#include "simulation/run_arguments.hpp"

namespace assur {
namespace {

constexpr std::size_t kOverlap = 2;  // a chunk computes at most this many rows beyond its border

// Both postures solve the same equations. They are equal if each is within the ball in which a solution is unique.
bool same_posture(const std::vector<double>& a, const std::vector<double>& b, const std::vector<double>& uniqueness) {
  if (a.size() != b.size() || uniqueness.size() != b.size()) return false;
  for (std::size_t c = 0; c < a.size(); ++c) {
    if (!(std::abs(a[c] - b[c]) <= uniqueness[c])) return false;
  }
  return true;
}

void say_alone(const LaneRun& run, std::vector<std::string>& fallbacks) {
  fallbacks.push_back("the chunk from t = " + general(run.times[0], 6) + " s on was run alone from t = " +
                      general(run.alone_from, 6) + " s on, because it could not be solved in lockstep with others");
}

// One run for each chunk. Rows behind the border to the next chunk are stored apart.
std::vector<LaneRun> cut(std::span<const double> times, const ChunkGrid& grid, std::vector<Variant> starts,
                         double* values, double* overlaps, std::size_t columns) {
  const std::size_t chunks = grid.first.size();
  std::vector<LaneRun> runs(chunks);
  for (std::size_t c = 0; c < chunks; ++c) {
    runs[c].variant = std::move(starts[c]);
    runs[c].times = times.subspan(grid.first[c], grid.rows);
    runs[c].rows = values + grid.first[c] * columns;
    runs[c].beyond = overlaps + c * kOverlap * columns;
    if (c + 1 < chunks) runs[c].split = grid.first[c + 1] - grid.first[c];
    runs[c].posture_wanted = c + 1 < chunks ? runs[c].split : grid.rows - 1;
  }
  return runs;
}

// If a chunk did not begin where the chunk before it ended, it runs again from there. If the run was stopped, the chunk
// has done nothing.
void settle(SideBySide& worker, const LaneRun& before, LaneRun& run, const std::function<bool()>& proceed,
            std::vector<std::string>& fallbacks) {
  if (same_posture(before.posture, run.variant.posture, run.uniqueness)) return;
  const Status stopped = run.status;
  run.variant.posture = before.posture;
  run.done = 0;
  run.alone = false;
  run.status = {};
  run.error = {};
  run.posture.clear();
  run.outputs.clear();
  run.events.clear();
  run.fallbacks.clear();
  run.cannot.clear();
  if (stopped.code == Code::interrupted) {
    run.status = stopped;
    return;
  }
  worker.run_alone(run, proceed);
  run.alone = false;  // the next line reports it
  fallbacks.push_back(
      "the chunk from t = " + general(run.times[0], 6) +
      " s on began on another branch than the one on which the chunk before it ended; it was run again");
}

// Continues the angles of the chunk before. A chunk that did nothing gets the last row of the chunk before.
void follow(const LaneRun& before, LaneRun& run, const OutputProgram& outputs, std::size_t columns) {
  const double* const border = before.row(before.split, columns);
  if (run.done == 0) {
    std::copy_n(border, columns, run.rows);
    run.done = 1;
    run.posture = before.posture;
    run.reached = run.times[0];
    return;
  }
  const std::vector<double> here(run.rows, run.rows + columns);
  const Turns turns(outputs, border, here.data());
  for (std::size_t k = 0; k < run.done; ++k) turns.add_to(run.row(k, columns));
  if (!run.outputs.empty()) turns.add_to(run.outputs.data());
}

}  // namespace

std::string no_chunks(const GroupedSystem& structure, const StepSettings& settings, std::span<const double> times) {
  Needs needs = needs_of(structure);
  needs.add(needs_of(settings));
  if (std::string reason = why_not(Path::chunks, needs); !reason.empty()) return reason;
  return evenly_spaced(times) ? "" : "the steps are not equally long";
}

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

ChunkedRun run_in_chunks(const Preparation& prepared, const StepSettings& settings, std::span<const double> times,
                         const ChunkGrid& grid, std::vector<Variant> starts, const Observer& observer) {
  const std::size_t chunks = grid.first.size();
  Team team(threads_for(prepared.plan, chunks), settings.pin_to);
  Tiles tiles(prepared, settings, chunks, team.size());
  const std::size_t columns = tiles.first().columns().size();
  ChunkedRun out;
  out.values.resize(times.size() * columns);
  std::vector<double> overlaps(chunks * kOverlap * columns);
  std::vector<LaneRun> runs = cut(times, grid, std::move(starts), out.values.data(), overlaps.data(), columns);
  // Rows that two chunks compute are counted once.
  const auto rows = static_cast<std::int64_t>(times.size());
  Progress progress{{}, rows, 0, false};
  if (observer) {
    progress.observer = [&](std::int64_t done, std::int64_t of) { return observer(std::min(done, of), of); };
  }
  run_queue(
      team, tiles.tiles(chunks),
      [&](int rank, std::size_t tile, const auto& proceed) { tiles.run(rank, runs, tile, proceed); }, progress);
  mark_not_begun(runs);

  const auto proceed = [&] { return !observer || !observer(rows, rows); };
  Status doubt;  // the first one
  ErrorFigures error;
  for (std::size_t c = 0; c < chunks; ++c) {
    LaneRun& run = runs[c];
    if (c > 0) {
      settle(tiles.first(), runs[c - 1], run, proceed, out.fallbacks);
      follow(runs[c - 1], run, tiles.first().outputs(), columns);
    }
    error.merge(run.error);
    if (run.alone) say_alone(run, out.fallbacks);
    out.fallbacks.insert(out.fallbacks.end(), run.fallbacks.begin(), run.fallbacks.end());

    // The next chunk reports the events after its first row.
    const bool goes_on = c + 1 < chunks && run.done > run.split;
    const double end = goes_on ? run.times[run.split] : kInfinity;
    std::copy_if(run.events.begin(), run.events.end(), std::back_inserter(out.events),
                 [&](const Event& e) { return e.time < end; });
    if (goes_on) {
      if (doubt.ok() && run.status.code == Code::inaccurate) doubt = run.status;
      continue;
    }
    out.rows = grid.first[c] + run.done;
    out.status = run.status.ok() ? doubt : run.status;
    out.posture = run.posture;
    out.reached = run.reached;
    const double* const last = run.row(run.done - 1, columns);
    out.outputs = run.outputs.empty() ? std::vector<double>(last, last + columns) : run.outputs;
    break;
  }
  out.values.resize(out.rows * columns);
  out.totals = tiles.totals();
  out.totals.error.merge(error);
  return out;
}

}  // namespace assur
