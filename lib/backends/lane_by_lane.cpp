#include "backends/lane_by_lane.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "backends/backends.hpp"

namespace assur {
namespace {
constexpr std::size_t kRightSides = 4;  // given to a library at once
}

Status LaneByLane::analyze(const Pattern& pattern, int lanes) {
  check_analysis(pattern, lanes);
  n_ = static_cast<std::size_t>(pattern.n);
  values_.resize(pattern.row.size());
  right_.resize(n_ * kRightSides);
  code_.assign(static_cast<std::size_t>(lanes), Code::singular);  // until factorised
  if (!values_.empty()) analyze_lanes(pattern, lanes);
  return {};
}

Status LaneByLane::factorize(std::span<const double> values) {
  check_size("values", values.size(), values_.size() * code_.size());
  const int lanes = static_cast<int>(code_.size());
  for (int lane = 0; lane < lanes; ++lane) {
    Code& code = code_[static_cast<std::size_t>(lane)];
    if (!std::isfinite(take_lane(values, lanes, lane, values_))) {
      code = Code::not_finite;
    } else {
      const Code empty = n_ == 0 ? Code::ok : Code::singular;
      code = values_.empty() ? empty : factorize_lane(values_, lane);
    }
  }
  return worst(code_);
}

Status LaneByLane::solve(std::span<double> b_to_x, int rhs, Transpose transpose, int) {
  const std::size_t w = code_.size(), columns = static_cast<std::size_t>(rhs);
  check_size("numbers on the right-hand side", b_to_x.size(), n_ * columns * w);
  for (std::size_t lane = 0; lane < w && n_ > 0; ++lane) {
    if (code_[lane] != Code::ok) {
      fill_with_nan(b_to_x, static_cast<int>(w), static_cast<int>(lane));
      continue;
    }
    for (std::size_t r = 0; r < columns; r += kRightSides) {
      const std::size_t count = std::min(kRightSides, columns - r);
      double* const given = b_to_x.data() + r * n_ * w + lane;
      for (std::size_t i = 0; i < n_ * count; ++i) right_[i] = given[i * w];
      solve_lane(std::span(right_).first(n_ * count), static_cast<int>(count), transpose, static_cast<int>(lane));
      for (std::size_t i = 0; i < n_ * count; ++i) given[i * w] = right_[i];
    }
  }
  return worst(code_);
}

Figures LaneByLane::figures(int lane) const {
  if (code_[static_cast<std::size_t>(lane)] != Code::ok) return {};
  if (n_ == 0) return {true, 1, 1, 1};
  return lane_figures(lane);
}

}  // namespace assur
