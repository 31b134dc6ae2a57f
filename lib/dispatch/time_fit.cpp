#include "dispatch/time_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "median.hpp"

namespace assur {
namespace {

constexpr double kBandwidth = 0.35;      // in logarithms: sizes a factor of 1.4 apart still influence each other
constexpr double kShrink = 0.15;         // weight of the fit among the neighbours
constexpr double kHuber = 0.15;          // relative deviation; a point with a larger one counts as an outlier
constexpr double kSurelyNear = 0.861;    // > exp(-kHuber)
constexpr double kLeastNoise = 0.02;     // relative; smaller noise is raised to this
constexpr double kLeastSeconds = 1e-12;  // smallest result of a fit
constexpr double kFarAway = 0.7;         // = log 2
constexpr double kEnough = 8;            // number of points at which the trust in the fit doubles
constexpr float kNowhere = 1e9F;         // beyond the reach of any neighbour
constexpr int kReweightings = 6;         // a choice
constexpr double kWild = 1.1;            // = log 3: measurements of the same thing do not differ by more
constexpr double kSurrounded = 0.5;      // sum of the weights of neighbours that show what a point should be

using Terms = std::array<double, kTerms>;
using Gram = Eigen::Matrix<double, kTerms, kTerms>;
using Moments = Eigen::Matrix<double, kTerms, 1>;

// min x'Gx - 2 m'x over x >= 0: first without bounds, then repeatedly without the most negative term. The result is
// usually the minimum, and always close to it.
Moments non_negative(const Gram& gram, const Moments& moments) {
  std::array<Eigen::Index, kTerms> index{};
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; i < moments.size(); ++i) {
    if (gram(i, i) > 0) index[static_cast<std::size_t>(count++)] = i;
  }
  Moments out = Moments::Zero();
  while (count > 0) {
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kTerms, kTerms> g(count, count);
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kTerms, 1> m(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      m[i] = moments[index[static_cast<std::size_t>(i)]];
      for (Eigen::Index j = 0; j < count; ++j) {
        g(i, j) = gram(index[static_cast<std::size_t>(i)], index[static_cast<std::size_t>(j)]);
      }
      g(i, i) *= 1 + 1e-9;  // terms that are proportional at all points share their effect
    }
    g.llt().solveInPlace(m);
    Eigen::Index worst = 0;
    const double least = m.minCoeff(&worst);
    if (least >= 0) {
      for (Eigen::Index i = 0; i < count; ++i) out[index[static_cast<std::size_t>(i)]] = m[i];
      return out;
    }
    std::copy(index.begin() + worst + 1, index.begin() + count, index.begin() + worst);
    --count;
  }
  return out;
}

// Cost of a unit of each term if it were the only term: median over the points.
Terms medians_of_ratios(const std::vector<TimeFit::Measured>& points) {
  Terms scale{};
  for (std::size_t j = 0; j < kTerms; ++j) {
    std::vector<double> ratios;
    for (const TimeFit::Measured& p : points) {
      if (p.at.terms[j] > 0) ratios.push_back(p.seconds / p.at.terms[j]);
    }
    if (!ratios.empty()) scale[j] = median(std::move(ratios));
  }
  return scale;
}

}  // namespace

TimeFit::TimeFit(const std::vector<Measured>& points) : points_(points.size()) {
  fit(points);
  Deviations none{};
  for (auto& axis : none.place) axis.fill(kNowhere);
  deviations_.assign((points.size() + kBlock - 1) / kBlock, none);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Measured& p = points[i];
    Deviations& block = deviations_[i / kBlock];
    const std::size_t at = i % kBlock;
    for (std::size_t axis = 0; axis < kAxes; ++axis) block.place[axis][at] = static_cast<float>(p.at.place[axis]);
    const double noise = std::max(p.noise, kLeastNoise) / kLeastNoise;
    block.log_ratio[at] = static_cast<float>(std::log(p.seconds / fitted(p.at)));
    block.weight[at] = static_cast<float>(1 / (noise * noise));
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (contradicts_neighbours(i)) outliers_.push_back(i);
  }
  for (const std::size_t i : outliers_) deviations_[i / kBlock].weight[i % kBlock] = 0;
}

// All neighbours count alike: even noisy ones are much closer to each other than a factor of three.
bool TimeFit::contradicts_neighbours(std::size_t i) const {
  const Deviations& own = deviations_[i / kBlock];
  const double deviation = own.log_ratio[i % kBlock];
  if (std::abs(deviation) <= kWild) return false;
  double sum = 0, mean = 0;
  for (std::size_t k = 0; k < points_; ++k) {
    if (k == i) continue;
    const Deviations& other = deviations_[k / kBlock];
    double distance = 0;
    for (std::size_t axis = 0; axis < kAxes; ++axis) {
      distance += std::pow(other.place[axis][k % kBlock] - own.place[axis][i % kBlock], 2);
    }
    const double near = std::exp(distance / (-2 * kBandwidth * kBandwidth));
    sum += near;
    mean += near * other.log_ratio[k % kBlock];
  }
  return sum >= kSurrounded && std::abs(deviation - mean / sum) > kWild;
}

// Deviations are relative to the larger of measured and fitted time, so that none exceeds 1 in either direction.
void TimeFit::fit(const std::vector<Measured>& points) {
  // At first all terms have equal shares of the median point.
  const Terms scale = medians_of_ratios(points);
  const auto used = std::count_if(scale.begin(), scale.end(), [](double x) { return x > 0; });
  // A column for each term, scaled.
  const auto count = static_cast<Eigen::Index>(points.size());
  Eigen::ArrayXXd terms(count, used), row(count, used);
  Eigen::ArrayXd seconds(count), fits(count), share(count), weighed(count), weight = Eigen::ArrayXd::Ones(count);
  std::array<std::size_t, kTerms> term{};  // the term of each column
  for (std::size_t j = 0, column = 0; j < kTerms; ++j) {
    if (scale[j] > 0) term[column++] = j;
  }
  for (Eigen::Index i = 0; i < count; ++i) {
    const Measured& p = points[static_cast<std::size_t>(i)];
    seconds[i] = p.seconds;
    for (Eigen::Index c = 0; c < used; ++c) {
      const std::size_t j = term[static_cast<std::size_t>(c)];
      terms(i, c) = p.at.terms[j] * scale[j];
    }
  }
  Moments x = Moments::Zero();
  x.head(used).setConstant(1 / static_cast<double>(std::max<Eigen::Index>(used, 1)));
  const auto fit_all = [&] {
    fits.setZero();
    for (Eigen::Index c = 0; c < used; ++c) fits += x[c] * terms.col(c);
    fits = fits.max(kLeastSeconds);
  };
  fit_all();
  for (int round = 0; round < kReweightings; ++round) {
    share = seconds.max(fits).inverse();
    for (Eigen::Index c = 0; c < used; ++c) row.col(c) = terms.col(c) * share;
    share *= seconds;
    Gram gram = Gram::Zero();
    Moments moments = Moments::Zero();
    for (Eigen::Index c = 0; c < used; ++c) {
      weighed = row.col(c) * weight;
      moments[c] = (weighed * share).sum();
      for (Eigen::Index d = 0; d <= c; ++d) gram(c, d) = gram(d, c) = (weighed * row.col(d)).sum();
    }
    x = non_negative(gram, moments);
    fit_all();
    for (Eigen::Index i = 0; i < count; ++i) {
      const double ratio = seconds[i] / fits[i];
      const bool near = ratio > kSurelyNear && ratio * kSurelyNear < 1;  // most of them, without a logarithm
      const double deviation = near ? 0 : std::abs(std::log(ratio));
      weight[i] = deviation <= kHuber ? 1 : kHuber / deviation;
    }
  }
  for (Eigen::Index c = 0; c < used; ++c) {
    const std::size_t j = term[static_cast<std::size_t>(c)];
    coefficients_[j] = x[c] * scale[j];
  }
}

double TimeFit::fitted(const FitPoint& point) const {
  double sum = 0;
  for (std::size_t j = 0; j < kTerms; ++j) sum += coefficients_[j] * point.terms[j];
  return std::max(sum, kLeastSeconds);
}

Prediction TimeFit::at(const FitPoint& point, double otherwise) const {
  using Block = Eigen::Array<float, kBlock, 1>;
  using Blocks = Eigen::Map<const Block>;
  constexpr auto kNear = static_cast<float>(2 * kBandwidth * kBandwidth);
  // Spread of the neighbours, over a wider range; without neighbours, the error of the fit.
  constexpr double kAnyPoint = 1e-3;
  double sum = kShrink, shift = 0, weights = kAnyPoint * static_cast<double>(points_), mean = 0, square = 0;
  Block nearest = Block::Constant(std::numeric_limits<float>::infinity());
  for (const Deviations& d : deviations_) {
    Block distance = Block::Zero();
    for (std::size_t axis = 0; axis < kAxes; ++axis) {
      distance += (Blocks(d.place[axis].data()) - static_cast<float>(point.place[axis])).square();
    }
    nearest = nearest.min(distance);
    const Blocks log_ratio(d.log_ratio.data()), weight(d.weight.data());
    const Block root = (distance / (-4 * kNear)).exp(), far = weight * root, near = far * root.cube();
    sum += near.sum();
    shift += (near * log_ratio).sum();
    const Block wide = far + static_cast<float>(kAnyPoint);
    weights += far.sum();
    mean += (wide * log_ratio).sum();
    square += (wide * log_ratio.square()).sum();
  }
  shift /= sum;
  const double spread = std::max(0.0, square - 2 * shift * mean + shift * shift * weights);
  const double closest = std::sqrt(nearest.minCoeff()), away = std::max(0.0, closest - kBandwidth);
  double seconds = fitted(point) * std::exp(shift);
  if (otherwise > 0) {
    const double doubt = std::pow(away, 4), trust = 1 + static_cast<double>(points_) / kEnough;
    seconds *= std::pow(otherwise / seconds, doubt / (doubt + trust));
  }
  return {seconds, std::exp(std::sqrt(spread / weights + kLeastNoise * kLeastNoise) + 0.3 * away),
          closest <= kFarAway ? Origin::interpolated : Origin::extrapolated};
}

}  // namespace assur
