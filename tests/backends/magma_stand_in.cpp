// Replaces the shared library of MAGMA 2 in tests, where it computes on the processor. With ASSUR_STAND_IN=no_device,
// magma_init() fails as it does without a GPU.
#include <cstdlib>
#include <string_view>

#include "backends/column_lu.hpp"

namespace {

template <class T>
int getrf(int m, int n, T* a, int lda, int* pivot, int* info) {
  *info = m == n && lda >= n ? assur::test::column_getrf(n, a, lda, pivot) : -1;
  return *info;
}

}  // namespace

extern "C" {

int magma_init() {
  const char* const mode = std::getenv("ASSUR_STAND_IN");
  return mode && std::string_view(mode) == "no_device" ? -101 : 0;
}

void magma_version(int* major, int* minor, int* micro) {
  *major = 2;
  *minor = 7;
  *micro = 1;
}

int magma_dgetrf(int m, int n, double* a, int lda, int* pivot, int* info) { return getrf(m, n, a, lda, pivot, info); }
int magma_sgetrf(int m, int n, float* a, int lda, int* pivot, int* info) { return getrf(m, n, a, lda, pivot, info); }
}
