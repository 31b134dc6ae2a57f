// What the steps of groups test (step_rules.hpp): residuals, convergence and the ball. Each lane for itself, in the
// text that writes programs as well, see SmallGroup. Included once for each target, inside its HWY_NAMESPACE (see
// Highway, "foreach_target.h").
#if defined(ASSUR_GROUP_TESTS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_GROUP_TESTS_INL
#undef ASSUR_GROUP_TESTS_INL
#else
#define ASSUR_GROUP_TESTS_INL
#endif

#include <hwy/highway.h>

#include <cstddef>

#include "program/step_rules.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

// L: Lanes, or Value
template <class L>
struct GroupTests {
  // poison: NaN if a number is not finite, else 0. The comparisons of a maximum would lose it.
  static HWY_INLINE void include(const L& number, L& largest, L& poison) {
    largest = max(abs(number), largest);
    poison = poison + (number - number);
  }
  template <class Numbers>
  static HWY_INLINE L largest_of(const Numbers& numbers) {
    L largest = L::set(0), poison = largest;
    for (const L& x : numbers) include(x, largest, poison);
    return largest + poison;
  }
  // 0 if all numbers are at most the bound, else 1, also for NaN.
  template <class Numbers>
  static HWY_INLINE L is_open(const Numbers& numbers, const L& bound) {
    L open = L::set(0);
    for (const L& x : numbers) open = if_at_most(abs(x), bound, open, L::set(1));
    return open;
  }
  // A step of 0 is within any ball.
  template <class Source>
  static HWY_INLINE L times_omega(const Source& in, const L& size) {
    return if_at_most(size, L::set(0), size, in.omega() * size);
  }
  template <class Source, int N>
  static HWY_INLINE L part_of_ball(const Source& in, const L (&by)[N]) {
    L largest = L::set(0), poison = largest;
    for (int i = 0; i < N; ++i) include(by[i], largest, poison);
    return times_omega(in, largest) + poison;
  }
  // Maximum norm.
  template <int N>
  static HWY_INLINE L norm_of(const L (&matrix)[N][N]) {
    L largest = L::set(0);
    for (int i = 0; i < N; ++i) {
      L sum = abs(matrix[i][0]);
      for (int j = 1; j < N; ++j) sum = sum + abs(matrix[i][j]);
      largest = max(sum, largest);
    }
    return largest;
  }
  // b - J x
  template <int N>
  static HWY_INLINE void rest(const L (&jacobian)[N][N], const L (&x)[N], const L (&b)[N], L (&out)[N]) {
    for (int i = 0; i < N; ++i) {
      out[i] = b[i];
      for (int j = 0; j < N; ++j) out[i].subtract_product(jacobian[i][j], x[j]);
    }
  }
  // |b - J x| / (|J| |x| + |b|) in maximum norms.
  template <int N>
  static HWY_INLINE L residual(const L (&jacobian)[N][N], const L& norm, const L (&x)[N], const L (&b)[N]) {
    const L zero = L::set(0);
    L left = zero, poison = zero, norm_x = zero, size = zero;
    L difference[N];
    rest(jacobian, x, b, difference);
    for (int i = 0; i < N; ++i) {
      include(difference[i], left, poison);
      norm_x = max(abs(x[i]), norm_x);
      size = max(abs(b[i]), size);
    }
    size.add_product(norm, norm_x);
    return (left + poison) / if_at_most(size, zero, L::set(1), size);
  }

  // 0, or 1 where a residual exceeds the bound, or is NaN.
  static HWY_INLINE L exceeds(const L& left, double bound) {
    return if_at_most(left, L::set(bound), L::set(0), L::set(1));
  }

  // What a correction achieved.
  struct Progress {
    L goes_on;  // 1: another correction is needed
    L failed;   // 0, or positive if the lane is not solved and convergence is unusual
  };
  // ratio: |Phi_i| over its scale; relative: the largest of them; before: that of the last posture. corrections: their
  // number with this one. may_vanish: see terms_may_vanish(). failed: 0, or positive if something else is unusual
  template <class Numbers>
  static HWY_INLINE Progress progress(const Numbers& ratio, const L& converged, const L& relative, const L& before,
                                      const L& corrections, bool may_vanish, L failed) {
    const L zero = L::set(0), one = L::set(1), open = is_open(ratio, converged);
    L falls = relative;  // above 0: slowly
    falls.subtract_product(before, L::set(0.25));
    const L only_rounding = if_at_most(falls, zero, zero, if_at_most(relative, L::set(kRoundingLevel), one, zero));
    if (may_vanish) {
      const L slow = if_at_most(falls, zero, failed, if_at_most(corrections, one, failed, one));
      failed = if_at_most(open, zero, failed, slow);
    }
    return {if_at_most(only_rounding, zero, open, zero), failed};
  }
  // omega |coordinates - anchor|. at(k): coordinate k of the branch test
  template <class Source, class At>
  static HWY_INLINE L ball_use(const Source& in, std::size_t coordinates, const At& at) {
    L moved = L::set(0), poison = moved;
    for (std::size_t k = 0; k < coordinates; ++k) include(at(k) - in.anchor(k), moved, poison);
    return times_omega(in, moved) + poison;
  }
  // 1 if the next step of this length may leave the ball, see ball_lasts().
  static HWY_INLINE L needs_anchor(const L& used, const L& before) {
    const L more = max(used - before, L::set(0));
    return if_at_most(used + (more + more), L::set(kBall), L::set(0), L::set(1));
  }
};

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
