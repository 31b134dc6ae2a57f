// Runs one mechanism over a long time grid: chunks of the grid run side by side. The borders of chunks depend on the
// grid and the number of chunks only, never on threads.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "runs/side_by_side.hpp"

namespace assur {

// Division of `rows` times into chunks of equal length (fewer than requested if the grid is short). Each chunk but the
// first begins at or before the last row of the chunk before.
struct ChunkGrid {
  std::vector<std::size_t> first;  // chunks: first row
  std::size_t rows = 0;            // of each chunk
};
[[nodiscard]] ChunkGrid chunk_grid(std::size_t rows, std::size_t chunks);

// The reason why a run over these times cannot be cut into chunks; "": it can.
[[nodiscard]] std::string no_chunks(const GroupedSystem& structure, const StepSettings& settings,
                                    std::span<const double> times);

// The result of a run in chunks.
struct ChunkedRun {
  RowValues values;  // rows x columns
  std::size_t rows = 0;
  Status status;
  std::vector<double> posture;  // at `reached`
  std::vector<double> outputs;  // there
  double reached = 0;           // last time with a valid posture; after the last row if a limit follows
  std::vector<Event> events;
  std::vector<std::string> fallbacks;
  Totals totals;
};

// Runs all chunks. `starts`: posture at the first row of each chunk. If a chunk does not arrive at the posture where
// the next one began, the next one runs again from the posture that was reached. Angles are unwrapped across the
// borders. `observer` is called with rows of the grid.
[[nodiscard]] ChunkedRun run_in_chunks(const Preparation& prepared, const StepSettings& settings,
                                       std::span<const double> times, const ChunkGrid& grid,
                                       std::vector<Variant> starts, const Observer& observer);

}  // namespace assur
