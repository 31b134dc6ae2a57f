#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace assur {

// Throws Error (environment) if the results need more memory than is free.
void check_memory(std::size_t rows, std::size_t columns);

// Maps the pages of reserved memory before they are written. Mapping a small page at the first write to it takes 1 us,
// often longer than a step. Less than 4 MB are mapped at once, more by 2 MB: one large page, which is still in the
// cache when it is written.
class PagesAhead {
 public:
  explicit PagesAhead(const std::vector<double>& room);

  // Maps the pages of the first `doubles` numbers, at most the capacity. The content is unchanged.
  void reach(std::size_t doubles) noexcept {
    while (taken_ < std::min(doubles, capacity_)) take();
  }

 private:
  static constexpr std::size_t kPiece = 262'144;  // doubles

  void take() noexcept;

  const double* begin_;
  std::size_t capacity_, piece_, taken_ = 0;  // doubles
};

}  // namespace assur
