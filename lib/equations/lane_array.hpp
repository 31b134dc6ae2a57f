// Arrays [slot][lane].
#pragma once

#include <algorithm>
#include <cstddef>
#include <new>
#include <vector>

namespace assur {

inline constexpr std::size_t kLineBytes = 64;

// From the start of a cache line on: no vector of up to 64 bytes crosses one.
template <class T>
struct LineAllocator {
  using value_type = T;
  static constexpr std::align_val_t kAlignment{kLineBytes};

  LineAllocator() = default;
  template <class U>
  explicit(false) LineAllocator(const LineAllocator<U>& /*other*/) noexcept {}

  [[nodiscard]] T* allocate(std::size_t count) {
    return static_cast<T*>(::operator new(count * sizeof(T), kAlignment));
  }
  void deallocate(T* memory, std::size_t /*count*/) noexcept { ::operator delete(memory, kAlignment); }
  friend bool operator==(const LineAllocator&, const LineAllocator&) noexcept { return true; }
};

using LaneArray = std::vector<double, LineAllocator<double>>;

// The first place from `at` on where W lanes, or as many of them as fill a cache line, do not cross a line.
[[nodiscard]] constexpr std::size_t lane_place(std::size_t at, std::size_t lanes) {
  const std::size_t apart = std::min(lanes, kLineBytes / sizeof(double));
  return (at + apart - 1) / apart * apart;
}

}  // namespace assur
