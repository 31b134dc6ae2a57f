// The limit of a smooth function at 0, from samples on both sides.
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace assur {

// Places of the samples on each side, as parts of a reach.
inline constexpr std::array kLimitPlaces = {0.125, 0.25, 0.375, 0.5, 0.75, 1.0};

// Weights of values and rates that give the value and the first three derivatives.
class TwoSidedLimit {
 public:
  static constexpr std::size_t kSamples = 2 * kLimitPlaces.size();  // at -reach * places, then at reach * places

  // reach: s, negative if the motion runs backwards.
  explicit TwoSidedLimit(double reach);

  struct Limit {
    std::array<double, 4> value{};  // and derivatives
    std::array<double, 3> error{};  // estimate: difference to the limit from samples at half the distance
    std::array<double, 3> gap{};    // difference of the limits by the samples of each side alone
  };
  // values, rates: of the samples
  [[nodiscard]] Limit of(std::span<const double, kSamples> values, std::span<const double, kSamples> rates) const;

 private:
  // Of the Hermite polynomial through some of the samples: [derivative][sample]
  struct Weights {
    std::array<std::array<double, kSamples>, 4> of_value{}, of_rate{};
  };
  template <class Take>
  [[nodiscard]] static Weights weights(double reach, const Take& take);
  [[nodiscard]] static std::array<double, 4> apply(const Weights& weights, std::span<const double, kSamples> values,
                                                   std::span<const double, kSamples> rates);

  Weights far_, near_, before_, behind_;
};

}  // namespace assur
