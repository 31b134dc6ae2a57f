// Columns and matrices of a small group, with their numbers in registers. Included once for each target, inside its
// HWY_NAMESPACE (see Highway, "foreach_target.h").
#if defined(ASSUR_SMALL_ALGEBRA_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_SMALL_ALGEBRA_INL
#undef ASSUR_SMALL_ALGEBRA_INL
#else
#define ASSUR_SMALL_ALGEBRA_INL
#endif

#include "equations/lane_vector-inl.hpp"

#include <cstdint>
#include <span>

#include "group/pack.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

// N numbers, or N x N, of W groups side by side.
template <int W, int N>
class SmallAlgebra {
  using L = Lanes<W>;

 public:
  using Column = L[N];
  using Matrix = L[N][N];

  // True if |phi| <= bound * scale everywhere. Needs no division; false for NaN.
  static HWY_INLINE bool at_most(const Column& phi, const Column& scale, double bound) {
    const L limit = L::set(bound);
    typename L::Mask all = less_equal(abs(phi[0]), limit * scale[0]);
    for (int i = 1; i < N; ++i) all = all & less_equal(abs(phi[i]), limit * scale[i]);
    return all.all();
  }
  static HWY_INLINE double largest_ratio(const Column& phi, const Column& scale) {
    L largest = L::set(0), poison = L::set(0);
    for (int i = 0; i < N; ++i) {
      const L ratio = phi[i] / scale[i];
      largest = max(largest, abs(ratio));
      poison.add_product(ratio, L::set(0));
    }
    return (largest + poison).largest();
  }

  // Maximum norm.
  static HWY_INLINE L norm_of(const Matrix& matrix) {
    L largest = L::set(0);
    for (int i = 0; i < N; ++i) {
      L sum = abs(matrix[i][0]);
      for (int j = 1; j < N; ++j) sum = sum + abs(matrix[i][j]);
      largest = max(largest, sum);
    }
    return largest;
  }

  // The larger of `worst` and |b - J x| / (|J| |x| + |b|) of all lanes, in maximum norms.
  static HWY_INLINE double residual(const Matrix& jacobian, const L& norm, const Column& x, const Column& b,
                                    double worst) {
    L norm_r = L::set(0), norm_x = L::set(0), norm_b = L::set(0), poison = L::set(0);
    for (int i = 0; i < N; ++i) {
      L rest = b[i];
      for (int j = 0; j < N; ++j) rest.subtract_product(jacobian[i][j], x[j]);
      norm_r = max(norm_r, abs(rest));
      norm_x = max(norm_x, abs(x[i]));
      norm_b = max(norm_b, abs(b[i]));
      poison.add_product(rest, L::set(0));
    }
    norm_b.add_product(norm, norm_x);
    norm_r = norm_r + poison;
    norm_b = if_positive(norm_b, norm_b, L::set(1));
    if (HWY_LIKELY(less_equal(norm_r, L::set(worst) * norm_b).all())) return worst;
    return (norm_r / norm_b).largest();
  }

  // omega * largest |coordinate - anchor|: see PackKernels. input(i): an input of the pack
  template <class Input>
  static HWY_INLINE L ball_use(const Pack& pack, std::span<const std::int32_t> coordinates, const Column& x,
                               const Input& input) {
    L moved = L::set(0), poison = L::set(0);
    const double* anchor = pack.anchor.data();
    for (const std::int32_t c : coordinates) {
      const L by = (c < N ? x[c] : input(c - N)) - L::load(anchor);
      moved = max(moved, abs(by));
      poison.add_product(by, L::set(0));
      anchor += W;
    }
    return if_positive(moved, moved * L::load(pack.omega.data()), moved) + poison;
  }
};

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
