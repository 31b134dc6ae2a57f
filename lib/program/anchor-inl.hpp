// New anchors: what BranchGuard does with one group after the other, for the lanes of a step. Each lane for itself, in
// the text that writes programs as well, see SmallGroup. Included once for each target, inside its HWY_NAMESPACE (see
// Highway, "foreach_target.h").
#if defined(ASSUR_ANCHOR_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_ANCHOR_INL
#undef ASSUR_ANCHOR_INL
#else
#define ASSUR_ANCHOR_INL
#endif

#include <hwy/highway.h>

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
// they keep their anchors. n: unknowns; scale: of the equations at that posture; entry(r, c): of the inverse of the
// Jacobian there; poor: positive where it is not exact; at(k): coordinate k of the branch test, of those in `reads`.
// Io: the Source of a SmallGroup, and
//   L load(memory, i)
//   void store(memory, i, value)
template <class L, class Io, class Scale, class Entry, class At>
HWY_INLINE void renew_anchors(Io& io, int n, int derivatives, std::span<const std::int32_t> reads, const Scale& scale,
                              const Entry& entry, const L& poor, const At& at) {
  const L zero = L::set(0), one = L::set(1);
  L omega, left;  // left: error of the posture over the relative residual
  for (int r = 0; r < n; ++r) {
    L of_lipschitz, of_scale;
    for (int c = 0; c < n; ++c) {
      const L size = abs(entry(r, c)), lipschitz = io.load(Memory::lipschitz, idx(c));
      of_lipschitz = c == 0 ? size * lipschitz : of_lipschitz + size * lipschitz;
      of_scale = c == 0 ? size * scale[c] : of_scale + size * scale[c];
    }
    omega = r == 0 ? of_lipschitz : max(of_lipschitz, omega);
    left = r == 0 ? of_scale : max(of_scale, left);
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
    renew(Memory::anchor, k, at(k));
    if (derivatives == 0) continue;
    const std::int32_t reg = reads[k];
    renew(Memory::anchor_rates, k, reg < n ? io.load(Memory::rates, idx(reg)) : io.input(1, reg - n));
  }
}

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
