#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace assur {

// Throws Error (environment) if there is no room for so many results.
void check_memory(std::size_t rows, std::size_t columns);

// Takes the pages of reserved room before they are written, 16 MB at once: a page that comes with the first write to it
// takes 1 us, which is much of a step.
class PagesAhead {
 public:
  explicit PagesAhead(const std::vector<double>& room) : begin_(room.data()), capacity_(room.capacity()) {}

  // So many doubles, at most the room's capacity, are about to be there. The content stays as it is.
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
