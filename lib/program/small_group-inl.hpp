// The step of a small group: Newton's method, velocity, acceleration and the branch test, by the rules of
// step_rules.hpp and of NewtonStep. Each lane computes and decides for itself, so its bits do not depend on its
// neighbours. The same text runs in registers (groups/step_kernel.cpp) and writes the program of the step
// (program/group_step.cpp). Included once for each target, inside its HWY_NAMESPACE (see Highway, "foreach_target.h").
#if defined(ASSUR_SMALL_GROUP_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_SMALL_GROUP_INL
#undef ASSUR_SMALL_GROUP_INL
#else
#define ASSUR_SMALL_GROUP_INL
#endif

#include "program/anchor-inl.hpp"
#include "program/group_tests-inl.hpp"
#include "program/small_equations-inl.hpp"
#include "program/small_inverse-inl.hpp"

#include <cstddef>
#include <cstdint>
#include <span>

#include "program/group_step.hpp"
#include "program/step_rules.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

// L: Lanes, or Value. Source: reads the numbers of a pack, by
//   L coefficient(i)               of the equations, also zero_coefficient() and one_coefficient()
//   L input(d, i), unknown(j)      d-th derivative of an input; predicted unknown
//   L anchor(k), omega(), ball_used()  see Memory
//   L setting(GroupSetting)
template <class L, int N>
class SmallGroup {
  using Equations = SmallEquations<L, N>;
  using Tests = GroupTests<L>;
  using Column = typename Equations::Column;
  using Matrix = typename Equations::Matrix;

 public:
  // Between the phases.
  struct State {
    Column x, phi, weight;                   // unknowns, equations, 1 / their scales
    L relative, active, failed, iterations;  // largest |phi| weight; 1 as long as the lane iterates; see GroupFigure
    L last;                                  // with gears: the largest entry of the last correction
  };
  struct Figures {
    L velocity, acceleration, ball_used, needs_anchor;
    L rough;  // positive where linear solutions must be refined and were not
  };

  explicit SmallGroup(const GroupClass& group_class) : equations_(group_class) {}

  [[nodiscard]] Equations& equations() { return equations_; }

  template <class Source>
  HWY_INLINE void begin(const Source& in, State& s) {
    equations_.set_inputs(in);
    for (int j = 0; j < N; ++j) s.x[j] = in.unknown(j);
    equations_.evaluate(in, s.x, s.phi);
    const L one = L::set(1);
    Column scale, ratio;
    equations_.scale(in, scale);
    for (int i = 0; i < N; ++i) {
      s.weight[i] = one / if_at_most(scale[i], L::set(0), one, scale[i]);
      ratio[i] = s.phi[i] * s.weight[i];
    }
    s.relative = Tests::largest_of(ratio);
    s.active = Tests::is_open(ratio, in.setting(GroupSetting::converged_at));
    s.failed = s.iterations = s.last = L::set(0);
  }

  // One correction. A lane that is not active keeps its numbers.
  template <class Source>
  HWY_INLINE void iterate(const Source& in, State& s) {
    const L zero = L::set(0), one = L::set(1);
    Matrix jacobian;
    Column next, phi, by, ratio;
    equations_.evaluate(in, s.x, phi);
    equations_.differentiate(in, jacobian);
    L failed = inverse_.invert(jacobian);
    inverse_.solve(s.phi, by);
    for (int j = 0; j < N; ++j) next[j] = s.x[j] - by[j];
    equations_.evaluate(in, next, phi);
    for (int i = 0; i < N; ++i) ratio[i] = phi[i] * s.weight[i];

    const L relative = Tests::largest_of(ratio), iterations = s.iterations + one;
    const L largest_first = L::set(largest_first_correction(0)) * (one - in.ball_used());
    const L is_near = if_at_most(Tests::part_of_ball(in, by), largest_first, failed, one);
    failed = if_at_most(s.iterations, zero, is_near, failed);
    L largest = zero;
    if (equations_.has_gears()) {
      // No ball guards the branch, so corrections must contract.
      largest = Tests::largest_of(by);
      const L diverges = if_at_most(s.relative, L::set(kRoundingLevel), failed, one);
      const L contracts = if_at_most(largest, L::set(kContraction) * s.last, failed, diverges);
      failed = if_at_most(s.iterations, zero, failed, contracts);
    }
    failed = if_at_most(failed + (relative - relative), zero, zero, one);  // also if it is not finite
    const typename Tests::Progress progress = Tests::progress(ratio, in.setting(GroupSetting::converged_at), relative,
                                                              s.relative, iterations, equations_.may_vanish(), failed);
    failed = progress.failed;
    const L still_open = progress.goes_on;
    const L too_many = if_at_most(in.setting(GroupSetting::most_iterations), iterations, one, failed);
    failed = if_at_most(still_open, zero, failed, too_many);
    const L goes_on = if_at_most(failed, zero, still_open, zero);

    const auto keep = [&](L& of, const L& value) { of = if_at_most(s.active, zero, of, value); };
    for (int i = 0; i < N; ++i) {
      keep(s.x[i], next[i]);
      keep(s.phi[i], phi[i]);
    }
    keep(s.relative, relative);
    keep(s.failed, failed);
    keep(s.iterations, iterations);
    if (equations_.has_gears()) keep(s.last, largest);
    s.active = if_at_most(s.active, zero, zero, goes_on);
  }

  // Velocity and acceleration, as far as `derivatives` says. Makes State::failed 0 or 1; where it is 1, or where
  // solutions are rough, State::x is the prediction again. kRefine: refines rough solutions. reads: coordinates of the
  // branch test, as registers.
  template <bool kRefine, class Source>
  HWY_INLINE void finish(const Source& in, int derivatives, std::span<const std::int32_t> reads, State& s, Column& rate,
                         Column& acceleration, Figures& figures) {
    figures.velocity = figures.acceleration = L::set(-1);  // not computed
    figures.rough = L::set(0);
    if (derivatives > 0) {
      Matrix jacobian;
      Column rhs;
      equations_.evaluate(in, s.x, rhs);
      equations_.differentiate(in, jacobian);
      const L poor = inverse_.invert(jacobian), norm = Tests::norm_of(jacobian);
      equations_.velocity_rhs(in, rhs);
      figures.velocity = solve<kRefine>(jacobian, norm, rhs, rate, figures.rough);
      s.failed = s.failed + poor;
      if (kRefine) s.failed = s.failed + (figures.velocity - figures.velocity);  // else it is rough
      if (derivatives > 1) {
        equations_.acceleration_rhs(in, rate, rhs);
        figures.acceleration = solve<kRefine>(jacobian, norm, rhs, acceleration, figures.rough);
        if (kRefine) s.failed = s.failed + (figures.acceleration - figures.acceleration);
      }
    }
    figures.ball_used = Tests::ball_use(in, reads.size(), [&](std::size_t k) HWY_ATTR {
      return reads[k] < N ? s.x[reads[k]] : equations_.input(reads[k] - N);
    });
    figures.needs_anchor = Tests::needs_anchor(figures.ball_used, in.ball_used());
    const L zero = L::set(0), one = L::set(1);
    s.failed = if_at_most(s.failed, zero, zero, one);
    const L unsolved = s.failed + figures.rough;
    for (int j = 0; j < N; ++j) s.x[j] = if_at_most(unsolved, zero, s.x[j], in.unknown(j));
  }

  // For the lanes that need an anchor after finish().
  template <class Io>
  HWY_INLINE void renew_anchors(int derivatives, std::span<const std::int32_t> reads, Io& io) {
    Column x, phi, scale;
    Matrix jacobian;
    equations_.set_inputs(io);
    for (int j = 0; j < N; ++j) x[j] = io.load(Memory::unknowns, idx(j));
    equations_.evaluate(io, x, phi);
    equations_.scale(io, scale);
    equations_.differentiate(io, jacobian);
    const L poor = inverse_.invert(jacobian);
    const auto entry = [&](int r, int c) HWY_ATTR { return inverse_.entry(r, c); };
    const auto at = [&](std::size_t k) HWY_ATTR { return reads[k] < N ? x[reads[k]] : equations_.input(reads[k] - N); };
    HWY_NAMESPACE::renew_anchors<L>(io, N, derivatives, reads, scale, entry, poor, at);
  }

 private:
  // Returns the residual. Cofactors alone leave residuals that grow with the condition. The few solutions where that
  // matters are refined.
  template <bool kRefine>
  HWY_INLINE L solve(const Matrix& jacobian, const L& norm, const Column& rhs, Column& x, L& rough) const {
    inverse_.solve(rhs, x);
    const L left = Tests::residual(jacobian, norm, x, rhs);
    if constexpr (!kRefine) {
      rough = rough + Tests::exceeds(left, kLinear);
      return left;
    }
    const L bound = L::set(kLinear);
    if (all_at_most(left, bound)) return left;
    Column rest, refined;
    Tests::rest(jacobian, x, rhs, rest);
    for (int j = 0; j < N; ++j) refined[j] = x[j];
    inverse_.add_solution(rest, refined);
    for (int j = 0; j < N; ++j) x[j] = if_at_most(left, bound, x[j], refined[j]);
    return Tests::residual(jacobian, norm, x, rhs);
  }

  Equations equations_;
  SmallInverse<L, N> inverse_;
};

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
