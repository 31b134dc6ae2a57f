// What a call borrows of its thread and gives back: the threads of the BLAS library, and the processors that the thread
// may run on. The only place that changes either.
#pragma once

#include <sched.h>

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace assur {

// What is loaded, e.g. "OpenBLAS 0.3.21, OpenMP, SkylakeX"; "LAPACK" if it does not say. The builds for OpenMP, for
// pthreads and for one thread look alike to the linker.
[[nodiscard]] std::string blas_version();

// Why OpenBLAS does not use what the processor has, and what helps: it knows processors by name, and takes one that is
// newer than itself for the oldest. "" if it does, or is not loaded.
[[nodiscard]] std::string blas_slowed();

// The same for kernels of this name (openblas_get_corename()) on a processor with such instructions
// (instruction_set()).
[[nodiscard]] std::string slow_kernels(std::string_view core, std::string_view instructions);

// "" if BLAS calls of this thread can be given so many threads without changing those of another thread.
[[nodiscard]] std::string why_not_blas_threads(int threads);

// OpenBLAS takes so much address space for each thread that calls it (BUFFER_SIZE in its common_x86_64.h, and a page),
// and where it gets none it asks for ever.
inline constexpr std::size_t kBlasBuffer = (std::size_t{128} << 20) + 4096;

// "" if every thread can call BLAS.
[[nodiscard]] std::string why_not_blas_memory();

// Gives the BLAS calls of this thread so many threads until the end of the scope. Only with a number for which
// why_not_blas_threads() is "".
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

// Processors (logical, numbered by the system, ascending) that the calling thread may run on; empty if it is not told.
[[nodiscard]] std::vector<int> allowed_processors();

// Keeps the calling thread, and the threads that it starts, on one processor until the end of the scope. Takes no
// memory; within another one for the same processor hardly any time, for the system is only asked. Throws Error
// (environment) if it may not run there.
class Pinned {
 public:
  explicit Pinned(int processor);
  ~Pinned();
  Pinned(const Pinned&) = delete;
  Pinned& operator=(const Pinned&) = delete;

 private:
  std::array<cpu_set_t, 8> before_;  // of 1024 processors each: as many as Linux can be built for
  bool changed_ = false;
};

}  // namespace assur
