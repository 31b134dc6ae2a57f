// NVIDIA's CUDA libraries, loaded at run time, so that no header of CUDA is needed to build: the CUDA Runtime, cuBLAS
// and the dense part of cuSOLVER. Functions have the names and arguments of NVIDIA's manuals; handles, streams and
// events are void*, enumerations are int.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "backends/block.hpp"

namespace assur::cuda {

// Functions for one type of numbers.
template <class T>
struct Dense {
  int (*getrf_batched)(void* handle, int n, T* const a[], int lda, int* pivot, int* info, int count);
  int (*getrs_batched)(void* handle, int transpose, int n, int rhs, const T* const a[], int lda, const int* pivot,
                       T* const b[], int ldb, int* info, int count);
  int (*copy)(void* handle, int n, const T* x, int step_of_x, T* y, int step_of_y);
  int (*getrf_size)(void* handle, int m, int n, T* a, int lda, int* size);
  int (*getrf)(void* handle, int m, int n, T* a, int lda, T* work, int* pivot, int* info);
  int (*getrs)(void* handle, int transpose, int n, int rhs, const T* a, int lda, const int* pivot, T* b, int ldb,
               int* info);
};

// All functions return 0 if they succeed.
struct Library {
  int (*cudaGetDeviceCount)(int* count);
  int (*cudaDriverGetVersion)(int* version);
  int (*cudaRuntimeGetVersion)(int* version);
  int (*cudaMemGetInfo)(std::size_t* free, std::size_t* total);
  int (*cudaMalloc)(void** memory, std::size_t bytes);
  int (*cudaFree)(void* memory);
  int (*cudaMallocHost)(void** memory, std::size_t bytes);
  int (*cudaFreeHost)(void* memory);
  int (*cudaStreamCreateWithFlags)(void** stream, unsigned flags);
  int (*cudaStreamDestroy)(void* stream);
  int (*cudaStreamSynchronize)(void* stream);
  int (*cudaMemcpyAsync)(void* to, const void* from, std::size_t bytes, int kind, void* stream);
  int (*cudaMemcpy2DAsync)(void* to, std::size_t to_pitch, const void* from, std::size_t from_pitch, std::size_t width,
                           std::size_t height, int kind, void* stream);
  int (*cudaEventCreate)(void** event);
  int (*cudaEventDestroy)(void* event);
  int (*cudaEventRecord)(void* event, void* stream);
  int (*cudaEventElapsedTime)(float* milliseconds, void* first, void* last);
  int (*cudaGetLastError)();
  const char* (*cudaGetErrorString)(int error);

  int (*cublasCreate_v2)(void** handle);
  int (*cublasDestroy_v2)(void* handle);
  int (*cublasSetStream_v2)(void* handle, void* stream);
  int (*cusolverGetVersion)(int* version);
  int (*cusolverDnCreate)(void** handle);
  int (*cusolverDnDestroy)(void* handle);
  int (*cusolverDnSetStream)(void* handle, void* stream);
  Dense<double> in_double;
  Dense<float> in_float;

  std::string version;  // "CUDA 13.0, cuSOLVER 12.0.4, NVIDIA H100": of the libraries and the first device
  std::string why_not;  // the reason why nothing can run, with a remedy; "": everything was found
};

// Values of NVIDIA's enumerations and flags.
inline constexpr int kToDevice = 1, kToHost = 2;      // cudaMemcpyKind
inline constexpr int kPlain = 0, kTransposed = 1;     // cublasOperation_t
inline constexpr int kNoMemory = 2, kOldDriver = 35;  // cudaError_t
inline constexpr unsigned kNonBlocking = 1;           // a stream that does not wait for the default stream

// Loaded once, at the first call: some 0.1 s where there is a device, hardly any time where there is no driver.
[[nodiscard]] const Library& library();

// The reason why this computer has no driver for NVIDIA devices, with a remedy; "" if it has one.
[[nodiscard]] const std::string& why_no_driver();

// ---- errors: all throw Error (environment) with the name of the function

// For functions of cuBLAS and cuSOLVER.
void check(int status, const char* function);
// For functions of the CUDA Runtime.
void check_cuda(int status, const char* function);

[[nodiscard]] std::string mebibytes(double bytes);

// ---- memory, streams and clocks

enum class Where : std::uint8_t { device, host };  // host: page-locked, so that copies do not wait

// Throws Error (environment) if there is too little memory.
[[nodiscard]] void* allocate(Where where, std::size_t bytes);
void release(Where where, void* memory) noexcept;

// Memory for numbers, on the device or for copies to and from it.
template <class T, Where where>
class Memory {
 public:
  Memory() = default;
  explicit Memory(DenseIndex count) : data_(allocate(where, static_cast<std::size_t>(count) * sizeof(T))) {}
  Memory(Memory&& other) noexcept : data_(std::exchange(other.data_, nullptr)) {}
  Memory& operator=(Memory&& other) noexcept {
    std::swap(data_, other.data_);
    return *this;
  }
  ~Memory() { release(where, data_); }

  [[nodiscard]] T* data() const { return static_cast<T*>(data_); }

 private:
  void* data_ = nullptr;
};

// A stream with the handles of both libraries. Calls return before the device has done their work.
class Queue {
 public:
  Queue();
  ~Queue();
  Queue(const Queue&) = delete;
  Queue& operator=(const Queue&) = delete;

  template <class T>
  void upload(T* to, const T* from, DenseIndex count) const {
    copy(to, from, static_cast<std::size_t>(count) * sizeof(T), kToDevice);
  }
  template <class T>
  void download(T* to, const T* from, DenseIndex count) const {
    copy(to, from, static_cast<std::size_t>(count) * sizeof(T), kToHost);
  }
  // The first `width` numbers of each of `rows` rows, which are `step` numbers apart.
  template <class T>
  void copy_rows(T* to, const T* from, DenseIndex width, DenseIndex step, DenseIndex rows, int kind) const {
    const auto bytes = [](DenseIndex count) { return static_cast<std::size_t>(count) * sizeof(T); };
    check_cuda(library().cudaMemcpy2DAsync(to, bytes(step), from, bytes(step), bytes(width),
                                           static_cast<std::size_t>(rows), kind, stream_),
               "cudaMemcpy2DAsync");
  }
  void wait() const;

  [[nodiscard]] void* stream() const { return stream_; }
  [[nodiscard]] void* blas() const { return blas_; }
  [[nodiscard]] void* solver() const { return solver_; }

 private:
  struct Nothing {};
  explicit Queue(Nothing) {}  // if the public constructor fails after this one, the destructor still runs
  void copy(void* to, const void* from, std::size_t bytes, int kind) const;

  void *stream_ = nullptr, *blas_ = nullptr, *solver_ = nullptr;
};

// Points in time by the clock of the device: before and after the copies and the computation of a call.
class Marks {
 public:
  Marks();
  ~Marks();
  Marks(const Marks&) = delete;
  Marks& operator=(const Marks&) = delete;

  void set(std::size_t mark, const Queue& queue) const;
  // From this mark to the next one, after Queue::wait().
  [[nodiscard]] double seconds(std::size_t mark) const;

 private:
  struct Nothing {};
  explicit Marks(Nothing) {}
  std::array<void*, 4> events_{};
};

}  // namespace assur::cuda
