#include "runs/memory.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>
#include <new>
#include <string>

#include "parallel/free_memory.hpp"

namespace assur {
namespace {

constexpr std::size_t kLargePage = 2'097'152;  // bytes; where pages have other sizes, advice has no effect

// Bytes in large pages, at the begin of memory for rows. The last page is a large one if the rows then fill at least
// two thirds of the memory: mapping it takes 0.1 ms, its small pages on a virtual machine up to 5 ms.
std::size_t in_large_pages(std::size_t bytes) {
  const std::size_t whole = bytes / kLargePage * kLargePage;
  return whole < bytes && whole + kLargePage - bytes <= bytes / 2 ? whole + kLargePage : whole;
}

// The whole pages within [from, from + bytes).
struct Pages {
  Pages(const void* from, std::size_t bytes) {
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

std::size_t bytes(const RowValues& room) { return room.capacity() * sizeof(double); }

}  // namespace

void check_memory(std::size_t rows, std::size_t columns) {
  require_memory(static_cast<double>(rows) * static_cast<double>(columns) * sizeof(double),
                 std::to_string(rows) + " times x " + std::to_string(columns) + " values",
                 "ask for fewer outputs or a shorter run");
}

// If the system lacks an advice, pages are small, or are placed one by one at the first write.
double* RowAllocator::allocate(std::size_t count) {
  if (count > std::numeric_limits<std::ptrdiff_t>::max() / sizeof(double)) throw std::bad_array_new_length();
  const std::size_t bytes = count * sizeof(double), large = in_large_pages(bytes), size = std::max(bytes, large);
  if (large == 0) {
    void* const room = ::operator new(size);
#ifdef MADV_POPULATE_WRITE
    Pages(room, size).advise(MADV_POPULATE_WRITE);
#endif
    return static_cast<double*>(room);
  }
  // Not by an aligned new: glibc would map such memory anew for each run, where it uses the memory of the last one
  // again.
  auto* const block = static_cast<char*>(::operator new(size + kLargePage + sizeof(void*)));
  const auto begin = reinterpret_cast<std::uintptr_t>(block) + sizeof(void*);
  char* const room = block + (kLargePage - begin % kLargePage) + sizeof(void*);
  std::memcpy(room - sizeof(void*), &block, sizeof(void*));
#ifdef MADV_HUGEPAGE
  Pages(room, large).advise(MADV_HUGEPAGE);
#endif
#ifdef MADV_POPULATE_WRITE
  Pages(room + large, size - large).advise(MADV_POPULATE_WRITE);
#endif
  return reinterpret_cast<double*>(room);
}

void RowAllocator::deallocate(double* numbers, std::size_t count) noexcept {
  void* block = numbers;
  if (in_large_pages(count * sizeof(double)) > 0) {
    std::memcpy(&block, reinterpret_cast<const char*>(numbers) - sizeof(void*), sizeof(void*));
  }
  ::operator delete(block);
}

std::shared_ptr<double[]> shared_rows(std::size_t numbers) {
  return {RowAllocator().allocate(numbers), [numbers](double* rows) { RowAllocator().deallocate(rows, numbers); }};
}

PagesAhead::PagesAhead(const RowValues& room)
    : begin_(room.data()),
      capacity_(in_large_pages(bytes(room)) > 0 ? room.capacity() : 0),
      piece_(bytes(room) > 2 * kLargePage ? kLargePage / sizeof(double) : capacity_) {}

void PagesAhead::take() noexcept {
  const std::size_t piece = std::min(piece_, capacity_ - taken_);
#ifdef MADV_POPULATE_WRITE
  Pages(begin_ + taken_, piece * sizeof(double)).advise(MADV_POPULATE_WRITE);
#endif
  taken_ += piece;
}

}  // namespace assur
