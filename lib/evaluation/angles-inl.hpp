// Sine and cosine, the angle of a direction, and harmonics. Included once for each target, inside its HWY_NAMESPACE
// (see Highway, "foreach_target.h").
#if defined(ASSUR_ANGLES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_ANGLES_INL
#undef ASSUR_ANGLES_INL
#else
#define ASSUR_ANGLES_INL
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

// Minimax on |s| <= 1/2, found as above: (atan(s) / s - 1) / s^2 to 2^-57 of the arctangent, in s^2.
inline constexpr double kArctangent[] = {-0x1.5555555555518p-2, 0x1.99999999914d8p-3,  -0x1.249249216fdc4p-3,
                                         0x1.c71c7096894c0p-4,  -0x1.745cf54e5f3b7p-4, 0x1.3b114544a7417p-4,
                                         -0x1.10f36752b9e4ap-4, 0x1.dfed12ffd87f6p-5,  -0x1.a3a7978967095p-5,
                                         0x1.571e4f3d95f47p-5,  -0x1.c1fbf211153e1p-6, 0x1.4c2a36319bae3p-7};
inline constexpr double kEighthTurn[] = {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55};  // pi/4 as a sum

// The angle of the direction (x, y), from -pi to pi, within 1 unit in the last place where the larger size is in
// 2^-500 ... 2^500. A zero counts as positive; NaN if both are zero.
template <class L>
HWY_INLINE L angle_of(const L& y, const L& x) {
  const L zero = L::set(0), one = L::set(1), minus = L::set(-1);
  const L up = abs(y), along = abs(x);
  const L n = if_at_most(up, along, up, along), d = if_at_most(up, along, along, up);
  // Within an eighth of a turn: atan(n / d) = atan(u / v), or pi/4 + atan(u / v).
  const L twice = n + n, taken = if_at_most(twice, d, zero, d), added = if_at_most(twice, d, zero, n);
  const L u = n - taken, v = d + added, lost = d - v + added, r = one / v;
  const L s = u * r, z = s * s;
  L rest = u;  // what rounding has left of u / v
  rest.subtract_product(s, v);
  rest.subtract_product(s, lost);
  rest = rest * r;
  L less = rest;
  less.subtract_product(rest, z);
  less.add_product(s * z, polynomial(kArctangent, z));
  // |angle| = eighths pi/4 + side (s + less)
  L eighths = if_at_most(twice, d, zero, one), side = one;
  eighths = if_at_most(up, along, eighths, L::set(2) - eighths);
  side = if_at_most(up, along, side, minus);
  eighths = if_at_most(zero, x, eighths, L::set(4) - eighths);
  side = if_at_most(zero, x, side, zero - side);
  const L whole = eighths * L::set(kEighthTurn[0]), by = side * s, sum = whole + by;
  L small = whole - sum + by;
  L of_product = zero - whole;
  of_product.add_product(eighths, L::set(kEighthTurn[0]));
  of_product.add_product(eighths, L::set(kEighthTurn[1]));
  small = small + of_product;
  small.add_product(side, less);
  const L angle = sum + small;
  return if_at_most(zero, y, angle, zero - angle);
}

// The same with the sign of y, also if it is a zero, as atan2() of the C library.
template <class L>
HWY_INLINE L signed_angle_of(const L& y, const L& x) {
  return copy_sign(angle_of(abs(y), x), y);
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
