#include "backends/lanes_factors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "numbers.hpp"

namespace assur::lanes {
namespace {

constexpr double kGrowthPerUnknown = 16, kMostGrowth = 4096;  // backward errors: see lanes_factors.hpp

template <class T>
Limits limits_of(std::int32_t n) {
  // A pivot below 4 n eps of its row may be only the rounding of a zero.
  return {std::min(kGrowthPerUnknown * n, kMostGrowth), 4 * n * static_cast<double>(std::numeric_limits<T>::epsilon()),
          std::sqrt(10 * static_cast<double>(std::numeric_limits<T>::min()))};
}

// Growth compares 2-norms of rows; rows of U are taken before their division.
template <class T>
Figures measure(const Elimination& p, const T* slots, std::size_t lanes, std::size_t lane) {
  double growth = 0, smallest = kInfinity, largest = 0;
  int sign = p.permutation_sign;
  const auto at = [&](std::size_t slot) { return static_cast<double>(slots[slot * lanes + lane]); };
  for (std::size_t i = 0; i < p.n; ++i) {
    const double pivot = 1 / at(p.pivot_slot[i]), of_a = at(p.square_slot + i);
    double lower = std::abs(pivot), upper = 0;
    for (std::size_t k = 0; k < p.lower_count(i); ++k) lower = std::hypot(lower, at(p.pivot_slot[i] - 1 - k));
    for (std::size_t k = 0; k < p.upper_count(i); ++k) upper = std::hypot(upper, at(p.upper_slot[i] + k));
    // Skips rows whose squares underflow or overflow in this precision.
    if (of_a > 0 && std::isfinite(of_a)) growth = std::max(growth, std::hypot(lower, upper * pivot) / std::sqrt(of_a));
    smallest = std::min(smallest, std::abs(pivot));
    largest = std::max(largest, std::abs(pivot));
    if (pivot < 0) sign = -sign;
  }
  return {true, growth, smallest / largest, sign};
}

}  // namespace

Limits limits(std::int32_t n, Precision precision) {
  return precision == Precision::binary64 ? limits_of<double>(n) : limits_of<float>(n);
}

Factors::Factors(int lanes, Precision precision)
    : lanes_(lanes), precision_(precision), kernels_(kernels(lanes, precision)) {}

std::size_t Factors::bytes_of_slot() const {
  return static_cast<std::size_t>(lanes_) * (precision_ == Precision::binary64 ? sizeof(double) : sizeof(float));
}

void Factors::reserve(std::int32_t unknowns) {
  if (unknowns > kMostReserved) return;
  const auto n = static_cast<std::size_t>(unknowns);
  slots_.reserve((n + 1) * n * bytes_of_slot());
  work_.reserve(kRightSides * n * bytes_of_slot());
}

void Factors::set_program(std::shared_ptr<const Elimination> program) {
  const std::size_t slot = bytes_of_slot();
  slots_.assign(program->slots * slot, std::byte{0});
  work_.assign(kRightSides * program->n * slot, std::byte{0});
  program_ = std::move(program);
}

void Factors::solve(double* b_to_x, int rhs, Transpose transpose, int first_wanted) {
  if (transpose == Transpose::no) {
    kernels_.solve(*program_, slots_.data(), b_to_x, rhs, first_wanted, work_.data());
  } else {
    kernels_.solve_transposed(*program_, slots_.data(), b_to_x, rhs, work_.data());
  }
}

bool Factors::finite() const {
  const auto all = [&](const auto* slots) {
    const auto* end = slots + program_->square_slot * static_cast<std::size_t>(lanes_);
    return std::all_of(slots, end, [](auto value) { return std::isfinite(value); });
  };
  return precision_ == Precision::binary64 ? all(static_cast<const double*>(slots()))
                                           : all(static_cast<const float*>(slots()));
}

Figures Factors::figures(int lane) const {
  if (program_->n == 0) return {true, 1, 1, 1};
  const auto lanes = static_cast<std::size_t>(lanes_), l = static_cast<std::size_t>(lane);
  return precision_ == Precision::binary64 ? measure(*program_, static_cast<const double*>(slots()), lanes, l)
                                           : measure(*program_, static_cast<const float*>(slots()), lanes, l);
}

}  // namespace assur::lanes
