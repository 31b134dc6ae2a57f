#include "side_by_side/memory.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <string>

#include "parallel/free_memory.hpp"

namespace assur {
namespace {

constexpr std::size_t kLarge = 4'000'000;  // bytes: enough for one whole huge page at any alignment

// The whole pages within [from, from + bytes).
struct Pages {
  Pages(const double* from, std::size_t bytes) {
    const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
    const auto begin = reinterpret_cast<std::uintptr_t>(from);
    first = (begin + page - 1) / page * page;
    size = std::max((begin + bytes) / page * page, first) - first;
  }
  void advise(int advice) const noexcept {
    if (size > 0) (void)madvise(reinterpret_cast<void*>(first), size, advice);  // NOLINT(performance-no-int-to-ptr)
  }

  std::uintptr_t first;
  std::size_t size;
};

}  // namespace

void check_memory(std::size_t rows, std::size_t columns) {
  require_memory(static_cast<double>(rows) * static_cast<double>(columns) * sizeof(double),
                 std::to_string(rows) + " times x " + std::to_string(columns) + " values",
                 "ask for fewer outputs or a shorter run");
}

// If the system lacks an advice, pages are small, or are placed one by one at the first write.
PagesAhead::PagesAhead(const std::vector<double>& room)
    : begin_(room.data()), capacity_(room.capacity()), piece_(capacity_) {
  const Pages all(begin_, capacity_ * sizeof(double));
  if (all.size < kLarge) return;
  piece_ = kPiece;
#ifdef MADV_HUGEPAGE
  all.advise(MADV_HUGEPAGE);
#endif
}

void PagesAhead::take() noexcept {
  const std::size_t piece = std::min(piece_, capacity_ - taken_);
#ifdef MADV_POPULATE_WRITE
  Pages(begin_ + taken_, piece * sizeof(double)).advise(MADV_POPULATE_WRITE);
#endif
  taken_ += piece;
}

}  // namespace assur
