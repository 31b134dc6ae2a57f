// The equations of a small group with its numbers in registers: values, Jacobian and right-hand sides. Included once
// for each target, inside its HWY_NAMESPACE (see Highway, "foreach_target.h").
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
class SmallSystem : public Coefficients<W, N> {
  using L = Lanes<W>;

 public:
  using typename SmallAlgebra<W, N>::Column;
  using typename SmallAlgebra<W, N>::Matrix;
  static constexpr bool kDistances = false;

  SmallSystem(const GroupClass& group_class, const Program& program, Separable separable)
      : Coefficients<W, N>(group_class, program, std::move(separable)) {}

  // u_ij = a_ij x_j + b_ij, and the equations.
  HWY_INLINE void evaluate(const Column& x, Matrix& u, Column& phi) const {
    for (int i = 0; i < N; ++i) {
      phi[i] = this->g(i);
      for (int j = 0; j < N; ++j) {
        u[i][j] = this->b(i, j);
        u[i][j].add_product(this->a(i, j), x[j]);
        phi[i].add_product(this->s(i, j) * u[i][j], u[i][j]);
        phi[i].add_product(this->l(i, j), x[j]);
      }
    }
  }
  HWY_INLINE void differentiate(const Matrix& u, Matrix& jacobian) const {
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j) {
        jacobian[i][j] = this->l(i, j);
        jacobian[i][j].add_product(twice_s(i, j) * this->a(i, j), u[i][j]);
      }
    }
  }
  // sum_j |dPhi_i/dq_j| |q_j| + |constant|, over unknowns and inputs.
  HWY_INLINE L scale_of(int i, const Column& x, const Matrix& u) const {
    L total = this->g_magnitude(i);
    for (int j = 0; j < N; ++j) {
      L size = this->b_magnitude(i, j);
      size.add_product(abs(this->a(i, j)), abs(x[j]));
      total.add_product(abs(twice_s(i, j) * u[i][j]), size);
      total.add_product(this->l_magnitude(i, j), abs(x[j]));
    }
    return total;
  }

  // -Phi_h h' for the rates that Coefficients::set_rates() read
  HWY_INLINE void velocity_rhs(const Column& x, const Matrix& u, Column& rhs) {
    for (int i = 0; i < N; ++i) {
      rhs[i] = L::set(0);
      for (int j = 0; j < N; ++j) rhs[i].subtract_product(twice_s(i, j) * u[i][j], this->b_rate(i, j));
    }
    this->subtract_rates(x, rhs);
  }
  // -(Phi_h h'' + Phi'_q q'); the same for Coefficients::set_accelerations()
  HWY_INLINE void acceleration_rhs(const Column& x, const Matrix& u, const Column& rate, Column& rhs) {
    for (int i = 0; i < N; ++i) {
      rhs[i] = L::set(0);
      for (int j = 0; j < N; ++j) {
        L u_rate = this->b_rate(i, j);
        u_rate.add_product(this->a(i, j), rate[j]);
        L half = u_rate * u_rate;
        half.add_product(u[i][j], this->b_acceleration(i, j));
        rhs[i].subtract_product(twice_s(i, j), half);
      }
    }
    this->subtract_accelerations(x, rate, rhs);
  }

 private:
  HWY_INLINE L twice_s(int i, int j) const {
    const L s = this->s(i, j);
    return s + s;
  }
};

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
