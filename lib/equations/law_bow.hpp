// The bow of a law on a step: how far the law may leave its chord, the straight line through its values at both ends.
// With |u''| <= m on a step of length h it is at most m h^2 / 8.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include "assur/law.hpp"
#include "scene/law_evaluate.hpp"

namespace assur {

// Upper bound of the second derivative of a polynomial between two times: Taylor's formula about the middle.
[[nodiscard]] inline double most_acceleration(std::span<const Number> coefficients, double from, double to) {
  const double middle = from + (to - from) / 2, reach = std::abs(to - from) / 2;
  double sum = 0, power = 1, factorial = 1;
  for (std::size_t k = 2; k < coefficients.size(); ++k) {  // power: reach^(k - 2), factorial: (k - 2)!
    double derivative = 0;                                 // the k-th one in the middle
    for (std::size_t i = coefficients.size(); i-- > k;) {
      double falling = coefficients[i].value();
      for (std::size_t f = 0; f < k; ++f) falling *= static_cast<double>(i - f);
      derivative = derivative * middle + falling;
    }
    sum += std::abs(derivative) * power / factorial;
    power *= reach;
    factorial *= static_cast<double>(k - 1);
  }
  return sum;
}

// Of a table, from the intervals that the step touches.
[[nodiscard]] inline double bow(const Law::Spline& s, double from, double to) {
  const auto [early, late] = std::minmax(from, to);
  const double h = late - early;
  const std::size_t last = s.time.size() - 1;
  double most = 0, lowest = s.value[0], highest = lowest, longest = 0;
  bool any = false;
  const auto take = [&](double begin, double end) {
    const auto knot = [&](double t) {
      return static_cast<std::size_t>(std::upper_bound(s.time.begin() + 1, s.time.end() - 1, t) - s.time.begin());
    };
    const std::size_t behind = knot(end);
    for (std::size_t k = knot(begin) - 1; k <= behind; ++k) {
      if (k < behind) {
        for (const double bend : s.bends(k)) most = std::max(most, std::abs(bend));
      }
      lowest = any ? std::min(lowest, s.value[k]) : s.value[k];
      highest = any ? std::max(highest, s.value[k]) : s.value[k];
      longest = std::max(longest, k < last ? s.time[k + 1] - s.time[k] : 0.0);
      any = true;
    }
  };
  if (!s.periodic) {
    take(early, late);
  } else if (const double period = s.time[last] - s.time[0]; h >= period) {
    take(s.time[0], s.time[last]);
  } else {
    const double begin = law_detail::wrap(s, early), end = begin + h;
    take(begin, std::min(end, s.time[last]));
    if (end > s.time[last]) take(s.time[0], end - period);
  }
  // Between its knots the spline leaves their values by at most the bow of an interval.
  return std::min(most * h * h / 8, highest - lowest + most * longest * longest / 4);
}

// Of a quintic through value, rate and acceleration at both ends of [0, length], on a part of it that is `step` long,
// by its Bernstein coefficients: the second derivative lies between their second differences, and what the whole leaves
// of its chord between the coefficients of the difference, of each half.
[[nodiscard]] inline double bow_of_quintic(const Motion& a, const Motion& b, double length, double step) {
  const double d = length / 5, dd = length * length / 20;
  double c[6] = {a.value,
                 a.value + d * a.rate,
                 a.value + 2 * d * a.rate + dd * a.acceleration,
                 b.value - 2 * d * b.rate + dd * b.acceleration,
                 b.value - d * b.rate,
                 b.value};
  double most = 0;
  for (int i = 0; i < 4; ++i) most = std::max(most, std::abs((c[i + 2] - c[i + 1]) - (c[i + 1] - c[i])));
  for (int i = 0; i < 6; ++i) c[i] -= a.value + i * (b.value - a.value) / 5;
  double off = 0;  // de Casteljau's algorithm in the middle: both ends of each row are coefficients of the halves
  for (int last = 5; last >= 0; --last) {
    off = std::max({off, std::abs(c[0]), std::abs(c[last])});
    for (int i = 0; i < last; ++i) c[i] = (c[i] + c[i + 1]) / 2;
  }
  const double part = length == 0 ? 0 : step / length;
  return std::min(20 * most * part * part / 8, part == 1 ? off : 2 * off);
}

}  // namespace assur
