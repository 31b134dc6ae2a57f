// One mechanism over a long time grid: chunks of the grid run side by side. Borders depend on the grid and the number
// of chunks only, never on threads.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "side_by_side/side_by_side.hpp"

namespace assur {

// First rows of `chunks` chunks (fewer if the grid is short) that cover `rows` times, each as long as any other; each
// but the first begins at or before the last row of the one before.
struct ChunkGrid {
  std::vector<std::size_t> first;
  std::size_t rows = 0;  // of each chunk
};
[[nodiscard]] ChunkGrid chunk_grid(std::size_t rows, std::size_t chunks);

// Why a run over these times cannot be cut into chunks; empty: it can.
[[nodiscard]] std::string no_chunks(const Structure& structure, const StepLimits& limits,
                                    std::span<const double> times);

struct ChunkedRun {
  std::vector<double> values;  // rows x columns
  std::size_t rows = 0;
  Status status;
  std::vector<double> posture;  // at `reached`
  std::vector<double> outputs;  // there
  double reached = 0;           // last time with a valid posture: that of the last row, or beyond on the way to a limit
  std::vector<Event> events;
  std::vector<std::string> fallbacks;
  Totals totals;
};

// `starts`: the posture at the first row of each chunk. Every chunk has to arrive at the posture where the next one
// began; one that began elsewhere is run again from there. Angles are unwrapped across the borders. `observer` hears of
// the rows of the grid.
[[nodiscard]] ChunkedRun run_in_chunks(const Prepared& prepared, const StepLimits& limits,
                                       std::span<const double> times, const ChunkGrid& grid,
                                       std::vector<Variant> starts, const Simulator::Observer& observer);

}  // namespace assur
