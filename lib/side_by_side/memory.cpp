#include "side_by_side/memory.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <string>

#include "parallel/free_memory.hpp"

namespace assur {
namespace {

constexpr std::uintptr_t kLarge = 4'000'000;  // bytes: enough for one whole huge page at any alignment

}  // namespace

void check_memory(std::size_t rows, std::size_t columns) {
  require_memory(static_cast<double>(rows) * static_cast<double>(columns) * sizeof(double),
                 std::to_string(rows) + " times x " + std::to_string(columns) + " values",
                 "ask for fewer outputs or a shorter run");
}

void PagesAhead::take() noexcept {
  const std::size_t piece = std::min(kPiece, capacity_ - taken_);
  const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  const auto from = reinterpret_cast<std::uintptr_t>(begin_ + taken_);
  const std::uintptr_t first = (from + page - 1) / page * page;
  const std::uintptr_t end = (from + piece * sizeof(double)) / page * page;
  taken_ += piece;
  if (end <= first) return;
  [[maybe_unused]] void* const address = reinterpret_cast<void*>(first);  // NOLINT(performance-no-int-to-ptr)
  // If the system lacks this advice, pages are placed one by one at the first write.
#ifdef MADV_HUGEPAGE
  if (end - first >= kLarge) (void)madvise(address, end - first, MADV_HUGEPAGE);
#endif
#ifdef MADV_POPULATE_WRITE
  (void)madvise(address, end - first, MADV_POPULATE_WRITE);
#endif
}

}  // namespace assur
