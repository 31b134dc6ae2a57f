#include "runs/work_queue.hpp"

#include <atomic>
#include <utility>

namespace assur {

void run_queue(
    Team& team, std::size_t pieces,
    const std::function<void(int rank, std::size_t piece, const std::function<bool(std::size_t rows)>& proceed)>& work,
    Progress& progress) {
  std::atomic<std::size_t> next{0};
  std::atomic<std::int64_t> done{0};
  std::atomic<bool> stopped{progress.stopped};
  std::int64_t heard = 0;
  team.run([&](int rank) {
    try {
      for (std::size_t piece; !stopped && (piece = next.fetch_add(1)) < pieces;) {
        std::size_t counted = 0;  // of this piece
        work(rank, piece, [&](std::size_t rows) {
          done.fetch_add(static_cast<std::int64_t>(rows - std::exchange(counted, rows)), std::memory_order_relaxed);
          if (rank == 0 && progress.observer) {
            heard = done.load(std::memory_order_relaxed);
            if (progress.observer(progress.done + heard, progress.of)) stopped = true;
          }
          return !stopped.load(std::memory_order_relaxed);
        });
      }
    } catch (...) {
      stopped = true;  // the other threads need not continue
      throw;
    }
  });
  if (progress.observer && !stopped && heard < done) stopped = progress.observer(progress.done + done, progress.of);
  progress.stopped = stopped;
}

}  // namespace assur
