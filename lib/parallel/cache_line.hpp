// Memory that begins at a cache line.
#pragma once

#include <cstddef>
#include <new>

namespace assur {

inline constexpr std::size_t kLineBytes = 64;

// Allocator aligned to cache lines, so that no SIMD vector of up to 64 bytes crosses a line.
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

}  // namespace assur
