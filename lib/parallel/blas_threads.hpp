// The threads of the BLAS library, whichever of them is loaded: its builds for OpenMP, for pthreads and for one thread
// look alike to the linker. The only place that touches them.
#pragma once

#include <string>

namespace assur {

// What is loaded, e.g. "OpenBLAS 0.3.21, OpenMP, SkylakeX"; "LAPACK" if it does not say.
[[nodiscard]] std::string blas_version();

// "" if BLAS calls of this thread can be given so many threads without changing those of another thread.
[[nodiscard]] std::string why_not_blas_threads(int threads);

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
};

}  // namespace assur
