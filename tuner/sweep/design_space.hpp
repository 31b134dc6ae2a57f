// Points of a design space. Point k is a function of the seed and of k alone, so that any range of points can be made
// anywhere, in any order.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace assur::sweep {

// A parameter and its range.
struct Range {
  std::string name;
  double low = 0, high = 0;
};

enum class Sampler : std::uint8_t {
  grid,    // N^(1/d) values of each of d parameters, both ends included; the last parameter changes fastest
  random,  // independent and uniform
  sobol,   // the sequence of Sobol, shifted by the seed: fills the space evenly
};

class DesignSpace {
 public:
  // Throws Error: input for no range, low > high or numbers that are not finite, fewer than one sample, or a grid whose
  // number of samples is not the d-th power of a whole number; environment for `sobol` in a build without Boost.
  DesignSpace(std::vector<Range> ranges, Sampler sampler, std::int64_t samples, std::uint64_t seed);

  [[nodiscard]] const std::vector<Range>& ranges() const { return ranges_; }
  [[nodiscard]] std::int64_t samples() const { return samples_; }
  // The value of each parameter at point k, 0 to samples() - 1.
  [[nodiscard]] std::vector<double> point(std::int64_t k) const;

 private:
  std::vector<Range> ranges_;
  Sampler sampler_;
  std::int64_t samples_, side_ = 1;  // side: values of one parameter of a grid
  std::uint64_t seed_;
};

// Point k of the sequence of Sobol in [0, 2^64) for each dimension. Throws Error (environment) in a build without
// Boost.
void sobol(std::uint64_t k, std::span<std::uint64_t> point);

}  // namespace assur::sweep
