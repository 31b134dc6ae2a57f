// Fused products for processors without an instruction for them, where that of the C library takes four times as long.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace assur {

// The sum a + b = sum + left, exactly (Knuth).
struct TwoSum {
  double sum, left;

  TwoSum(double a, double b) : sum(a + b) {
    const double of_b = sum - a, of_a = sum - of_b;
    left = (a - of_a) + (b - of_b);
  }
};

inline float fused_number(float a, float b, float c) { return std::fma(a, b, c); }

// c + a b, rounded once: the product in two parts (Dekker), and all parts but the largest rounded to odd before they
// are added to it (Boldo and Melquiond, IEEE Transactions on Computers 57, 2008).
inline double fused_number(double a, double b, double c) {
  constexpr double kSplit = 0x1p27 + 1;                  // halves the 53 bits
  constexpr double kLarge = 0x1p900, kSmall = 0x1p-900;  // within these, no part overflows or underflows
  const double product = a * b, size = std::abs(product);
  if (a == 0 || b == 0) return product + c;
  const bool exact = std::abs(a) < kLarge && std::abs(b) < kLarge && std::abs(c) < kLarge && size < kLarge &&
                     size > kSmall;  // false for NaN
  if (!exact) return std::fma(a, b, c);
  const double of_a = kSplit * a, of_b = kSplit * b;
  const double a_high = of_a - (of_a - a), b_high = of_b - (of_b - b), a_low = a - a_high, b_low = b - b_high;
  const double left = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
  const TwoSum small(c, left), large(product, small.sum), odd(small.left, large.left);
  auto bits = std::bit_cast<std::int64_t>(odd.sum);
  if (odd.left != 0 && (bits & 1) == 0) bits += (odd.left > 0) == (odd.sum > 0) ? 1 : -1;
  return large.sum + std::bit_cast<double>(bits);
}

}  // namespace assur
