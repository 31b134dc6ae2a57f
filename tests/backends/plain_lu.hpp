// A simple backend for tests: dense LU with partial pivoting that computes in float or double.
#pragma once

#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "assur/backend.hpp"

namespace assur::test {

template <typename Real>
class PlainLu final : public LinearSolver {
 public:
  Status analyze(const Pattern& pattern, int lanes) override {
    pattern_ = pattern;
    lanes_ = static_cast<std::size_t>(lanes);
    n_ = static_cast<std::size_t>(pattern.n);
    lu_.assign(lanes_ * n_ * n_, 0);
    row_.assign(lanes_ * n_, 0);
    y_.assign(n_, 0);
    ok_.assign(lanes_, 0);
    return {};
  }

  Status factorize(std::span<const double> values) override {
    Status status;
    for (std::size_t lane = lanes_; lane-- > 0;) {
      ok_[lane] = factorize_lane(values, lane);
      if (!ok_[lane]) status = {Code::singular, Place::lane(static_cast<std::int32_t>(lane))};
    }
    return status;
  }

  Status solve(std::span<double> b_to_x, int rhs, Transpose transpose, int) override {
    for (std::size_t r = 0; r < static_cast<std::size_t>(rhs); ++r) {
      for (std::size_t lane = 0; lane < lanes_; ++lane) {
        double* const b = b_to_x.data() + r * n_ * lanes_ + lane;
        transpose == Transpose::no ? solve_lane(b, lane) : solve_transposed(b, lane);
      }
    }
    return {};
  }

  [[nodiscard]] Figures figures(int lane) const override { return {ok_[static_cast<std::size_t>(lane)] != 0, 1, 1, 1}; }

 private:
  Real& at(std::size_t lane, std::size_t i, std::size_t j) { return lu_[(lane * n_ + i) * n_ + j]; }

  bool factorize_lane(std::span<const double> values, std::size_t lane) {
    for (std::size_t j = 0; j < n_; ++j) {
      row_[lane * n_ + j] = j;
      for (std::size_t i = 0; i < n_; ++i) at(lane, i, j) = 0;
    }
    for (std::size_t j = 0; j < n_; ++j) {
      for (auto k = static_cast<std::size_t>(pattern_.column_start[j]);
           k < static_cast<std::size_t>(pattern_.column_start[j + 1]); ++k) {
        at(lane, static_cast<std::size_t>(pattern_.row[k]), j) = static_cast<Real>(values[k * lanes_ + lane]);
      }
    }
    for (std::size_t k = 0; k < n_; ++k) {
      std::size_t p = k;
      for (std::size_t i = k + 1; i < n_; ++i) {
        if (std::abs(at(lane, i, k)) > std::abs(at(lane, p, k))) p = i;
      }
      if (!(std::abs(at(lane, p, k)) > 0) || !std::isfinite(at(lane, p, k))) return false;
      for (std::size_t j = 0; j < n_; ++j) std::swap(at(lane, k, j), at(lane, p, j));
      std::swap(row_[lane * n_ + k], row_[lane * n_ + p]);
      for (std::size_t i = k + 1; i < n_; ++i) {
        const Real factor = at(lane, i, k) /= at(lane, k, k);
        for (std::size_t j = k + 1; j < n_; ++j) at(lane, i, j) -= factor * at(lane, k, j);
      }
    }
    return true;
  }

  void solve_lane(double* b, std::size_t lane) {
    for (std::size_t i = 0; i < n_; ++i) {
      y_[i] = static_cast<Real>(b[row_[lane * n_ + i] * lanes_]);
      for (std::size_t j = 0; j < i; ++j) y_[i] -= at(lane, i, j) * y_[j];
    }
    for (std::size_t i = n_; i-- > 0;) {
      for (std::size_t j = i + 1; j < n_; ++j) y_[i] -= at(lane, i, j) * y_[j];
      y_[i] /= at(lane, i, i);
    }
    for (std::size_t i = 0; i < n_; ++i) b[i * lanes_] = y_[i];
  }

  void solve_transposed(double* b, std::size_t lane) {
    for (std::size_t i = 0; i < n_; ++i) {
      y_[i] = static_cast<Real>(b[i * lanes_]);
      for (std::size_t j = 0; j < i; ++j) y_[i] -= at(lane, j, i) * y_[j];
      y_[i] /= at(lane, i, i);
    }
    for (std::size_t i = n_; i-- > 0;) {
      for (std::size_t j = i + 1; j < n_; ++j) y_[i] -= at(lane, j, i) * y_[j];
    }
    for (std::size_t i = 0; i < n_; ++i) b[row_[lane * n_ + i] * lanes_] = y_[i];
  }

  Pattern pattern_;
  std::size_t n_ = 0, lanes_ = 0;
  std::vector<Real> lu_, y_;
  std::vector<std::size_t> row_;
  std::vector<char> ok_;
};

inline constexpr Backend kPlainLu = {
    .id = "plain_lu",
    .why_not = [](const Shape&, ThreadBudget) { return std::string(); },
    .make = [](ThreadBudget, Precision precision) -> std::unique_ptr<LinearSolver> {
      if (precision == Precision::binary32) return std::make_unique<PlainLu<float>>();
      return std::make_unique<PlainLu<double>>();
    },
    .version = [] { return std::string("1"); },
    .licence = "Apache-2.0",
    .dense = true,
    .single = true,
    .steady = true,
};

}  // namespace assur::test
