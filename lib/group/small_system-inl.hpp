// The equations of a small group with its numbers in registers: values, Jacobian, right-hand sides and residuals.
// Included once for each target, inside its HWY_NAMESPACE (see Highway, "foreach_target.h").
#if defined(ASSUR_SMALL_SYSTEM_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_SMALL_SYSTEM_INL
#undef ASSUR_SMALL_SYSTEM_INL
#else
#define ASSUR_SMALL_SYSTEM_INL
#endif

#include "group/small_coefficients-inl.hpp"

#include <utility>

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

// Separable equations of W groups side by side.
template <int W, int N>
class SmallSystem {
  using L = Lanes<W>;

 public:
  using Column = L[N];
  using Matrix = L[N][N];

  SmallSystem(const GroupClass& group_class, const Program& program, Separable separable)
      : c_(group_class, program, std::move(separable)) {}

  [[nodiscard]] Coefficients<W, N>& coefficients() { return c_; }

  // u_ij = a_ij x_j + b_ij, and the equations.
  HWY_INLINE void evaluate(const Column& x, Matrix& u, Column& phi) const {
    for (int i = 0; i < N; ++i) {
      phi[i] = c_.g(i);
      for (int j = 0; j < N; ++j) {
        u[i][j] = c_.b(i, j);
        u[i][j].add_product(c_.a(i, j), x[j]);
        phi[i].add_product(c_.s(i, j) * u[i][j], u[i][j]);
        phi[i].add_product(c_.l(i, j), x[j]);
      }
    }
  }
  HWY_INLINE void differentiate(const Matrix& u, Matrix& jacobian) const {
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j) {
        jacobian[i][j] = c_.l(i, j);
        jacobian[i][j].add_product(twice_s(i, j) * c_.a(i, j), u[i][j]);
      }
    }
  }
  // sum_j |dPhi_i/dq_j| |q_j| + |constant|, over unknowns and inputs.
  HWY_INLINE L scale_of(int i, const Column& x, const Matrix& u) const {
    L total = c_.g_magnitude(i);
    for (int j = 0; j < N; ++j) {
      L size = c_.b_magnitude(i, j);
      size.add_product(abs(c_.a(i, j)), abs(x[j]));
      total.add_product(abs(twice_s(i, j) * u[i][j]), size);
      total.add_product(c_.l_magnitude(i, j), abs(x[j]));
    }
    return total;
  }

  // -Phi_h h' for the rates that Coefficients::set_rates() read
  HWY_INLINE void velocity_rhs(const Column& x, const Matrix& u, Column& rhs) {
    for (int i = 0; i < N; ++i) {
      rhs[i] = L::set(0);
      for (int j = 0; j < N; ++j) rhs[i].subtract_product(twice_s(i, j) * u[i][j], c_.b_rate(i, j));
    }
    c_.subtract_rates(x, rhs);
  }
  // -(Phi_h h'' + Phi'_q q'); the same for Coefficients::set_accelerations()
  HWY_INLINE void acceleration_rhs(const Column& x, const Matrix& u, const Column& rate, Column& rhs) {
    for (int i = 0; i < N; ++i) {
      rhs[i] = L::set(0);
      for (int j = 0; j < N; ++j) {
        L u_rate = c_.b_rate(i, j);
        u_rate.add_product(c_.a(i, j), rate[j]);
        L half = u_rate * u_rate;
        half.add_product(u[i][j], c_.b_acceleration(i, j));
        rhs[i].subtract_product(twice_s(i, j), half);
      }
    }
    c_.subtract_accelerations(x, rate, rhs);
  }

  // True if |phi| <= bound * scale everywhere. Needs no division; false for NaN.
  static HWY_INLINE bool at_most(const Column& phi, const Column& scale, double bound) {
    bool all = true;
    for (int i = 0; i < N; ++i) all = all_at_most(abs(phi[i]), L::set(bound) * scale[i]) && all;
    return all;
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
    if (HWY_LIKELY(all_at_most(norm_r, L::set(worst) * norm_b))) return worst;
    return (norm_r / norm_b).largest();
  }

  static HWY_INLINE void load(const double* from, Column& to) {
    for (int i = 0; i < N; ++i) to[i] = L::load(from + i * W);
  }
  static HWY_INLINE void store(const Column& from, double* to) {
    for (int i = 0; i < N; ++i) from[i].store(to + i * W);
  }

 private:
  HWY_INLINE L twice_s(int i, int j) const {
    const L s = c_.s(i, j);
    return s + s;
  }

  Coefficients<W, N> c_;
};

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
