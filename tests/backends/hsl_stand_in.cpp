// Replaces the shared library of HSL in tests: dense elimination with partial pivoting stands behind the four entries
// of MA27 (argument lists of its specification, version 1.0.0, section 2.1). As specified, too short workspaces are
// refused with the length that is needed, singularity is a warning, and nothing is printed.
#include <algorithm>
#include <cstddef>

#include "backends/column_lu.hpp"

namespace {

// After factorisation, A holds the dense factors, column-major, and IW the exchanged rows.
constexpr int kTooFewIntegers = -3, kTooFewReals = -4, kRankDeficient = 3;

}  // namespace

extern "C" {

void ma27id_(int* icntl, double* cntl) {
  std::fill_n(icntl, 30, 0);
  std::fill_n(cntl, 5, 0.0);
  icntl[0] = icntl[1] = 6;  // streams for messages, which the caller must turn off
  cntl[0] = 0.1;
}

void ma27ad_(const int* n, const int* nz, const int*, const int*, int*, const int* liw, int* ikeep, int*, int* nsteps,
             int* iflag, int*, double*, int* info, double* ops) {
  std::fill_n(info, 20, 0);
  if (*liw < 2 * *nz + 3 * *n + 1) {
    info[0] = kTooFewIntegers;
    info[1] = 2 * *nz + 3 * *n + 1;
    return;
  }
  for (int i = 0; i < 3 * *n; ++i) ikeep[i] = i;
  *nsteps = *n;
  *ops = *iflag;
  info[4] = *nz + *n;  // too little on purpose, because pivoting may need more than the analysis predicts
  info[5] = *nz;
}

void ma27bd_(const int* n, const int* nz, const int* irn, const int* icn, double* a, const int* la, int* iw,
             const int* liw, int* ikeep, const int* nsteps, int* maxfrt, int*, int* icntl, double*, int* info) {
  const auto order = static_cast<std::size_t>(*n), nonzeros = static_cast<std::size_t>(*nz);
  const bool kept = *nsteps == *n && ikeep[3 * *n - 1] == 3 * *n - 1;
  info[0] = kept && icntl[0] <= 0 && icntl[1] <= 0 ? 0 : -7;
  if (info[0] < 0) return;
  if (*liw < *n) {
    info[0] = kTooFewIntegers;
    info[1] = *n;
    return;
  }
  const std::size_t needed = order * order + nonzeros;
  if (static_cast<std::size_t>(*la) < needed) {
    info[0] = kTooFewReals;
    info[1] = static_cast<int>(needed);
    return;
  }
  double* const values = a + order * order;
  std::copy_backward(a, a + nonzeros, values + nonzeros);
  std::fill_n(a, order * order, 0.0);
  for (std::size_t k = 0; k < nonzeros; ++k) {
    const auto i = static_cast<std::size_t>(irn[k] - 1), j = static_cast<std::size_t>(icn[k] - 1);
    a[j * order + i] += values[k];
    if (i != j) a[i * order + j] += values[k];
  }
  *maxfrt = *n;
  if (assur::test::column_getrf(*n, a, *n, iw) != 0) info[0] = kRankDeficient;
}

void ma27cd_(const int* n, double* a, const int*, int* iw, const int*, double* w, const int* maxfrt, double* rhs, int*,
             const int*, int*, int* info) {
  info[0] = 0;
  std::fill_n(w, *maxfrt, 0.0);
  assur::test::column_getrs(false, *n, 1, a, *n, iw, rhs, *n);
}
}
