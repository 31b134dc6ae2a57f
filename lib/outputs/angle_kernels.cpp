// Compiled once for each SIMD target.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "outputs/angle_kernels.cpp"
#include <hwy/foreach_target.h>  // must precede the code compiled for each target

#include "evaluation/angles-inl.hpp"
#include "evaluation/lane_vector-inl.hpp"

#include <cmath>

#include "outputs/angle_kernels.hpp"
#include "scene/law_evaluate.hpp"

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

template <std::size_t W>
bool follow_all(std::size_t count, const Arms& now, const Arms& next, double seconds, const double* bends,
                double* strays) {
  using V = Lanes<W>;
  constexpr double kFirstSteps = 16;  // bound for a path of unknown shape: four times the chord, squared
  constexpr double kMostBow = 0.25;   // of a vector, relative to its length: the inverse of a Jacobian may grow
  const V none = V::set(0), one = V::set(1), time = V::set(seconds);
  V all = none;
  for (std::size_t i = 0; i < count; i += W) {
    const V x = V::load(next.x + i), y = V::load(next.y + i);
    const V dx = x - V::load(now.x + i), dy = y - V::load(now.y + i);
    const V square = x * x + y * y, chord = dx * dx + dy * dy;
    square.store(next.square + i);
    chord.store(next.chord + i);
    const V before = V::load(now.square + i), speed = V::load(now.speed + i), at_speed = speed * time * time;
    const V way = if_positive(none - speed, V::set(kFirstSteps) * chord, if_at_most(chord, at_speed, at_speed, chord));
    const V least = if_at_most(before, square, before, square);
    V stray = if_at_most(V::load(bends + i), V::set(kMostBow * kMostBow) * least, none, one);
    if (!all_at_most(way, least)) {  // shorter than half of any way round the origin?
      const V is_long = if_at_most(V::set(2) * sqrt(way), sqrt(before) + sqrt(square), none, one);
      stray = max(stray, if_at_most(way, least, none, is_long));
    }
    stray.store(strays + i);
    all = max(all, stray);
  }
  return !(all.largest() > 0);
}

template <std::size_t W>
void turn_all(std::size_t count, const Arms& now, const Arms& next, double seconds, double* turns) {
  using V = Lanes<W>;
  const V one = V::set(1), none = V::set(0), half = V::set(0.5), square = V::set(seconds * seconds);
  for (std::size_t i = 0; i < count; i += W) {
    const V x = V::load(now.x + i), y = V::load(now.y + i), to_x = V::load(next.x + i), to_y = V::load(next.y + i);
    // The shorter way may cross the half-line where atan2 jumps: to the left if y becomes negative.
    const V crossing = copy_sign(one, y) - copy_sign(one, to_y), left = x * to_y - y * to_x;
    (V::load(turns + i) + if_positive(crossing * left, half * crossing, none)).store(turns + i);
    const V chord = V::load(next.chord + i);
    if (seconds != 0) (chord / square).store(now.speed + i);
    to_x.store(now.x + i);
    to_y.store(now.y + i);
    V::load(next.square + i).store(now.square + i);
    chord.store(now.chord + i);
  }
}

// A few vectors are taken one by one: eight numbers read at once wait for the few that were just written.
constexpr std::size_t kFewAngles = 3;

bool follow(std::size_t count, const Arms& now, const Arms& next, double seconds, const double* bends, double* strays) {
  return count <= kFewAngles ? follow_all<1>(count, now, next, seconds, bends, strays)
                             : follow_all<kAngleBlock>(count, now, next, seconds, bends, strays);
}

void turn(std::size_t count, const Arms& now, const Arms& next, double seconds, double* turns) {
  return count <= kFewAngles ? turn_all<1>(count, now, next, seconds, turns)
                             : turn_all<kAngleBlock>(count, now, next, seconds, turns);
}

constexpr AngleKernels kKernels = {sin_cos, angles, add_harmonics, follow, turn};
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
