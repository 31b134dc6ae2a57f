// Compiled once for each SIMD target; make_small_step() chooses the target.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "group/small_step.cpp"
#include <hwy/foreach_target.h>  // must precede the code compiled for each target

#include "group/small_step.hpp"

#include "group/distance_system-inl.hpp"
#include "group/small_lu-inl.hpp"
#include "group/small_system-inl.hpp"

#include <cmath>
#include <utility>

#include "equations/separable.hpp"
#include "program/step_rules.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {
namespace {

// Equations: SmallSystem or DistanceSystem
template <int W, int N, class Equations>
class SmallStepOf final : public SmallStep {
  using L = Lanes<W>;
  using Column = typename Equations::Column;
  using Matrix = typename Equations::Matrix;

 public:
  SmallStepOf(const GroupClass& group_class, const Program& program, const BlockConditions& blocks, Separable separable)
      : derivatives_(group_class.derivatives),
        reads_(blocks.reads(0)),
        s_(group_class, program, std::move(separable)) {}

  void choose_pivots(Pack& pack, const double* state) override {
    Column x, phi;
    Matrix u, jacobian;
    Equations::load(state + pack.unknowns, x);
    s_.set_inputs(pack, state);
    s_.evaluate(x, u, phi);
    s_.differentiate(u, jacobian);
    for (LaneArray* swaps : {&pack.swaps, &pack.kept.swaps}) swaps->resize(SmallLu<W, N>::kSwaps * W);
    SmallLu<W, N>::choose_swaps(jacobian, pack.swaps.data());
  }

  bool run(const Pack& pack, double* const (&state)[3], int most_iterations, double converged,
           SmallStepFigures& figures) override {
    Column x;
    Matrix u;  // a_ij x_j + b_ij
    Equations::load(state[0] + pack.unknowns, x);
    s_.set_inputs(pack, state[0]);
    if (!newton(pack, x, u, most_iterations, converged, figures)) return false;
    if (derivatives_ > 0 && !derivatives(pack, x, u, state, figures)) return false;
    figures.ball_used = s_.ball_use(pack, reads_, x).largest();
    Equations::store(x, state[0] + pack.unknowns);
    return true;
  }

 private:
  HWY_INLINE bool newton(const Pack& pack, Column& x, Matrix& u, int most_iterations, double converged,
                         SmallStepFigures& figures) {
    Column phi, scale;
    s_.evaluate(x, u, phi);
    for (int i = 0; i < N; ++i) {
      scale[i] = s_.scale_of(i, x, u);
      scale[i] = if_positive(scale[i], scale[i], L::set(1));
    }
    Column phi_before;
    for (int i = 0; i < N; ++i) phi_before[i] = L::set(0);
    int iteration = 0;
    for (; !Equations::at_most(phi, scale, converged); ++iteration) {
      if (iteration == most_iterations) return false;
      if (iteration > 0) {
        const double relative = Equations::largest_ratio(phi, scale);
        if (!std::isfinite(relative)) return false;
        const double before = Equations::largest_ratio(phi_before, scale);
        // All terms of an equation may vanish at a posture, unless it is a sum of squares and a constant.
        if (s_.may_vanish() && iteration > 1 && falls_slowly(relative, before)) return false;
        if (only_rounding_is_left(relative, before)) break;
      }
      for (int i = 0; i < N; ++i) phi_before[i] = phi[i];
      Matrix jacobian;
      s_.differentiate(u, jacobian);
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
      s_.evaluate(x, u, phi);
    }
    figures.iterations = iteration;
    if (!Equations::at_most(phi, scale, figures.position)) figures.position = Equations::largest_ratio(phi, scale);
    return true;
  }

  HWY_INLINE bool derivatives(const Pack& pack, const Column& x, const Matrix& u, double* const (&state)[3],
                              SmallStepFigures& figures) {
    Matrix jacobian;
    s_.differentiate(u, jacobian);
    if (!lu_.factorize(jacobian, pack.swaps.data())) return false;
    const L norm = Equations::norm_of(jacobian);
    s_.set_rates(pack.input_rows.data(), pack.inputs.data(), state[1]);
    Column rhs, rate;
    s_.velocity_rhs(x, u, rhs);
    lu_.solve(rhs, rate);
    figures.velocity = Equations::residual(jacobian, norm, rate, rhs, figures.velocity);
    Equations::store(rate, state[1] + pack.unknowns);
    if (derivatives_ > 1) {
      s_.set_accelerations(pack.input_rows.data(), pack.inputs.data(), state[2]);
      s_.acceleration_rhs(x, u, rate, rhs);
      Column acceleration;
      lu_.solve(rhs, acceleration);
      figures.acceleration = Equations::residual(jacobian, norm, acceleration, rhs, figures.acceleration);
      Equations::store(acceleration, state[2] + pack.unknowns);
    }
    return std::isfinite(figures.velocity + figures.acceleration);
  }

  // True if omega |first correction| is within its limit. A correction of 0 is within any ball.
  static HWY_INLINE bool is_near(const Pack& pack, const L& largest) {
    const L used = if_positive(largest, largest * L::load(pack.omega.data()), largest);
    return used.largest() <= largest_first_correction(pack.ball_used[0]);
  }

  int derivatives_;
  std::span<const std::int32_t> reads_;  // coordinates that the branch check examines
  Equations s_;
  SmallLu<W, N> lu_;
};

template <int W, int N>
SmallStep* of_size(const GroupClass& group_class, const Program& program, const BlockConditions& blocks,
                   Separable separable) {
  if (measures_distances(separable, program)) {
    return new SmallStepOf<W, N, DistanceSystem<W, N>>(group_class, program, blocks, std::move(separable));
  }
  return new SmallStepOf<W, N, SmallSystem<W, N>>(group_class, program, blocks, std::move(separable));
}

template <int W>
SmallStep* of_lanes(const GroupClass& group_class, const Program& program, const BlockConditions& blocks,
                    Separable separable) {
  switch (program.n) {
    case 2:
      return of_size<W, 2>(group_class, program, blocks, std::move(separable));
    case 3:
      return of_size<W, 3>(group_class, program, blocks, std::move(separable));
    default:
      return nullptr;
  }
}

#if (HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_EMU128) && !defined(HWY_COMPILE_ONLY_SCALAR)
// Without SIMD, these steps would take half of the compile time of this file. GroupSolver does without them where other
// targets are compiled, too.
SmallStep* make(const GroupClass&, const Program&, const BlockConditions&, Separable, int) { return nullptr; }
#else
SmallStep* make(const GroupClass& group_class, const Program& program, const BlockConditions& blocks,
                Separable separable, int lanes) {
  switch (lanes) {
    case 1:
      return of_lanes<1>(group_class, program, blocks, std::move(separable));
    case 2:
      return of_lanes<2>(group_class, program, blocks, std::move(separable));
    case 4:
      return of_lanes<4>(group_class, program, blocks, std::move(separable));
    case 8:
      return of_lanes<8>(group_class, program, blocks, std::move(separable));
    default:
      return nullptr;
  }
}
#endif

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
