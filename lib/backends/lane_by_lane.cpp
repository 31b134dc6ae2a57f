#include "backends/lane_by_lane.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "backends/backends.hpp"

namespace assur {

Status LaneByLane::analyze(const Pattern& pattern, int lanes) {
  check_analysis(pattern, lanes);
  n_ = static_cast<std::size_t>(pattern.n);
  values_.resize(pattern.row.size());
  right_.resize(n_ * kRightSides);
  code_.assign(static_cast<std::size_t>(lanes), Code::singular);  // until factorize()
  status_ = worst(code_);
  if (!values_.empty()) analyze_lanes(pattern, lanes);
  return {};
}

Status LaneByLane::factorize(std::span<const double> values) {
  check_size("values", values.size(), values_.size() * code_.size());
  for (std::size_t lane = 0; lane < code_.size(); ++lane) {
    code_[lane] = take_and_factorize(values, static_cast<int>(lane));
  }
  return status_ = worst(code_);
}

Code LaneByLane::take_and_factorize(std::span<const double> values, int lane) {
  if (values_.empty()) return n_ == 0 ? Code::ok : Code::singular;
  const int lanes = static_cast<int>(code_.size());
  if (lanes == 1) {
    const bool finite = all_within(values, std::numeric_limits<double>::max());
    return finite ? factorize_lane(values, lane) : Code::not_finite;
  }
  return std::isfinite(take_lane(values, lanes, lane, values_)) ? factorize_lane(values_, lane) : Code::not_finite;
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
      const std::size_t count = std::min<std::size_t>(kRightSides, columns - r);
      double* const given = b_to_x.data() + r * n_ * w + lane;
      const std::span<double> right(w == 1 ? given : right_.data(), n_ * count);
      for (std::size_t i = 0; w > 1 && i < right.size(); ++i) right[i] = given[i * w];
      solve_lane(right, static_cast<int>(count), transpose, static_cast<int>(lane));
      for (std::size_t i = 0; w > 1 && i < right.size(); ++i) given[i * w] = right[i];
    }
  }
  return status_;
}

Figures LaneByLane::figures(int lane) const {
  if (code_[static_cast<std::size_t>(lane)] != Code::ok) return {};
  if (n_ == 0) return {true, 1, 1, 1};
  return lane_figures(lane);
}

}  // namespace assur
