#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>

#include "assur/rows.hpp"

namespace assur {

// Throws Error (environment) if the results need more memory than is free.
void check_memory(std::size_t rows, std::size_t columns);

// Memory for rows that copies share, uninitialised. Throws std::bad_alloc.
[[nodiscard]] std::shared_ptr<double[]> shared_rows(std::size_t numbers);

// Maps the pages of large reserved memory before they are written; RowAllocator has mapped those of small memory. Up to
// 4 MB are mapped at once, more by 2 MB: one large page, which is still in the cache when it is written.
class PagesAhead {
 public:
  explicit PagesAhead(const RowValues& room);

  // Maps the pages of the first `doubles` numbers. The content is unchanged.
  void reach(std::size_t doubles) noexcept {
    while (taken_ < std::min(doubles, capacity_)) take();
  }

 private:
  void take() noexcept;

  const double* begin_;
  std::size_t capacity_, piece_, taken_ = 0;  // doubles
};

}  // namespace assur
