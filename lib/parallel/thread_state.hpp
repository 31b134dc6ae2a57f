// Thread settings that a call changes and restores: the threads of the BLAS library, and the processors that the thread
// may run on. No other file changes them.
#pragma once

#include <sched.h>

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace assur {

// The BLAS library that is loaded, e.g. "OpenBLAS 0.3.21, OpenMP, SkylakeX"; "LAPACK" if unknown. The linker cannot
// distinguish builds for OpenMP, for pthreads and for one thread.
[[nodiscard]] std::string blas_version();

// The reason why OpenBLAS does not use all instructions of the processor, with a remedy: it knows processors by name,
// and treats a newer one like the oldest. "" if it uses them, or if it is not loaded.
[[nodiscard]] std::string blas_slowed();

// The same for kernels of this name (openblas_get_corename()) on a processor with these instructions
// (instruction_set()).
[[nodiscard]] std::string slow_kernels(std::string_view core, std::string_view instructions);

// The reason why BLAS calls of this thread cannot use this number of threads without changing other threads; "": they
// can.
[[nodiscard]] std::string why_not_blas_threads(int threads);

// Address space that OpenBLAS needs for each thread that calls it (BUFFER_SIZE in its common_x86_64.h, and a page). If
// it gets no memory, it asks again and again without end.
inline constexpr std::size_t kBlasBuffer = (std::size_t{128} << 20) + 4096;

// The reason why not every thread has memory to call BLAS; "": every thread can.
[[nodiscard]] std::string why_not_blas_memory();

// Sets the number of threads for BLAS calls of this thread until the end of the scope. why_not_blas_threads() must be
// "" for this number.
class BlasThreads {
 public:
  explicit BlasThreads(int threads);
  ~BlasThreads();
  BlasThreads(const BlasThreads&) = delete;
  BlasThreads& operator=(const BlasThreads&) = delete;

 private:
  int before_ = 0;
  bool shares_ = false;  // its calls may use more than one thread
};

// Logical processors that the calling thread may run on, by the numbers of the system, ascending; empty if unknown.
[[nodiscard]] std::vector<int> allowed_processors();

// Keeps the calling thread, and the threads that it starts, on one processor until the end of the scope. Allocates no
// memory. If the thread is on this processor already, it takes hardly any time. Throws Error (environment) if the
// thread may not run there.
class Pinned {
 public:
  explicit Pinned(int processor);
  ~Pinned();
  Pinned(const Pinned&) = delete;
  Pinned& operator=(const Pinned&) = delete;

 private:
  std::array<cpu_set_t, 8> before_;  // of 1024 processors each, the maximum of Linux
  bool changed_ = false;
};

}  // namespace assur
