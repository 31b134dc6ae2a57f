// Bare calls of a linear algebra library, for one matrix whose pattern stays the same.
#pragma once

#include <klu.h>

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <vector>

#include "assur/backend.hpp"

namespace assur::bench {

// klu_analyze once, klu_factor once, then klu_refactor.
class BareKlu {
 public:
  static constexpr std::string_view kBackend = "klu";

  // Settings of KLU. tolerance: a pivot on the diagonal is accepted down to this share of the largest entry of its
  // column; the default is that of the backend, so that both have the same fill. scale: 2 divides each row by its
  // largest entry in every factorisation; a negative value neither scales nor checks the pattern.
  explicit BareKlu(const Pattern& pattern, double tolerance = kTolerance, int scale = 2)
      : start_(pattern.column_start), row_(pattern.row), n_(pattern.n) {
    klu_defaults(&common_);
    common_.tol = tolerance;
    common_.scale = scale;
    symbolic_ = klu_analyze(n_, start_.data(), row_.data(), &common_);
  }
  BareKlu(const BareKlu&) = delete;
  BareKlu& operator=(const BareKlu&) = delete;
  ~BareKlu() {
    klu_free_numeric(&numeric_, &common_);
    klu_free_symbolic(&symbolic_, &common_);
  }

  bool factorize(const double* values) {
    double* const x = const_cast<double*>(values);  // KLU does not write to them
    if (numeric_ != nullptr) return klu_refactor(start_.data(), row_.data(), x, symbolic_, numeric_, &common_) != 0;
    numeric_ = klu_factor(start_.data(), row_.data(), x, symbolic_, &common_);
    return numeric_ != nullptr;
  }
  bool solve(double* b_to_x) { return klu_solve(symbolic_, numeric_, n_, 1, b_to_x, &common_) != 0; }

 protected:
  static constexpr double kTolerance = 0.5;

 private:
  std::vector<int> start_, row_;
  int n_;
  klu_common common_{};
  klu_symbolic* symbolic_ = nullptr;
  klu_numeric* numeric_ = nullptr;
};

// The fastest settings of KLU. They are safe only if all rows are of similar size, as in the benchmarks.
class BareKluUnscaled : public BareKlu {
 public:
  explicit BareKluUnscaled(const Pattern& pattern) : BareKlu(pattern, kTolerance, -1) {}
};

#ifdef ASSUR_BENCH_LAPACK
extern "C" {
void dgetrf_(const int* m, const int* n, double* a, const int* lda, int* pivot, int* info);
void dgetrs_(const char* trans, const int* n, const int* nrhs, const double* a, const int* lda, const int* pivot,
             double* b, const int* ldb, int* info, std::size_t trans_length);
[[gnu::weak]] void openblas_set_num_threads(int threads);  // null in another LAPACK
}

// Nonzeros scattered into a dense matrix, dgetrf, dgetrs.
class BareLapack {
 public:
  static constexpr std::string_view kBackend = "lapack";

  explicit BareLapack(const Pattern& pattern) : n_(pattern.n) {
    const auto n = static_cast<std::size_t>(n_);
    matrix_.resize(n * n);
    pivot_.resize(n);
    for (std::size_t j = 0; j < n; ++j) {
      for (auto k = pattern.column_start[j]; k < pattern.column_start[j + 1]; ++k) {
        place_.push_back(j * n + static_cast<std::size_t>(pattern.row[static_cast<std::size_t>(k)]));
      }
    }
  }

  bool factorize(const double* values) {
    std::fill(matrix_.begin(), matrix_.end(), 0.0);
    for (std::size_t k = 0; k < place_.size(); ++k) matrix_[place_[k]] = values[k];
    int info = 0;
    dgetrf_(&n_, &n_, matrix_.data(), &n_, pivot_.data(), &info);
    return info == 0;
  }
  bool solve(double* b_to_x) {
    const int one = 1;
    int info = 0;
    dgetrs_("N", &n_, &one, matrix_.data(), &n_, pivot_.data(), b_to_x, &n_, &info, 1);
    return info == 0;
  }

 private:
  int n_;
  std::vector<double> matrix_;  // n x n
  std::vector<int> pivot_;
  std::vector<std::size_t> place_;  // nnz
};
#endif

}  // namespace assur::bench
