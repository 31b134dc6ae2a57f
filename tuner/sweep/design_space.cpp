#include "sweep/design_space.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "assur/status.hpp"
#include "sweep/philox.hpp"

namespace assur::sweep {
namespace {

[[noreturn]] void refuse(const std::string& option, const std::string& what) {
  throw Error(Error::Kind::input, {{option, what}});
}

// side^d, at most `most` + 1.
std::int64_t power(std::int64_t side, std::size_t d, std::int64_t most) {
  std::int64_t all = 1;
  for (std::size_t i = 0; i < d; ++i) {
    if (all > most / side) return most + 1;
    all *= side;
  }
  return all;
}

std::int64_t side_of_grid(std::int64_t samples, std::size_t d) {
  const auto near = std::max<std::int64_t>(
      1, static_cast<std::int64_t>(std::pow(static_cast<double>(samples), 1.0 / static_cast<double>(d))));
  for (std::int64_t side = std::max<std::int64_t>(1, near - 1); side <= near + 1; ++side) {
    if (power(side, d, samples) == samples) return side;
  }
  constexpr std::int64_t kMost = std::int64_t{1} << 62;
  refuse("--samples", "a grid of " + std::to_string(d) + " parameters has n^" + std::to_string(d) +
                          " points, such as " + std::to_string(power(near, d, kMost)) + " or " +
                          std::to_string(power(near + 1, d, kMost)) + ", not " + std::to_string(samples));
}

// 64 random bits for parameter d of point k.
std::uint64_t random_bits(std::uint64_t seed, std::uint64_t k, std::size_t d) {
  const auto block = philox({low_half(k), high_half(k), low_half(d / 2), 0}, {low_half(seed), high_half(seed)});
  const std::size_t first = 2 * (d % 2);
  return std::uint64_t{block[first + 1]} << 32 | block[first];
}

// The first 53 bits as a number in [0, 1).
double unit(std::uint64_t bits) { return std::ldexp(static_cast<double>(bits >> 11), -53); }

}  // namespace

DesignSpace::DesignSpace(std::vector<Range> ranges, Sampler sampler, std::int64_t samples, std::uint64_t seed)
    : ranges_(std::move(ranges)), sampler_(sampler), samples_(samples), seed_(seed) {
  if (ranges_.empty()) refuse("--vary", "a sweep needs at least one parameter with its range, such as a=0.2:0.8");
  for (const Range& r : ranges_) {
    if (!std::isfinite(r.low) || !std::isfinite(r.high) || !std::isfinite(r.high - r.low) || r.low > r.high) {
      refuse("--vary", "the range of \"" + r.name + "\" must be two finite numbers, the smaller one first");
    }
  }
  if (samples_ < 1) refuse("--samples", "a sweep needs at least one sample, not " + std::to_string(samples_));
  if (sampler_ == Sampler::grid) side_ = side_of_grid(samples_, ranges_.size());
  if (sampler_ == Sampler::sobol) (void)point(0);
}

std::vector<double> DesignSpace::point(std::int64_t k) const {
  const std::size_t d = ranges_.size();
  std::vector<double> share(d);  // of each range
  const auto number = static_cast<std::uint64_t>(k);
  switch (sampler_) {
    case Sampler::grid:
      for (std::size_t i = d; i-- > 0; k /= side_) {
        share[i] = side_ == 1 ? 0.5 : static_cast<double>(k % side_) / static_cast<double>(side_ - 1);
      }
      break;
    case Sampler::random:
      for (std::size_t i = 0; i < d; ++i) share[i] = unit(random_bits(seed_, number, i));
      break;
    case Sampler::sobol: {
      std::vector<std::uint64_t> bits(d);
      sobol(number, bits);
      constexpr std::uint64_t kShift = ~std::uint64_t{0};  // a number that no point has
      for (std::size_t i = 0; i < d; ++i) share[i] = unit(bits[i] ^ random_bits(seed_, kShift, i));
      break;
    }
  }
  std::vector<double> values(d);
  for (std::size_t i = 0; i < d; ++i) {
    const Range& r = ranges_[i];
    values[i] = share[i] == 1 ? r.high : std::min(r.high, r.low + share[i] * (r.high - r.low));
  }
  return values;
}

}  // namespace assur::sweep
