// Routines of BLAS and LAPACK, under one name for double and float. Integers have 32 bits; the lengths of character
// arguments come last, as gfortran passes them.
#pragma once

#include <cstddef>
#include <cstdint>

#include "assur/backend.hpp"
#include "backends/block.hpp"

extern "C" {
void dgetrf_(const std::int32_t* m, const std::int32_t* n, double* a, const std::int32_t* lda, std::int32_t* pivot,
             std::int32_t* info);
void sgetrf_(const std::int32_t* m, const std::int32_t* n, float* a, const std::int32_t* lda, std::int32_t* pivot,
             std::int32_t* info);
void dgetrs_(const char* trans, const std::int32_t* n, const std::int32_t* nrhs, const double* a,
             const std::int32_t* lda, const std::int32_t* pivot, double* b, const std::int32_t* ldb, std::int32_t* info,
             std::size_t);
void sgetrs_(const char* trans, const std::int32_t* n, const std::int32_t* nrhs, const float* a,
             const std::int32_t* lda, const std::int32_t* pivot, float* b, const std::int32_t* ldb, std::int32_t* info,
             std::size_t);
void dlaswp_(const std::int32_t* n, double* a, const std::int32_t* lda, const std::int32_t* k1, const std::int32_t* k2,
             const std::int32_t* pivot, const std::int32_t* step);
void slaswp_(const std::int32_t* n, float* a, const std::int32_t* lda, const std::int32_t* k1, const std::int32_t* k2,
             const std::int32_t* pivot, const std::int32_t* step);
void dtrsm_(const char* side, const char* uplo, const char* trans, const char* diag, const std::int32_t* m,
            const std::int32_t* n, const double* alpha, const double* a, const std::int32_t* lda, double* b,
            const std::int32_t* ldb, std::size_t, std::size_t, std::size_t, std::size_t);
void strsm_(const char* side, const char* uplo, const char* trans, const char* diag, const std::int32_t* m,
            const std::int32_t* n, const float* alpha, const float* a, const std::int32_t* lda, float* b,
            const std::int32_t* ldb, std::size_t, std::size_t, std::size_t, std::size_t);
void dgemm_(const char* transa, const char* transb, const std::int32_t* m, const std::int32_t* n, const std::int32_t* k,
            const double* alpha, const double* a, const std::int32_t* lda, const double* b, const std::int32_t* ldb,
            const double* beta, double* c, const std::int32_t* ldc, std::size_t, std::size_t);
void sgemm_(const char* transa, const char* transb, const std::int32_t* m, const std::int32_t* n, const std::int32_t* k,
            const float* alpha, const float* a, const std::int32_t* lda, const float* b, const std::int32_t* ldb,
            const float* beta, float* c, const std::int32_t* ldc, std::size_t, std::size_t);
}

namespace assur::blas {

// The routines of one precision.
template <class T>
struct Routines;
template <>
struct Routines<double> {
  static constexpr auto getrf = dgetrf_;
  static constexpr auto getrs = dgetrs_;
  static constexpr auto laswp = dlaswp_;
  static constexpr auto trsm = dtrsm_;
  static constexpr auto gemm = dgemm_;
};
template <>
struct Routines<float> {
  static constexpr auto getrf = sgetrf_;
  static constexpr auto getrs = sgetrs_;
  static constexpr auto laswp = slaswp_;
  static constexpr auto trsm = strsm_;
  static constexpr auto gemm = sgemm_;
};

inline std::int32_t number(DenseIndex i) { return static_cast<std::int32_t>(i); }

// P a = L U in place. False at a pivot that is zero.
template <class T>
[[nodiscard]] bool getrf(const Block<T>& a, std::int32_t* pivot) {
  const std::int32_t m = number(a.rows), n = number(a.columns), stride = number(a.stride);
  std::int32_t info = 0;
  Routines<T>::getrf(&m, &n, a.data, &stride, pivot, &info);
  return info == 0;
}

// a x = x, or a' x = x, from the factors of a.
template <class T>
void getrs(const Block<T>& lu, const std::int32_t* pivot, const Block<T>& x, Transpose transpose) {
  const std::int32_t n = number(lu.columns), columns = number(x.columns);
  const std::int32_t stride = number(lu.stride), x_stride = number(x.stride);
  std::int32_t info = 0;
  Routines<T>::getrs(transpose == Transpose::yes ? "T" : "N", &n, &columns, lu.data, &stride, pivot, x.data, &x_stride,
                     &info, 1);
}

// Swaps the rows of a by `count` pivots.
template <class T>
void swap_rows(const Block<T>& a, const std::int32_t* pivot, DenseIndex count) {
  const std::int32_t columns = number(a.columns), stride = number(a.stride), one = 1, last = number(count);
  Routines<T>::laswp(&columns, a.data, &stride, &one, &last, pivot, &one);
}

// L x = x, where l has a unit diagonal.
template <class T>
void solve_unit_lower(const Block<T>& l, const Block<T>& x) {
  const std::int32_t n = number(l.columns), columns = number(x.columns);
  const std::int32_t stride = number(l.stride), x_stride = number(x.stride);
  const T one = 1;
  Routines<T>::trsm("L", "L", "N", "U", &n, &columns, &one, l.data, &stride, x.data, &x_stride, 1, 1, 1, 1);
}

// c -= a b, or a b'
template <class T>
void subtract_product(const Block<T>& c, const Block<T>& a, const Block<T>& b, Transpose transpose = Transpose::no) {
  const std::int32_t m = number(c.rows), n = number(c.columns), k = number(a.columns);
  const std::int32_t a_stride = number(a.stride), b_stride = number(b.stride), c_stride = number(c.stride);
  const T minus_one = -1, one = 1;
  Routines<T>::gemm("N", transpose == Transpose::yes ? "T" : "N", &m, &n, &k, &minus_one, a.data, &a_stride, b.data,
                    &b_stride, &one, c.data, &c_stride, 1, 1);
}

}  // namespace assur::blas
