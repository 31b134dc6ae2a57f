// Random numbers that are equal everywhere: mt19937_64 is, the distributions of the standard library are not.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "mechanisms/spatial.hpp"

namespace assur::mechanisms {

class Draw {
 public:
  // Draws from one seed make the same choices; their numbers differ by shares of their ranges up to `jitter`.
  explicit Draw(std::uint64_t seed, double jitter = 0, std::uint64_t jitter_seed = 0)
      : engine_(seed), jitter_(jitter), other_(jitter_seed) {}
  double real(double from, double to) {
    const double share = fraction(engine_) + (jitter_ == 0 ? 0 : jitter_ * (2 * fraction(other_) - 1));
    return from + (to - from) * std::clamp(share, 0.0, 1.0);
  }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(engine_() % n); }
  bool one_in(std::size_t n) { return below(n) == 0; }
  bool maybe() { return one_in(2); }
  double sign() { return maybe() ? 1 : -1; }
  template <class T>
  const T& of(const std::vector<T>& from) {
    return from[below(from.size())];
  }
  // A direction in space, or in the plane.
  Spatial<double> direction(int dimension = 3) {
    for (;;) {
      const double x = real(-1, 1), y = real(-1, 1), z = dimension == 3 ? real(-1, 1) : 0;
      const Spatial<double> v{x, y, z};
      if (const double n = std::sqrt(dot(v, v)); n > 0.1 && n < 1) return unit(v);
    }
  }

 private:
  static double fraction(std::mt19937_64& engine) { return static_cast<double>(engine() >> 11) * 0x1p-53; }

  std::mt19937_64 engine_;
  double jitter_;
  std::mt19937_64 other_;
};

}  // namespace assur::mechanisms
