// Memory for vectors of up to 64 bytes, zeros at first.
#pragma once

#include <cstddef>
#include <cstring>
#include <memory>
#include <new>

namespace assur::lanes {

class Buffer {
 public:
  static constexpr std::align_val_t kAlignment{64};

  Buffer() = default;
  explicit Buffer(std::size_t bytes) : memory_(::operator new(bytes, kAlignment)) {
    std::memset(memory_.get(), 0, bytes);
  }

  [[nodiscard]] void* get() const { return memory_.get(); }

 private:
  struct Delete {
    void operator()(void* memory) const { ::operator delete(memory, kAlignment); }
  };
  std::unique_ptr<void, Delete> memory_;
};

}  // namespace assur::lanes
