// Reproducible signs for probes (Steele, Lea and Flood, OOPSLA 2014: splitmix64).
#pragma once

#include <cstdint>

namespace assur {

class RandomSign {
 public:
  explicit RandomSign(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15) {}

  // -1 or +1
  double operator()() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
    z = (z ^ z >> 27) * 0x94d049bb133111eb;
    return (z >> 63) != 0 ? -1.0 : 1.0;
  }

 private:
  std::uint64_t state_;
};

}  // namespace assur
