// Compiled once for each SIMD target.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "signals/angle_kernels.cpp"
#include <hwy/foreach_target.h>  // must precede the code compiled for each target
#include <hwy/highway.h>

#include <cmath>

#include "scene/law_evaluate.hpp"
#include "signals/angle_kernels.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {
namespace {

#if HWY_NATIVE_FMA

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<double, kAngleBlock>;
using V = hn::Vec<D>;

struct SinCos {
  V sine, cosine;
};

// sum of c[k] z^k
template <std::size_t N>
HWY_INLINE V polynomial(const double (&c)[N], V z) {
  V sum = hn::Set(D(), c[N - 1]);
  for (std::size_t k = N - 1; k-- > 0;) sum = hn::MulAdd(sum, z, hn::Set(D(), c[k]));
  return sum;
}

// Minimax on |r| <= pi/4 by Remez' algorithm, each coefficient rounded before the next ones were fitted:
// (sin(r) / r - 1) / r^2 to 2^-58 of the sine, (cos(r) - 1 + r^2 / 2) / r^4 to 2^-64 of the cosine, in r^2.
constexpr double kSine[] = {-0x1.5555555555549p-3, 0x1.111111110f8a4p-7,   -0x1.a01a019c15b3cp-13,
                            0x1.71de357aac557p-19, -0x1.ae5e6839c9e81p-26, 0x1.5d9383d67cc85p-33};
constexpr double kCosine[] = {0x1.555555555554cp-5,   -0x1.6c16c16c1521dp-10, 0x1.a01a019cbf0d4p-16,
                              -0x1.27e4f81265302p-22, 0x1.1ee9f110868ffp-29,  -0x1.8fb10a0e6504dp-37};
// pi/2 as a sum of three doubles. The reduction subtracts an odd multiple of the first one exactly.
constexpr double kHalfPi[] = {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54, -0x1.f1976b7ed8fbcp-110};

// |angle| <= kLargestAngle
HWY_INLINE SinCos sin_cos_of(V angle) {
  const D d;
  const hn::RebindToUnsigned<D> du;
  // Adding 1.5 * 2^52 rounds a number to an integer; the last bits of the sum are the quadrant.
  const V shift = hn::Set(d, 0x1.8p52);
  const V shifted = hn::MulAdd(angle, hn::Set(d, 0x1.45f306dc9c883p-1), shift), n = hn::Sub(shifted, shift);
  const V first = hn::NegMulAdd(n, hn::Set(d, kHalfPi[0]), angle);
  const V second = hn::Mul(n, hn::Set(d, kHalfPi[1])), of_product = hn::MulSub(n, hn::Set(d, kHalfPi[1]), second);
  const V r = hn::Sub(first, second), lost = hn::Sub(hn::Sub(first, r), second);
  const V rest = hn::NegMulAdd(n, hn::Set(d, kHalfPi[2]), hn::Sub(lost, of_product));  // angle = n pi/2 + r + rest

  const V one = hn::Set(d, 1), z = hn::Mul(r, r), half = hn::Mul(z, hn::Set(d, 0.5));
  const V of_rest = hn::NegMulAdd(half, rest, rest);
  const V sine = hn::Add(r, hn::MulAdd(hn::Mul(r, z), polynomial(kSine, z), of_rest));
  const V whole = hn::Sub(one, half);
  const V fourth = hn::NegMulAdd(r, rest, hn::Mul(hn::Mul(z, z), polynomial(kCosine, z)));
  const V cosine = hn::Add(whole, hn::Add(hn::Sub(hn::Sub(one, whole), half), fourth));

  const auto quadrant = hn::BitCast(du, shifted), unit = hn::Set(du, 1);
  const auto swapped = hn::MaskFromVec(hn::BitCast(d, hn::Sub(hn::Zero(du), hn::And(quadrant, unit))));
  const auto sign = [&](auto q) { return hn::And(hn::BitCast(d, hn::ShiftLeft<62>(q)), hn::SignBit(d)); };
  return {hn::Xor(hn::IfThenElse(swapped, cosine, sine), sign(quadrant)),
          hn::Xor(hn::IfThenElse(swapped, sine, cosine), sign(hn::Add(quadrant, unit)))};
}

void sin_cos(const double* angles, std::size_t count, double* sines, double* cosines) {
  const D d;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const SinCos at = sin_cos_of(hn::LoadU(d, angles + i));
    hn::StoreU(at.sine, d, sines + i);
    hn::StoreU(at.cosine, d, cosines + i);
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (std::abs(angles[i]) <= kLargestAngle) continue;
    sines[i] = std::sin(angles[i]);
    cosines[i] = std::cos(angles[i]);
  }
}

// Fractional part of the cycles, like law_detail::cycles.
HWY_INLINE V cycles(V frequency, V t) {
  const V product = hn::Mul(frequency, t), lost = hn::MulSub(frequency, t, product);
  return hn::Add(hn::Sub(product, hn::Round(product)), hn::Sub(lost, hn::Round(lost)));
}

void add_harmonics(const HarmonicBlock* blocks, std::size_t count, double time, double* values, double* rates,
                   double* accelerations) {
  const D d;
  const V t = hn::Set(d, time), turn = hn::Set(d, law_detail::two_pi<double>());
  for (const HarmonicBlock* b = blocks; b != blocks + count; ++b) {
    for (std::size_t i = 0; i < kAngleBlock; i += hn::Lanes(d)) {
      const V angle = hn::MulAdd(turn, cycles(hn::LoadU(d, b->frequency + i), t), hn::LoadU(d, b->phase + i));
      const SinCos at = sin_cos_of(angle);
      const V amplitude = hn::LoadU(d, b->amplitude + i), omega = hn::LoadU(d, b->omega + i);
      const V s = hn::Mul(amplitude, at.sine), c = hn::Mul(amplitude, at.cosine);
      const std::size_t k = static_cast<std::size_t>(b->slot) + i;
      hn::StoreU(hn::Add(hn::LoadU(d, values + k), s), d, values + k);
      hn::StoreU(hn::MulAdd(omega, c, hn::LoadU(d, rates + k)), d, rates + k);
      hn::StoreU(hn::NegMulAdd(hn::Mul(omega, omega), s, hn::LoadU(d, accelerations + k)), d, accelerations + k);
    }
  }
}

#else  // without FMA: the reduction needs products that are not rounded

void sin_cos(const double* angles, std::size_t count, double* sines, double* cosines) {
  for (std::size_t i = 0; i < count; ++i) {
    sines[i] = std::sin(angles[i]);
    cosines[i] = std::cos(angles[i]);
  }
}

void add_harmonics(const HarmonicBlock* blocks, std::size_t count, double t, double* values, double* rates,
                   double* accelerations) {
  for (const HarmonicBlock* b = blocks; b != blocks + count; ++b) {
    for (std::size_t i = 0; i < kAngleBlock; ++i) {
      if (b->amplitude[i] == 0) continue;
      const double angle = law_detail::two_pi<double>() * law_detail::cycles(b->frequency[i], t) + b->phase[i];
      const double s = b->amplitude[i] * std::sin(angle), c = b->amplitude[i] * std::cos(angle);
      const std::size_t k = static_cast<std::size_t>(b->slot) + i;
      values[k] += s;
      rates[k] += b->omega[i] * c;
      accelerations[k] -= b->omega[i] * b->omega[i] * s;
    }
  }
}

#endif

constexpr AngleKernels kKernels = {sin_cos, add_harmonics};
const AngleKernels* kernels() { return &kKernels; }

}  // namespace
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace assur {

HWY_EXPORT(kernels);

const AngleKernels& angle_kernels() { return *HWY_DYNAMIC_DISPATCH(kernels)(); }

}  // namespace assur
#endif
