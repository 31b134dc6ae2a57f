// A queue of pieces of work that free threads take in turn.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "assur/simulator.hpp"
#include "parallel/team.hpp"

namespace assur {

// Rows that several queues have done, one after another.
struct Progress {
  Observer observer{};    // may be empty
  std::int64_t of = 0;    // rows in all, for the observer
  std::int64_t done = 0;  // by the queues before; the caller adds those of a queue
  bool stopped = false;   // by the observer
};

// Calls work(rank, piece, proceed) for all pieces, 0 to pieces - 1, on the threads of the team. Work calls
// proceed(rows) with the rows of its piece that are done so far; when that is false, it ends, and no piece is begun.
// Rank 0 calls the observer. If work throws, no piece is begun, and the exception of the lowest rank propagates.
void run_queue(
    Team& team, std::size_t pieces,
    const std::function<void(int rank, std::size_t piece, const std::function<bool(std::size_t rows)>& proceed)>& work,
    Progress& progress);

}  // namespace assur
