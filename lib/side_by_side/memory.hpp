#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace assur {

// Throws Error (environment) if the results need more memory than is free.
void check_memory(std::size_t rows, std::size_t columns);

// Maps the pages of reserved memory before they are written, 16 MB at once. Mapping a page at the first write to it
// takes 1 us, often longer than a step.
class PagesAhead {
 public:
  explicit PagesAhead(const std::vector<double>& room) : begin_(room.data()), capacity_(room.capacity()) {}

  // Maps the pages of the first `doubles` numbers, at most the capacity. The content is unchanged.
  void reach(std::size_t doubles) noexcept {
    while (taken_ < std::min(doubles, capacity_)) take();
  }

 private:
  static constexpr std::size_t kPiece = 2'000'000;  // doubles

  void take() noexcept;

  const double* begin_;
  std::size_t capacity_, taken_ = 0;
};

}  // namespace assur
