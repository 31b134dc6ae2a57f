// Compiled once for each SIMD target.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "signals/angle_kernels.cpp"
#include <hwy/foreach_target.h>  // must precede the code compiled for each target

#include "equations/angles-inl.hpp"
#include "equations/lane_vector-inl.hpp"

#include <cmath>

#include "scene/law_evaluate.hpp"
#include "signals/angle_kernels.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {
namespace {

using L = Lanes<kAngleBlock>;

void sin_cos(const double* angles, std::size_t count, double* sines, double* cosines) {
  for (std::size_t i = 0; i < count; i += kAngleBlock) {
    const SinCos<L> at = sin_cos_of(L::load(angles + i));
    at.sine.store(sines + i);
    at.cosine.store(cosines + i);
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (std::abs(angles[i]) <= kLargestAngle) continue;
    sines[i] = std::sin(angles[i]);
    cosines[i] = std::cos(angles[i]);
  }
}

void angles(const double* y, const double* x, std::size_t count, double* angles) {
  for (std::size_t i = 0; i < count; i += kAngleBlock) {
    signed_angle_of(L::load(y + i), L::load(x + i)).store(angles + i);
  }
}

void add_harmonics(const HarmonicBlock* blocks, std::size_t count, double time, double* values, double* rates,
                   double* accelerations) {
  const L t = L::set(time), turn = L::set(law_detail::two_pi<double>());
  for (const HarmonicBlock* b = blocks; b != blocks + count; ++b) {
    double *const v = values + b->slot, *const r = rates + b->slot, *const a = accelerations + b->slot;
    L value = L::load(v), rate = L::load(r), acceleration = L::load(a);
    add_harmonic(t, turn, L::load(b->frequency), L::load(b->phase), L::load(b->amplitude), L::load(b->omega), value,
                 rate, acceleration);
    value.store(v);
    rate.store(r);
    acceleration.store(a);
  }
}

constexpr AngleKernels kKernels = {sin_cos, angles, add_harmonics};
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
