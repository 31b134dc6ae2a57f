// LU with partial pivoting on column-major matrices, for libraries that replace others in tests. Arguments are those of
// LAPACK's getrf and getrs.
#pragma once

#include <cmath>
#include <cstddef>
#include <utility>

namespace assur::test {

// Returns 0, or the number of the first pivot that is zero, from 1 on; elimination goes on behind it.
template <class T>
int column_getrf(int order, T* a, int stride, int* pivot) {
  const auto n = static_cast<std::size_t>(order), step = static_cast<std::size_t>(stride);
  const auto at = [&](std::size_t i, std::size_t j) -> T& { return a[j * step + i]; };
  int info = 0;
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t p = k;
    for (std::size_t i = k + 1; i < n; ++i) {
      if (std::abs(at(i, k)) > std::abs(at(p, k))) p = i;
    }
    pivot[k] = static_cast<int>(p) + 1;
    if (at(p, k) == 0) {
      if (info == 0) info = static_cast<int>(k) + 1;
      continue;
    }
    if (p != k) {
      for (std::size_t j = 0; j < n; ++j) std::swap(at(k, j), at(p, j));
    }
    for (std::size_t i = k + 1; i < n; ++i) at(i, k) /= at(k, k);
    for (std::size_t j = k + 1; j < n; ++j) {
      if (at(k, j) == 0) continue;
      for (std::size_t i = k + 1; i < n; ++i) at(i, j) -= at(i, k) * at(k, j);
    }
  }
  return info;
}

template <class T>
void column_getrs(bool transposed, int order, int rhs, const T* lu, int stride, const int* pivot, T* b,
                  int stride_of_b) {
  const auto n = static_cast<std::size_t>(order), step = static_cast<std::size_t>(stride);
  const auto at = [&](std::size_t i, std::size_t j) { return lu[j * step + i]; };
  for (int r = 0; r < rhs; ++r) {
    T* const x = b + static_cast<std::size_t>(r) * static_cast<std::size_t>(stride_of_b);
    if (!transposed) {
      for (std::size_t k = 0; k < n; ++k) std::swap(x[k], x[pivot[k] - 1]);
      for (std::size_t j = 0; j < n; ++j) {
        for (std::size_t i = j + 1; i < n; ++i) x[i] -= at(i, j) * x[j];
      }
      for (std::size_t j = n; j-- > 0;) {
        x[j] /= at(j, j);
        for (std::size_t i = 0; i < j; ++i) x[i] -= at(i, j) * x[j];
      }
    } else {
      for (std::size_t j = 0; j < n; ++j) {
        for (std::size_t i = 0; i < j; ++i) x[j] -= at(i, j) * x[i];
        x[j] /= at(j, j);
      }
      for (std::size_t j = n; j-- > 0;) {
        for (std::size_t i = j + 1; i < n; ++i) x[j] -= at(i, j) * x[i];
      }
      for (std::size_t k = n; k-- > 0;) std::swap(x[k], x[pivot[k] - 1]);
    }
  }
}

}  // namespace assur::test
