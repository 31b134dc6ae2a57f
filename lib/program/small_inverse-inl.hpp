// Inverses of matrices of order 2 and 3 side by side, by cofactors: with one division instead of one after the other,
// and without an order of rows for each lane, as elimination would need. Included once for each target, inside its
// HWY_NAMESPACE (see Highway, "foreach_target.h").
#if defined(ASSUR_SMALL_INVERSE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_SMALL_INVERSE_INL
#undef ASSUR_SMALL_INVERSE_INL
#else
#define ASSUR_SMALL_INVERSE_INL
#endif

#include <hwy/highway.h>

#include <cstddef>

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

// L: Lanes, or Value
template <class L, int N>
class SmallInverse {
  static_assert(N == 2 || N == 3);

 public:
  // 0, or 1 where the matrix is too close to a singular one: the volume of its rows, relative to their lengths, is
  // |det A| / prod |a_i|, and rounding changes the inverse, relative to it, by some 8 eps over that. Also for NaN.
  [[nodiscard]] HWY_INLINE L invert(const L (&a)[N][N]) {
    L volume = squares(a[0]);  // squared
    for (int i = 1; i < N; ++i) volume = volume * squares(a[i]);
    L determinant;
    if constexpr (N == 2) {
      // Kahan's difference of products, exact but for the last bits.
      const L product = a[1][0] * a[0][1];
      L rounded_by = product, rest = product;
      rounded_by.subtract_product(a[1][0], a[0][1]);
      rest.subtract_product(a[0][0], a[1][1]);
      determinant = rounded_by - rest;
      column_[0][0] = a[1][1];
      column_[0][1] = L::set(0) - a[1][0];
      column_[1][0] = L::set(0) - a[0][1];
      column_[1][1] = a[0][0];
    } else {
      for (int i = 0; i < N; ++i) {
        const L(&b)[N] = a[(i + 1) % N], (&c)[N] = a[(i + 2) % N];
        for (int j = 0; j < N; ++j) {
          const int k = (j + 1) % N, l = (j + 2) % N;
          column_[i][j] = b[k] * c[l];
          column_[i][j].subtract_product(b[l], c[k]);
        }
      }
      determinant = a[0][0] * column_[0][0];
      determinant.add_product(a[0][1], column_[0][1]);
      determinant.add_product(a[0][2], column_[0][2]);
    }
    reciprocal_ = L::set(1) / determinant;
    return if_at_most(L::set(kSmallest * kSmallest) * volume, determinant * determinant, L::set(0), L::set(1));
  }

  // Calls each(number) for the numbers of the inverse, which can be kept and put back.
  template <class Each>
  void each_number(const Each& each) {
    for (auto& of_column : column_) {
      for (L& number : of_column) each(number);
    }
    each(reciprocal_);
  }

  // x = A^-1 b
  HWY_INLINE void solve(const L (&b)[N], L (&x)[N]) const {
    sum(b, x);
    for (int j = 0; j < N; ++j) x[j] = x[j] * reciprocal_;
  }
  // x += A^-1 b
  HWY_INLINE void add_solution(const L (&b)[N], L (&x)[N]) const {
    L all[N];
    sum(b, all);
    for (int j = 0; j < N; ++j) x[j].add_product(all[j], reciprocal_);
  }
  HWY_INLINE L entry(int row, int column) const { return column_[column][row] * reciprocal_; }

 private:
  static constexpr double kSmallest = 0x1p-30;  // relative volume

  HWY_INLINE void sum(const L (&b)[N], L (&x)[N]) const {
    for (int j = 0; j < N; ++j) {
      x[j] = column_[0][j] * b[0];
      for (int i = 1; i < N; ++i) x[j].add_product(column_[i][j], b[i]);
    }
  }
  static HWY_INLINE L squares(const L (&row)[N]) {
    L sum = row[0] * row[0];
    for (int j = 1; j < N; ++j) sum.add_product(row[j], row[j]);
    return sum;
  }

  L column_[N][N];  // of the adjugate
  L reciprocal_;    // of the determinant
};

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
