// New anchors of small groups: what BranchGuard does with one group after the other, for the lanes of a step. Each lane
// for itself, in the text that writes programs as well, see SmallGroup. Included once for each target, inside its
// HWY_NAMESPACE (see Highway, "foreach_target.h").
#if defined(ASSUR_ANCHOR_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_ANCHOR_INL
#undef ASSUR_ANCHOR_INL
#else
#define ASSUR_ANCHOR_INL
#endif

#include "program/small_inverse-inl.hpp"

#include <cstddef>
#include <cstdint>
#include <span>

#include "index.hpp"
#include "numbers.hpp"
#include "program/group_step.hpp"
#include "program/step_rules.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

// Makes the solved posture the anchor of the lanes that ask for one, and takes the part of the ball that the others
// used. The figure `failed` then is 1 in lanes that left the ball, or whose posture is too close to a singular one:
// they keep their anchors. Io: see TogetherGroup
template <class L, int N, class Equations, class Io>
HWY_INLINE void renew_anchors(Io& io, int derivatives, std::span<const std::int32_t> reads, Equations& equations,
                              SmallInverse<L, N>& inverse) {
  const L zero = L::set(0), one = L::set(1);
  L x[N], phi[N], jacobian[N][N], scale[N];
  typename Equations::Values u;
  equations.set_inputs(io);
  for (int j = 0; j < N; ++j) x[j] = io.load(Memory::unknowns, idx(j));
  equations.evaluate(io, x, u, phi);
  equations.scale(io, x, u, scale);
  equations.differentiate(io, u, jacobian);
  const L poor = inverse.invert(jacobian);
  L of_lipschitz[N], of_scale[N];
  for (int c = 0; c < N; ++c) {
    L column[N];
    inverse.column(c, column);
    const L lipschitz = io.load(Memory::lipschitz, idx(c));
    for (int r = 0; r < N; ++r) {
      const L size = abs(column[r]);
      of_lipschitz[r] = c == 0 ? size * lipschitz : of_lipschitz[r] + size * lipschitz;
      of_scale[r] = c == 0 ? size * scale[c] : of_scale[r] + size * scale[c];
    }
  }
  L omega = of_lipschitz[0], left = of_scale[0];  // left: error of the posture over the relative residual
  for (int r = 1; r < N; ++r) {
    omega = max(of_lipschitz[r], omega);
    left = max(of_scale[r], left);
  }
  const auto figure = [&](GroupFigure f) HWY_ATTR { return io.load(Memory::figures, static_cast<std::size_t>(f)); };
  const L used = figure(GroupFigure::ball_used), needs = figure(GroupFigure::needs_anchor);
  const L poison = poor + (omega - omega) + (left - left);
  L renews = if_at_most(used, L::set(kBall), one, zero);
  renews = if_at_most(omega * (L::set(kConverged) * left), L::set(kRoundingRoom), renews, zero);
  renews = if_at_most(poison, zero, renews, zero);
  renews = if_at_most(needs, zero, zero, renews);
  const L before = io.ball_used(), unused = if_at_most(needs, zero, used, before);
  const auto choose = [&](const L& there, const L& kept) HWY_ATTR { return if_at_most(renews, zero, kept, there); };
  const auto renew = [&](Memory memory, std::size_t k, const L& value)
                         HWY_ATTR { io.store(memory, k, choose(value, io.load(memory, k))); };
  io.store(Memory::ball_used, 0, choose(zero, unused));
  io.store(Memory::figures, static_cast<std::size_t>(GroupFigure::failed), if_at_most(needs, renews, zero, one));
  renew(Memory::omega, 0, omega);
  // Without rates the cubic from the anchor, and so the tube, is unknown.
  renew(Memory::anchor_time, 0, derivatives > 0 ? io.setting(GroupSetting::time) : L::set(kNan));
  for (std::size_t k = 0; k < reads.size(); ++k) {
    const std::int32_t reg = reads[k];
    renew(Memory::anchor, k, reg < N ? x[reg] : equations.input(reg - N));
    if (derivatives == 0) continue;
    renew(Memory::anchor_rates, k, reg < N ? io.load(Memory::rates, idx(reg)) : io.input(1, reg - N));
  }
}

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
