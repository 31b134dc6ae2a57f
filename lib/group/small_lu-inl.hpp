// Dense LU of W matrices of order N side by side, in registers. For the smallest groups, a list of operations would
// take longer to read than to execute. Each lane has its own order of rows, which is chosen only occasionally, because
// comparing pivots in every factorisation would double the time. Included once for each target, inside its
// HWY_NAMESPACE (see Highway, "foreach_target.h").
#if defined(ASSUR_SMALL_LU_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_SMALL_LU_INL
#undef ASSUR_SMALL_LU_INL
#else
#define ASSUR_SMALL_LU_INL
#endif

#include "backends/lanes_factors.hpp"
#include "equations/lane_vector-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

// P A = L U with U's unit diagonal.
template <int W, int N>
class SmallLu {
  using L = Lanes<W>;

 public:
  SmallLu()
      : least_shrink_(1 / square(lanes::limits(N, Precision::binary64).growth)),
        least_pivot_(square(lanes::limits(N, Precision::binary64).pivot)),
        smallest_(square(lanes::limits(N, Precision::binary64).smallest)) {}

  static constexpr int kSwaps = N * (N - 1) / 2;

  // Rows k and i > k are swapped before column k where swaps[...] > 0 (kSwaps x W). Each pivot is then the largest
  // entry of its column, relative to its row.
  static void choose_swaps(const L (&matrix)[N][N], double* swaps) {
    L f[N][N], of_a[N];
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j) f[i][j] = matrix[i][j];
      of_a[i] = squares(f[i]);
    }
    for (int k = 0; k < N; ++k) {
      for (int i = k + 1; i < N; ++i, swaps += W) {
        (f[i][k] * f[i][k] * of_a[k] - f[k][k] * f[k][k] * of_a[i]).store(swaps);
        const auto swap = less(L::set(0), L::load(swaps));
        for (int j = 0; j < N; ++j) swap_if(swap, f[k][j], f[i][j]);
        swap_if(swap, of_a[k], of_a[i]);
      }
      for (int i = k + 1; i < N; ++i) {
        const L factor = f[i][k] / f[k][k];
        for (int j = k + 1; j < N; ++j) f[i][j].subtract_product(factor, f[k][j]);
      }
    }
  }

  // Tests the pivots like the backend `lanes`: false if a lane exceeds the limits, or is not finite.
  [[nodiscard]] HWY_INLINE bool factorize(const L (&matrix)[N][N], const double* swaps) {
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j) f_[i][j] = matrix[i][j];
    }
    for (int k = 0; k < N; ++k) {
      for (int i = k + 1; i < N; ++i, swaps += W) {
        swap_[k][i] = less(L::set(0), L::load(swaps));
        for (int j = 0; j < N; ++j) swap_if(swap_[k][i], f_[k][j], f_[i][j]);
      }
    }
    L of_a[N];
    for (int i = 0; i < N; ++i) of_a[i] = squares(f_[i]);
    const L shrink = L::set(least_shrink_), pivot = L::set(least_pivot_), smallest = L::set(smallest_);
    L largest_u = L::set(1), determinant = f_[0][0];
    if (N == 2) {
      determinant = f_[0][0] * f_[1][1];
      determinant.subtract_product(f_[1][0], f_[0][1]);
    }
    typename L::Mask good = less(L::set(0), L::set(1));
    for (int k = 0; k < N; ++k) {
      // The second of two pivots is determinant / first, so that both divisions run at the same time.
      reciprocal_[k] = N == 2 && k == 1 ? f_[0][0] / determinant : L::set(1) / f_[k][k];
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
      good = good & less((of_l + of_u) * shrink * largest_u, of_a[k]) & less(least, of_pivot);
      largest_u = max(largest_u, of_u * reciprocal_[k] * reciprocal_[k]);
    }
    return good.all();
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
  static double square(double x) { return x * x; }
  static HWY_INLINE L squares(const L (&row)[N]) {
    L sum = row[0] * row[0];
    for (int j = 1; j < N; ++j) sum.add_product(row[j], row[j]);
    return sum;
  }

  double least_shrink_, least_pivot_, smallest_;  // limits, squared
  L f_[N][N];                                     // L and, right of its diagonal, U
  L reciprocal_[N];                               // of the pivots
  typename L::Mask swap_[N][N];                   // rows k and i > k
};

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
