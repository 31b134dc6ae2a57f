// Dense LU of matrices of order N side by side, in registers. For the smallest groups, a list of operations would take
// longer to read than to execute. Each lane has its own order of rows, which is chosen only occasionally, because
// comparing pivots in every factorisation would double the time. Included once for each target, inside its
// HWY_NAMESPACE (see Highway, "foreach_target.h").
#if defined(ASSUR_SMALL_LU_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_SMALL_LU_INL
#undef ASSUR_SMALL_LU_INL
#else
#define ASSUR_SMALL_LU_INL
#endif

#include <hwy/highway.h>

#include <cstddef>

#include "backends/lanes_factors.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

// P A = L U with U's unit diagonal. L: Lanes, or Value
template <class L, int N>
class SmallLu {
 public:
  SmallLu()
      : shrink_(1 / square(lanes::limits(N, Precision::binary64).growth)),
        pivot_(square(lanes::limits(N, Precision::binary64).pivot)),
        smallest_(square(lanes::limits(N, Precision::binary64).smallest)) {}

  static constexpr std::size_t kSwaps = N * (N - 1) / 2;

  // Rows k and i > k are swapped before column k where pivots(number of the pair) is positive. Tests the pivots like
  // the backend `lanes`: 0, or 1 where one exceeds the limits, or is not finite.
  template <class Pivots>
  [[nodiscard]] HWY_INLINE L factorize(const L (&matrix)[N][N], const Pivots& pivots) {
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j) f_[i][j] = matrix[i][j];
    }
    set_swaps(pivots);
    for (int k = 0; k < N; ++k) {
      for (int i = k + 1; i < N; ++i) {
        for (int j = 0; j < N; ++j) swap_if(swap_[k][i], f_[k][j], f_[i][j]);
      }
    }
    L of_a[N];
    for (int i = 0; i < N; ++i) of_a[i] = squares(f_[i]);
    const L one = L::set(1), shrink = L::set(shrink_), pivot = L::set(pivot_), smallest = L::set(smallest_);
    L largest_u = one, determinant = f_[0][0], poor = L::set(0);
    if (N == 2) {
      determinant = f_[0][0] * f_[1][1];
      determinant.subtract_product(f_[1][0], f_[0][1]);
    }
    for (int k = 0; k < N; ++k) {
      // The second of two pivots is determinant / first, so that both divisions run at the same time.
      reciprocal_[k] = N == 2 && k == 1 ? f_[0][0] / determinant : one / f_[k][k];
      const L of_pivot = f_[k][k] * f_[k][k];
      L of_l = of_pivot, of_u = L::set(0);
      for (int j = 0; j < k; ++j) of_l.add_product(f_[k][j], f_[k][j]);
      for (int j = k + 1; j < N; ++j) {
        of_u.add_product(f_[k][j], f_[k][j]);
        f_[k][j] = f_[k][j] * reciprocal_[k];
        for (int i = k + 1; i < N; ++i) f_[i][j].subtract_product(f_[i][k], f_[k][j]);
      }
      L least = smallest;
      least.add_product(of_a[k], pivot);
      poor = if_at_most((of_l + of_u) * shrink * largest_u, of_a[k], poor, one);
      poor = if_at_most(least, of_pivot, poor, one);
      if (k + 1 < N) largest_u = max(largest_u, of_u * reciprocal_[k] * reciprocal_[k]);
    }
    return poor;
  }

  // The factors, as put(number, value), for recall(). They are kFactors numbers.
  static constexpr std::size_t kFactors = N * N + N;
  template <class Put>
  HWY_INLINE void keep(const Put& put) const {
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j) put(static_cast<std::size_t>(i * N + j), f_[i][j]);
      put(static_cast<std::size_t>(N * N + i), reciprocal_[i]);
    }
  }
  template <class Get, class Pivots>
  HWY_INLINE void recall(const Get& get, const Pivots& pivots) {
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j) f_[i][j] = get(static_cast<std::size_t>(i * N + j));
      reciprocal_[i] = get(static_cast<std::size_t>(N * N + i));
    }
    set_swaps(pivots);
  }

  HWY_INLINE void solve(const L (&b)[N], L (&x)[N]) const {
    for (int i = 0; i < N; ++i) x[i] = b[i];
    for (int k = 0; k < N; ++k) {
      for (int i = k + 1; i < N; ++i) swap_if(swap_[k][i], x[k], x[i]);
    }
    for (int k = 0; k < N; ++k) {
      x[k] = x[k] * reciprocal_[k];
      for (int i = k + 1; i < N; ++i) x[i].subtract_product(f_[i][k], x[k]);
    }
    for (int k = N - 1; k > 0; --k) {
      for (int i = 0; i < k; ++i) x[i].subtract_product(f_[i][k], x[k]);
    }
  }

 private:
  template <class Pivots>
  HWY_INLINE void set_swaps(const Pivots& pivots) {
    std::size_t pair = 0;
    for (int k = 0; k < N; ++k) {
      for (int i = k + 1; i < N; ++i, ++pair) swap_[k][i] = positive(pivots(pair));
    }
  }
  static double square(double x) { return x * x; }
  static HWY_INLINE L squares(const L (&row)[N]) {
    L sum = row[0] * row[0];
    for (int j = 1; j < N; ++j) sum.add_product(row[j], row[j]);
    return sum;
  }

  double shrink_, pivot_, smallest_;  // limits, squared
  L f_[N][N];                         // L and, right of its diagonal, U
  L reciprocal_[N];                   // of the pivots
  typename L::Mask swap_[N][N];       // rows k and i > k
};

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
