#include "planning/curve.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace assur {
namespace {

constexpr double kBandwidth = 0.35;   // in logarithms: sizes a factor of 1.4 apart still speak for each other
constexpr double kShrink = 0.15;      // weight of the fit among the neighbours
constexpr double kHuber = 0.15;       // relative deviation from which a point counts as an outlier
constexpr double kLeastNoise = 0.02;  // relative: no time is better known
constexpr double kFar = 0.7;          // = log 2
constexpr int kReweightings = 8;

using Terms = std::array<double, kTerms>;
using Gram = Eigen::Matrix<double, kTerms, kTerms>;
using Moments = Eigen::Matrix<double, kTerms, 1>;

double squared_distance(const std::array<double, kAxes>& a, const std::array<double, kAxes>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < kAxes; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

// min x'Gx - 2 m'x over x >= 0, by looking at every set of positive ones: there are 2^5.
Moments non_negative(const Gram& gram, const Moments& moments) {
  Moments best = Moments::Zero();
  double least = 0;
  for (unsigned set = 1; set < 1U << kTerms; ++set) {
    std::array<Eigen::Index, kTerms> index{};
    Eigen::Index count = 0;
    bool usable = true;
    for (std::size_t i = 0; i < kTerms; ++i) {
      if ((set >> i & 1U) == 0) continue;
      usable = usable && gram(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) > 0;
      index[static_cast<std::size_t>(count++)] = static_cast<Eigen::Index>(i);
    }
    if (!usable) continue;
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kTerms, kTerms> g(count, count);
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kTerms, 1> m(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      m[i] = moments[index[static_cast<std::size_t>(i)]];
      for (Eigen::Index j = 0; j < count; ++j) {
        g(i, j) = gram(index[static_cast<std::size_t>(i)], index[static_cast<std::size_t>(j)]);
      }
      g(i, i) *= 1 + 1e-12;
    }
    const auto x = g.llt().solve(m).eval();
    if (!(x.minCoeff() >= 0)) continue;
    const double value = -x.dot(m);  // at the minimum of this set
    if (!(value < least)) continue;
    least = value;
    best.setZero();
    for (Eigen::Index i = 0; i < count; ++i) best[index[static_cast<std::size_t>(i)]] = x[i];
  }
  return best;
}

}  // namespace

Curve::Curve(std::vector<Measured> points) {
  fit(points);
  for (const Measured& p : points) {
    const double noise = std::max(p.noise, kLeastNoise) / kLeastNoise;
    deviations_.push_back({p.at.place, std::log(p.seconds / fitted(p.at)), 1 / (noise * noise)});
  }
}

// Deviations count relative to what is larger, the time measured or fitted before: so no point can pull by more than
// its own size, whichever side it is on.
void Curve::fit(const std::vector<Measured>& points) {
  start_at_medians(points);
  std::vector<double> weight(points.size(), 1.0);
  for (int round = 0; round < kReweightings; ++round) {
    Gram gram = Gram::Zero();
    Moments moments = Moments::Zero();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double size = std::max(points[i].seconds, fitted(points[i].at));
      Moments row;
      for (std::size_t j = 0; j < kTerms; ++j) {
        row[static_cast<Eigen::Index>(j)] = points[i].at.terms[j] * scale_[j] / size;
      }
      gram += weight[i] * row * row.transpose();
      moments += weight[i] * points[i].seconds / size * row;
    }
    const Moments x = non_negative(gram, moments);
    for (std::size_t j = 0; j < kTerms; ++j) coefficients_[j] = x[static_cast<Eigen::Index>(j)] * scale_[j];
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double deviation = std::abs(std::log(points[i].seconds / fitted(points[i].at)));
      weight[i] = deviation <= kHuber ? 1 : kHuber / deviation;
    }
  }
}

// Each term explains its share of every point in the middle.
void Curve::start_at_medians(const std::vector<Measured>& points) {
  std::size_t used = 0;
  for (std::size_t j = 0; j < kTerms; ++j) {
    std::vector<double> ratios;
    for (const Measured& p : points) {
      if (p.at.terms[j] > 0) ratios.push_back(p.seconds / p.at.terms[j]);
    }
    scale_[j] = 0;
    if (ratios.empty()) continue;
    std::nth_element(ratios.begin(), ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2), ratios.end());
    scale_[j] = ratios[ratios.size() / 2];
    ++used;
  }
  for (std::size_t j = 0; j < kTerms; ++j)
    coefficients_[j] = scale_[j] / static_cast<double>(std::max<std::size_t>(used, 1));
}

double Curve::fitted(const Point& point) const {
  double sum = 0;
  for (std::size_t j = 0; j < kTerms; ++j) sum += coefficients_[j] * point.terms[j];
  return std::max(sum, 1e-12);
}

Prediction Curve::at(const Point& point) const {
  double sum = kShrink, shift = 0, nearest = std::numeric_limits<double>::infinity();
  for (const Deviation& d : deviations_) {
    const double distance = squared_distance(d.place, point.place);
    nearest = std::min(nearest, distance);
    const double weight = d.weight * std::exp(-distance / (2 * kBandwidth * kBandwidth));
    sum += weight;
    shift += weight * d.log_ratio;
  }
  shift /= sum;
  // How much the neighbours differ among themselves, and how much the fit is off where there are none.
  double spread = 0, weights = 0;
  for (const Deviation& d : deviations_) {
    const double weight =
        d.weight * std::exp(-squared_distance(d.place, point.place) / (8 * kBandwidth * kBandwidth)) + 1e-3;
    spread += weight * std::pow(d.log_ratio - shift, 2);
    weights += weight;
  }
  nearest = std::sqrt(nearest);
  const double away = std::max(0.0, nearest - kBandwidth);
  return {fitted(point) * std::exp(shift),
          std::exp(std::sqrt(spread / weights + kLeastNoise * kLeastNoise) + 0.3 * away),
          nearest <= kFar ? Origin::interpolated : Origin::extrapolated};
}

}  // namespace assur
