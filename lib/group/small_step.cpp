// Compiled once for each SIMD target; make_small_step() chooses the target.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "group/small_step.cpp"
#include <hwy/foreach_target.h>  // must precede the code compiled for each target

#include "group/small_step.hpp"

#include "group/small_coefficients-inl.hpp"
#include "group/small_lu-inl.hpp"

#include <cmath>
#include <utility>

#include "equations/separable.hpp"
#include "group/step_rules.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {
namespace {

template <int W, int N>
class SmallStepOf final : public SmallStep {
  using L = Lanes<W>;
  using Column = L[N];
  using Matrix = L[N][N];

 public:
  SmallStepOf(const GroupClass& group_class, const Program& program, const BlockConditions& blocks, Separable separable)
      : derivatives_(group_class.derivatives),
        reads_(blocks.reads(0)),
        c_(group_class, program, std::move(separable)) {}

  void choose_pivots(Pack& pack, const double* state) override {
    Column x, phi;
    Matrix u, jacobian;
    load(state + pack.unknowns, x);
    c_.set_inputs(pack, state);
    evaluate(x, u, phi);
    differentiate(u, jacobian);
    for (LaneArray* swaps : {&pack.swaps, &pack.kept.swaps}) swaps->resize(SmallLu<W, N>::kSwaps * W);
    SmallLu<W, N>::choose_swaps(jacobian, pack.swaps.data());
  }

  bool run(const Pack& pack, double* const (&state)[3], int most_iterations, double converged,
           SmallStepFigures& figures) override {
    Column x;
    Matrix u;  // a_ij x_j + b_ij
    load(state[0] + pack.unknowns, x);
    c_.set_inputs(pack, state[0]);
    if (!newton(pack, x, u, most_iterations, converged, figures)) return false;
    if (derivatives_ > 0 && !derivatives(pack, x, u, state, figures)) return false;
    figures.ball_used = c_.ball_use(pack, reads_, x);
    store(x, state[0] + pack.unknowns);
    return true;
  }

 private:
  HWY_INLINE bool newton(const Pack& pack, Column& x, Matrix& u, int most_iterations, double converged,
                         SmallStepFigures& figures) {
    Column phi, scale;
    evaluate(x, u, phi);
    for (int i = 0; i < N; ++i) {
      scale[i] = scale_of(i, x, u);
      scale[i] = if_positive(scale[i], scale[i], L::set(1));
    }
    Column phi_before;
    for (int i = 0; i < N; ++i) phi_before[i] = L::set(0);
    int iteration = 0;
    for (; !at_most(phi, scale, converged); ++iteration) {
      if (iteration == most_iterations) return false;
      if (iteration > 0) {
        const double relative = largest_ratio(phi, scale);
        if (!std::isfinite(relative)) return false;
        const double before = largest_ratio(phi_before, scale);
        // All terms of an equation may vanish at a posture, unless it is a sum of squares and a constant.
        if (c_.may_vanish() && iteration > 1 && falls_slowly(relative, before)) return false;
        if (only_rounding_is_left(relative, before)) break;
      }
      for (int i = 0; i < N; ++i) phi_before[i] = phi[i];
      Matrix jacobian;
      differentiate(u, jacobian);
      if (!lu_.factorize(jacobian, pack.swaps.data())) return false;
      Column correction;
      lu_.solve(phi, correction);
      L largest = L::set(0), poison = L::set(0);
      for (int i = 0; i < N; ++i) {
        x[i] = x[i] - correction[i];
        largest = max(largest, abs(correction[i]));
        poison.add_product(correction[i], L::set(0));
      }
      if (iteration == 0 && !is_near(pack, largest + poison)) return false;
      evaluate(x, u, phi);
    }
    figures.iterations = iteration;
    if (!at_most(phi, scale, figures.position)) figures.position = largest_ratio(phi, scale);
    return true;
  }

  HWY_INLINE bool derivatives(const Pack& pack, const Column& x, const Matrix& u, double* const (&state)[3],
                              SmallStepFigures& figures) {
    Matrix jacobian;
    differentiate(u, jacobian);
    if (!lu_.factorize(jacobian, pack.swaps.data())) return false;
    const L norm = norm_of(jacobian);
    c_.set_rates(pack, state[1]);
    Column rhs, rate;
    for (int i = 0; i < N; ++i) {
      rhs[i] = L::set(0);
      for (int j = 0; j < N; ++j) rhs[i].subtract_product(twice_s(i, j) * u[i][j], c_.b_rate(i, j));
    }
    c_.subtract_rates(x, rhs);
    lu_.solve(rhs, rate);
    figures.velocity = residual(jacobian, norm, rate, rhs, figures.velocity);
    store(rate, state[1] + pack.unknowns);
    if (derivatives_ > 1) {
      c_.set_accelerations(pack, state[2]);
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
      Column acceleration;
      lu_.solve(rhs, acceleration);
      figures.acceleration = residual(jacobian, norm, acceleration, rhs, figures.acceleration);
      store(acceleration, state[2] + pack.unknowns);
    }
    return std::isfinite(figures.velocity + figures.acceleration);
  }

  HWY_INLINE L twice_s(int i, int j) const {
    const L s = c_.s(i, j);
    return s + s;
  }

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

  // True if omega |first correction| is within its limit. A correction of 0 is within any ball.
  static HWY_INLINE bool is_near(const Pack& pack, const L& largest) {
    const L used = if_positive(largest, largest * L::load(pack.omega.data()), largest);
    return used.largest() <= largest_first_correction(pack.ball_used[0]);
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

  int derivatives_;
  std::span<const std::int32_t> reads_;  // coordinates that the branch check examines
  Coefficients<W, N> c_;
  SmallLu<W, N> lu_;
};

template <int W>
SmallStep* of_size(const GroupClass& group_class, const Program& program, const BlockConditions& blocks,
                   Separable separable) {
  switch (program.n) {
    case 2:
      return new SmallStepOf<W, 2>(group_class, program, blocks, std::move(separable));
    case 3:
      return new SmallStepOf<W, 3>(group_class, program, blocks, std::move(separable));
    default:
      return nullptr;
  }
}

SmallStep* make(const GroupClass& group_class, const Program& program, const BlockConditions& blocks,
                Separable separable, int lanes) {
  switch (lanes) {
    case 1:
      return of_size<1>(group_class, program, blocks, std::move(separable));
    case 2:
      return of_size<2>(group_class, program, blocks, std::move(separable));
    case 4:
      return of_size<4>(group_class, program, blocks, std::move(separable));
    case 8:
      return of_size<8>(group_class, program, blocks, std::move(separable));
    default:
      return nullptr;
  }
}

}  // namespace
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace assur {

HWY_EXPORT(make);

std::unique_ptr<SmallStep> make_small_step(const GroupClass& group_class, const Program& program,
                                           const BlockConditions& blocks, int lanes) {
  // A small step computes all derivatives, also those that first_wanted skips.
  if (!group_class.quadratic || program.blocks != 1 || group_class.first_wanted != 0) return nullptr;
  auto separable = separate(program, group_class.input_moves);
  if (!separable) return nullptr;
  return std::unique_ptr<SmallStep>(
      HWY_DYNAMIC_DISPATCH(make)(group_class, program, blocks, std::move(*separable), lanes));
}

}  // namespace assur
#endif
