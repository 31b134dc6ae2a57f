// Sine and cosine, and harmonics. Included once for each target, inside its HWY_NAMESPACE (see Highway,
// "foreach_target.h").
#if defined(ASSUR_SINE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_SINE_INL
#undef ASSUR_SINE_INL
#else
#define ASSUR_SINE_INL
#endif

#include <hwy/highway.h>

#include <cstddef>

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

// L: Lanes with fused products, or Value.
template <class L>
struct SinCos {
  L sine, cosine;
};

// sum of c[k] z^k
template <class L, std::size_t N>
HWY_INLINE L polynomial(const double (&c)[N], const L& z) {
  L sum = L::set(c[N - 1]);
  for (std::size_t k = N - 1; k-- > 0;) {
    L next = L::set(c[k]);
    next.add_product(sum, z);
    sum = next;
  }
  return sum;
}

// Minimax on |r| <= pi/4 by Remez' algorithm, each coefficient rounded before the next ones were fitted:
// (sin(r) / r - 1) / r^2 to 2^-58 of the sine, (cos(r) - 1 + r^2 / 2) / r^4 to 2^-64 of the cosine, in r^2.
inline constexpr double kSine[] = {-0x1.5555555555549p-3, 0x1.111111110f8a4p-7,   -0x1.a01a019c15b3cp-13,
                                   0x1.71de357aac557p-19, -0x1.ae5e6839c9e81p-26, 0x1.5d9383d67cc85p-33};
inline constexpr double kCosine[] = {0x1.555555555554cp-5,   -0x1.6c16c16c1521dp-10, 0x1.a01a019cbf0d4p-16,
                                     -0x1.27e4f81265302p-22, 0x1.1ee9f110868ffp-29,  -0x1.8fb10a0e6504dp-37};
// pi/2 as a sum of three doubles. The reduction subtracts an odd multiple of the first one exactly.
inline constexpr double kHalfPi[] = {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54, -0x1.f1976b7ed8fbcp-110};

// Within 1 unit in the last place, 2 if the result is below 2^-30. |angle| <= kLargestAngle
template <class L>
HWY_INLINE SinCos<L> sin_cos_of(const L& angle) {
  const L one = L::set(1);
  // Adding 1.5 * 2^52 rounds a number to an integer.
  const L shift = L::set(0x1.8p52);
  L shifted = shift;
  shifted.add_product(angle, L::set(0x1.45f306dc9c883p-1));
  const L n = shifted - shift;
  L first = angle;
  first.subtract_product(n, L::set(kHalfPi[0]));
  const L second = n * L::set(kHalfPi[1]);
  L of_product = second;
  of_product.subtract_product(n, L::set(kHalfPi[1]));  // what rounding added to the product
  const L r = first - second, lost = first - r - second;
  L rest = lost + of_product;
  rest.subtract_product(n, L::set(kHalfPi[2]));  // angle = n pi/2 + r + rest

  const L z = r * r, half = z * L::set(0.5);
  L less = rest;
  less.subtract_product(half, rest);
  less.add_product(r * z, polynomial(kSine, z));
  const L sine = r + less, whole = one - half;
  L fourth = z * z * polynomial(kCosine, z);
  fourth.subtract_product(r, rest);
  const L cosine = whole + (one - whole - half + fourth);

  L quadrant = n;  // -2 to 2; -2 is 2
  quadrant.subtract_product(L::set(4), round(n * L::set(0.25)));
  const L is_even = abs(abs(quadrant) - one), middle = L::set(0.5), minus = L::set(-1);
  return {if_at_most(is_even, middle, cosine, sine) * if_at_most(abs(quadrant - middle), one, one, minus),
          if_at_most(is_even, middle, sine, cosine) * if_at_most(abs(quadrant + middle), one, one, minus)};
}

// The fractional part of frequency * t, like law_detail::cycles.
template <class L>
HWY_INLINE L cycles(const L& frequency, const L& t) {
  const L product = frequency * t;
  L added = product;  // by rounding
  added.subtract_product(frequency, t);
  return product - round(product) - (added - round(added));
}

// Adds amplitude sin(2 pi frequency t + phase). turn: 2 pi, omega: 2 pi frequency
template <class L>
HWY_INLINE void add_harmonic(const L& t, const L& turn, const L& frequency, const L& phase, const L& amplitude,
                             const L& omega, L& value, L& rate, L& acceleration) {
  L angle = phase;
  angle.add_product(turn, cycles(frequency, t));
  const SinCos<L> at = sin_cos_of(angle);
  const L s = amplitude * at.sine, c = amplitude * at.cosine;
  value = value + s;
  rate.add_product(omega, c);
  acceleration.subtract_product(omega * omega, s);
}

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
