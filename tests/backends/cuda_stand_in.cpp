// Replaces NVIDIA's driver, CUDA Runtime, cuBLAS and cuSOLVER in tests. It is as strict as a device: work waits in its
// stream until cudaStreamSynchronize(), only this library can touch memory of the device, and copies and functions
// refuse memory of the wrong side. At the end of the program it reports what was not given back.
//
// ASSUR_STAND_IN chooses a fault: old_driver, no_device, small (little memory), or fails (an error during a
// synchronisation).
#include <sys/mman.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <mutex>
#include <string_view>
#include <vector>

#include "backends/column_lu.hpp"

namespace {

using assur::test::column_getrf;
using assur::test::column_getrs;

// cudaError_t
constexpr int kInvalid = 1, kNoMemory = 2, kOldDriver = 35, kNoDevice = 100, kFailed = 719;

bool mode(std::string_view name) {
  const char* const text = std::getenv("ASSUR_STAND_IN");
  return text && text == name;
}

struct Stream {
  std::vector<std::function<void()>> work;
};
struct Handle {
  Stream* stream = nullptr;
};
struct Event {
  double seconds = 0;
};

// The memory of the device, and all that must be given back.
class Device {
 public:
  ~Device() {
    if (!blocks_.empty() || objects != 0) {
      std::fprintf(stderr, "stand-in of CUDA: %zu blocks of device memory and %d objects were not given back\n",
                   blocks_.size(), objects);
    }
  }

  [[nodiscard]] std::size_t size() const { return size_; }

  int allocate(void** memory, std::size_t bytes) {
    const std::lock_guard lock(turn_);
    std::size_t at = 0;  // the first gap that is large enough
    for (const auto& [begin, end] : blocks_) {
      if (begin - at >= bytes) break;
      at = end;
    }
    if (at + bytes > size_) return kNoMemory;
    blocks_[at] = at + (bytes + 255) / 256 * 256;
    *memory = base_ + at;
    return 0;
  }
  int release(void* memory) {
    const std::lock_guard lock(turn_);
    return memory == nullptr || blocks_.erase(static_cast<std::size_t>(static_cast<char*>(memory) - base_)) == 1
               ? 0
               : kInvalid;
  }
  [[nodiscard]] bool owns(const void* memory) const {
    const auto* const at = static_cast<const char*>(memory);
    return at >= base_ && at < base_ + size_;
  }
  void work(Stream& stream) {
    const std::lock_guard lock(turn_);
    const std::size_t used = blocks_.empty() ? 0 : blocks_.rbegin()->second;  // pages beyond stay out of reach
    mprotect(base_, used, PROT_READ | PROT_WRITE);
    for (const auto& step : stream.work) step();
    stream.work.clear();
    mprotect(base_, used, PROT_NONE);
  }

  int objects = 0;  // memory of the host, streams, events and handles

 private:
  std::size_t size_ = std::size_t{mode("small") ? 96u : 1024u} << 20;
  char* base_ = static_cast<char*>(mmap(nullptr, size_, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0));
  std::map<std::size_t, std::size_t> blocks_;  // begin, end
  std::mutex turn_;
};

Device device;
std::mutex counting;

void count(int more) {
  const std::lock_guard lock(counting);
  device.objects += more;
}

template <class T>
int create(void** object) {
  *object = new T;
  count(1);
  return 0;
}
template <class T>
int destroy(void* object) {
  delete static_cast<T*>(object);
  count(-1);
  return 0;
}

template <class... Pointers>
bool on_device(const Pointers*... pointers) {
  return (device.owns(pointers) && ...);
}

// Adds work to the stream of a handle. Returns the status of cuBLAS and cuSOLVER for invalid values, 7, if a condition
// does not hold.
int add(void* handle, bool valid, std::function<void()> work) {
  Stream* const stream = static_cast<Handle*>(handle)->stream;
  if (!valid || stream == nullptr) return 7;
  stream->work.push_back(std::move(work));
  return 0;
}

template <class T>
int getrf_batched(void* handle, int n, T* const a[], int lda, int* pivot, int* info, int count) {
  return add(handle, n > 0 && lda >= n && on_device(a, pivot, info), [=] {
    for (int i = 0; i < count; ++i) info[i] = column_getrf(n, a[i], lda, pivot + i * n);
  });
}

template <class T>
int getrs_batched(void* handle, int transpose, int n, int rhs, const T* const a[], int lda, const int* pivot,
                  T* const b[], int ldb, int* info, int count) {
  *info = 0;
  return add(handle, n > 0 && lda >= n && ldb >= n && on_device(a, pivot, b) && !device.owns(info), [=] {
    for (int i = 0; i < count; ++i) column_getrs(transpose == 1, n, rhs, a[i], lda, pivot + i * n, b[i], ldb);
  });
}

template <class T>
int copy(void* handle, int n, const T* x, int step_of_x, T* y, int step_of_y) {
  return add(handle, on_device(x, y), [=] {
    for (std::ptrdiff_t i = 0; i < n; ++i) y[i * step_of_y] = x[i * step_of_x];
  });
}

template <class T>
int getrf(void* handle, int m, int n, T* a, int lda, T* work, int* pivot, int* info) {
  return add(handle, m == n && n > 0 && lda >= n && on_device(a, work, pivot, info), [=] {
    work[n - 1] = 0;  // as large as getrf_size() says
    *info = column_getrf(n, a, lda, pivot);
  });
}

template <class T>
int getrs(void* handle, int transpose, int n, int rhs, const T* a, int lda, const int* pivot, T* b, int ldb,
          int* info) {
  return add(handle, n > 0 && lda >= n && ldb >= n && on_device(a, pivot, b, info), [=] {
    *info = 0;
    column_getrs(transpose == 1, n, rhs, a, lda, pivot, b, ldb);
  });
}

int getrf_size(int n, int* size) {
  *size = n;
  return 0;
}

}  // namespace

extern "C" {

// ---- the driver

int cuDeviceGet(int* number, int ordinal) {
  *number = ordinal;
  return 0;
}
int cuDeviceGetName(char* name, int size, int) {
  std::snprintf(name, static_cast<std::size_t>(size), "Stand-in");
  return 0;
}

// ---- CUDA Runtime

int cudaGetDeviceCount(int* devices) {
  if (mode("old_driver")) return kOldDriver;
  if (mode("no_device")) return kNoDevice;
  *devices = 1;
  return 0;
}
int cudaDriverGetVersion(int* version) {
  *version = mode("old_driver") ? 11040 : 13000;
  return 0;
}
int cudaRuntimeGetVersion(int* version) {
  *version = 13000;
  return 0;
}
int cudaMemGetInfo(std::size_t* free, std::size_t* total) {
  *free = *total = device.size();
  return 0;
}
int cudaMalloc(void** memory, std::size_t bytes) { return device.allocate(memory, bytes); }
int cudaFree(void* memory) { return device.release(memory); }
int cudaMallocHost(void** memory, std::size_t bytes) {
  *memory = std::malloc(bytes);
  if (*memory == nullptr) return kNoMemory;
  count(1);
  return 0;
}
int cudaFreeHost(void* memory) {
  std::free(memory);
  count(-1);
  return 0;
}
int cudaStreamCreateWithFlags(void** stream, unsigned flags) { return flags == 1 ? create<Stream>(stream) : kInvalid; }
int cudaStreamDestroy(void* stream) { return destroy<Stream>(stream); }
int cudaStreamSynchronize(void* stream) {
  if (mode("fails")) return kFailed;
  device.work(*static_cast<Stream*>(stream));
  return 0;
}
int cudaMemcpy2DAsync(void* to, std::size_t to_pitch, const void* from, std::size_t from_pitch, std::size_t width,
                      std::size_t height, int kind, void* stream) {
  const bool valid = device.owns(to) == (kind == 1) && device.owns(from) == (kind == 2) && width <= to_pitch &&
                     width <= from_pitch && (kind == 1 || kind == 2);
  if (!valid) return kInvalid;
  static_cast<Stream*>(stream)->work.emplace_back([=] {
    for (std::size_t i = 0; i < height; ++i) {
      std::memcpy(static_cast<char*>(to) + i * to_pitch, static_cast<const char*>(from) + i * from_pitch, width);
    }
  });
  return 0;
}
int cudaMemcpyAsync(void* to, const void* from, std::size_t bytes, int kind, void* stream) {
  return cudaMemcpy2DAsync(to, bytes, from, bytes, bytes, 1, kind, stream);
}
int cudaEventCreate(void** event) { return create<Event>(event); }
int cudaEventDestroy(void* event) { return destroy<Event>(event); }
int cudaEventRecord(void* event, void* stream) {
  static_cast<Stream*>(stream)->work.emplace_back([event] {
    const std::chrono::duration<double> now = std::chrono::steady_clock::now().time_since_epoch();
    static_cast<Event*>(event)->seconds = now.count();
  });
  return 0;
}
int cudaEventElapsedTime(float* milliseconds, void* first, void* last) {
  const double seconds = static_cast<Event*>(last)->seconds - static_cast<Event*>(first)->seconds;
  *milliseconds = static_cast<float>(1e3 * seconds);
  return 0;
}
int cudaGetLastError() { return 0; }
const char* cudaGetErrorString(int error) {
  return error == kNoDevice ? "no CUDA-capable device is detected" : error == kFailed ? "launch failure" : "an error";
}

// ---- cuBLAS

int cublasCreate_v2(void** handle) { return create<Handle>(handle); }
int cublasDestroy_v2(void* handle) { return destroy<Handle>(handle); }
int cublasSetStream_v2(void* handle, void* stream) {
  static_cast<Handle*>(handle)->stream = static_cast<Stream*>(stream);
  return 0;
}

int cublasDgetrfBatched(void* h, int n, double* const a[], int lda, int* pivot, int* info, int batch) {
  return getrf_batched(h, n, a, lda, pivot, info, batch);
}
int cublasSgetrfBatched(void* h, int n, float* const a[], int lda, int* pivot, int* info, int batch) {
  return getrf_batched(h, n, a, lda, pivot, info, batch);
}
int cublasDgetrsBatched(void* h, int transpose, int n, int rhs, const double* const a[], int lda, const int* pivot,
                        double* const b[], int ldb, int* info, int batch) {
  return getrs_batched(h, transpose, n, rhs, a, lda, pivot, b, ldb, info, batch);
}
int cublasSgetrsBatched(void* h, int transpose, int n, int rhs, const float* const a[], int lda, const int* pivot,
                        float* const b[], int ldb, int* info, int batch) {
  return getrs_batched(h, transpose, n, rhs, a, lda, pivot, b, ldb, info, batch);
}
int cublasDcopy_v2(void* h, int n, const double* x, int x_step, double* y, int y_step) {
  return copy(h, n, x, x_step, y, y_step);
}
int cublasScopy_v2(void* h, int n, const float* x, int x_step, float* y, int y_step) {
  return copy(h, n, x, x_step, y, y_step);
}

// ---- cuSOLVER

int cusolverGetVersion(int* version) {
  *version = 12001;
  return 0;
}
int cusolverDnCreate(void** handle) { return create<Handle>(handle); }
int cusolverDnDestroy(void* handle) { return destroy<Handle>(handle); }
int cusolverDnSetStream(void* handle, void* stream) { return cublasSetStream_v2(handle, stream); }
int cusolverDnDgetrf_bufferSize(void*, int, int n, double*, int, int* size) { return getrf_size(n, size); }
int cusolverDnSgetrf_bufferSize(void*, int, int n, float*, int, int* size) { return getrf_size(n, size); }
int cusolverDnDgetrf(void* h, int m, int n, double* a, int lda, double* work, int* pivot, int* info) {
  return getrf(h, m, n, a, lda, work, pivot, info);
}
int cusolverDnSgetrf(void* h, int m, int n, float* a, int lda, float* work, int* pivot, int* info) {
  return getrf(h, m, n, a, lda, work, pivot, info);
}
int cusolverDnDgetrs(void* h, int transpose, int n, int rhs, const double* a, int lda, const int* pivot, double* b,
                     int ldb, int* info) {
  return getrs(h, transpose, n, rhs, a, lda, pivot, b, ldb, info);
}
int cusolverDnSgetrs(void* h, int transpose, int n, int rhs, const float* a, int lda, const int* pivot, float* b,
                     int ldb, int* info) {
  return getrs(h, transpose, n, rhs, a, lda, pivot, b, ldb, info);
}
}
