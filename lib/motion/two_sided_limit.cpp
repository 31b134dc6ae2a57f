#include "motion/two_sided_limit.hpp"

#include <cmath>

namespace assur {
namespace {

using Jet4 = std::array<double, 4>;  // coefficients of 1, x, x^2, x^3

Jet4 times(const Jet4& a, const Jet4& b) {
  Jet4 out{};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; i + j < 4; ++j) out[i + j] += a[i] * b[j];
  }
  return out;
}

}  // namespace

// With the Lagrange polynomials l_k, the Hermite polynomial has the weights (1 - 2 (x - x_k) l_k'(x_k)) l_k(x)^2 for
// values and (x - x_k) l_k(x)^2 for rates.
template <class Take>
TwoSidedLimit::Weights TwoSidedLimit::weights(double reach, const Take& take) {
  std::array<double, kSamples> x{};
  for (std::size_t k = 0; k < kLimitPlaces.size(); ++k) {
    x[k] = -kLimitPlaces[k];
    x[k + kLimitPlaces.size()] = kLimitPlaces[k];
  }
  Weights w;
  for (std::size_t k = 0; k < kSamples; ++k) {
    if (!take(x[k])) continue;
    Jet4 lagrange{1, 0, 0, 0};
    double slope = 0;
    for (std::size_t j = 0; j < kSamples; ++j) {
      if (j == k || !take(x[j])) continue;
      const double apart = x[k] - x[j];
      lagrange = times(lagrange, {-x[j] / apart, 1 / apart, 0, 0});
      slope += 1 / apart;
    }
    const Jet4 square = times(lagrange, lagrange);
    const Jet4 of_value = times(square, {1 + 2 * x[k] * slope, -2 * slope, 0, 0}),
               of_rate = times(square, {-x[k], 1, 0, 0});
    double factorial = 1, unit = 1;  // d!, reach^-d
    for (std::size_t d = 0; d < 4; ++d) {
      w.of_value[d][k] = of_value[d] * factorial * unit;
      w.of_rate[d][k] = of_rate[d] * factorial * unit * reach;
      factorial *= static_cast<double>(d + 1);
      unit /= reach;
    }
  }
  return w;
}

TwoSidedLimit::TwoSidedLimit(double reach)
    : far_(weights(reach, [](double x) { return std::fmod(x, 0.25) == 0; })),
      near_(weights(reach, [](double x) { return std::abs(x) <= 0.5; })),
      before_(weights(reach, [](double x) { return x < 0; })),
      behind_(weights(reach, [](double x) { return x > 0; })) {}

std::array<double, 4> TwoSidedLimit::apply(const Weights& w, std::span<const double, kSamples> values,
                                           std::span<const double, kSamples> rates) {
  std::array<double, 4> out{};
  for (std::size_t d = 0; d < 4; ++d) {
    for (std::size_t k = 0; k < kSamples; ++k) {
      out[d] += w.of_value[d][k] * values[k] + w.of_rate[d][k] * rates[k];
    }
  }
  return out;
}

TwoSidedLimit::Limit TwoSidedLimit::of(std::span<const double, kSamples> values,
                                       std::span<const double, kSamples> rates) const {
  Limit limit;
  limit.value = apply(far_, values, rates);
  const auto near = apply(near_, values, rates), before = apply(before_, values, rates),
             behind = apply(behind_, values, rates);
  for (std::size_t d = 0; d < 3; ++d) {
    limit.error[d] = std::abs(limit.value[d] - near[d]);
    limit.gap[d] = std::abs(behind[d] - before[d]);
  }
  return limit;
}

}  // namespace assur
