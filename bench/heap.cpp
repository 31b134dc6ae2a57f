#include "heap.hpp"

#include <malloc.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>

namespace {

// The benchmarks that count memory have one thread.
assur::bench::Heap counted;

void* taken(void* block) {
  counted.live += static_cast<std::int64_t>(malloc_usable_size(block));
  counted.peak = std::max(counted.peak, counted.live);
  return block;
}

}  // namespace

assur::bench::Heap assur::bench::heap() { return counted; }
void assur::bench::forget_peak() { counted.peak = counted.live; }

// The malloc of this program replaces that of the C library, whose functions remain available under these names.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) { return taken(__libc_malloc(size)); }
void* calloc(std::size_t n, std::size_t size) { return taken(__libc_calloc(n, size)); }
void* realloc(void* old, std::size_t size) {
  const auto before = static_cast<std::int64_t>(malloc_usable_size(old));
  void* const block = __libc_realloc(old, size);
  if (block != nullptr || size == 0) counted.live -= before;
  return taken(block);
}
void* memalign(std::size_t alignment, std::size_t size) { return taken(__libc_memalign(alignment, size)); }
void* aligned_alloc(std::size_t alignment, std::size_t size) { return memalign(alignment, size); }
int posix_memalign(void** result, std::size_t alignment, std::size_t size) {
  *result = memalign(alignment, size);
  return *result != nullptr ? 0 : ENOMEM;
}
void free(void* block) {
  counted.live -= static_cast<std::int64_t>(malloc_usable_size(block));
  __libc_free(block);
}
}
