// Random numbers that are a function of a counter and a key.
#pragma once

#include <array>
#include <cstdint>

namespace assur::sweep {

[[nodiscard]] constexpr std::uint32_t low_half(std::uint64_t x) { return static_cast<std::uint32_t>(x); }
[[nodiscard]] constexpr std::uint32_t high_half(std::uint64_t x) { return static_cast<std::uint32_t>(x >> 32); }

// The generator Philox 4x32-10 (Salmon, Moraes, Dror and Shaw, Parallel random numbers: as easy as 1, 2, 3, 2011): the
// block of random bits with this number.
[[nodiscard]] constexpr std::array<std::uint32_t, 4> philox(std::array<std::uint32_t, 4> c,
                                                            std::array<std::uint32_t, 2> key) {
  constexpr int kRounds = 10;
  for (int round = 0; round < kRounds; ++round) {
    const std::uint64_t a = std::uint64_t{0xD2511F53} * c[0], b = std::uint64_t{0xCD9E8D57} * c[2];
    c = {high_half(b) ^ c[1] ^ key[0], low_half(b), high_half(a) ^ c[3] ^ key[1], low_half(a)};
    key = {key[0] + 0x9E3779B9U, key[1] + 0xBB67AE85U};
  }
  return c;
}

}  // namespace assur::sweep
