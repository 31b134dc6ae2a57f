// The step of the groups of a class that are solved together with those of all other levels: the passes of
// program/together_step.hpp. Each lane for itself, in the text that writes programs as well, see SmallGroup. Included
// once for each target, inside its HWY_NAMESPACE (see Highway, "foreach_target.h").
#if defined(ASSUR_TOGETHER_GROUP_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_TOGETHER_GROUP_INL
#undef ASSUR_TOGETHER_GROUP_INL
#else
#define ASSUR_TOGETHER_GROUP_INL
#endif

#include "program/anchor-inl.hpp"
#include "program/distance_equations-inl.hpp"
#include "program/group_tests-inl.hpp"
#include "program/separable_equations-inl.hpp"
#include "program/small_inverse-inl.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>

#include "equations/separable.hpp"
#include "index.hpp"
#include "program/graph.hpp"
#include "program/group_step.hpp"
#include "program/slopes.hpp"
#include "program/step_rules.hpp"
#include "program/together_step.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

// Numbers in Memory::work: weights, the largest residual, a right-hand side, and an inverse.
template <int N>
constexpr std::size_t work_of_together_group() {
  return 2 * N + 1 + SmallInverse<Value, N>::kNumbers;
}

// L, Equations: see SmallGroup. Io: the Source of a SmallGroup, and
//   L load(memory, i)
//   void store(memory, i, value)
template <class L, int N, class Equations>
class TogetherGroup {
  using Tests = GroupTests<L, N>;
  using Column = typename Tests::Column;
  using Matrix = typename Tests::Matrix;

 public:
  TogetherGroup(std::span<const std::int32_t> reads, const Slopes& slopes, const GroupClass& group_class,
                const Separable& separable)
      : derivatives_(group_class.derivatives), reads_(reads), slopes_(slopes), s_(group_class, separable) {}

  template <class Io>
  HWY_INLINE void run(TogetherPass pass, Io& io) {
    switch (pass) {
      case TogetherPass::begin:
        return linearise<true>(io);
      case TogetherPass::linearise:
        return linearise<false>(io);
      case TogetherPass::approach:
        return approach(io);
      case TogetherPass::rates:
        return find_own_rates(io);
      case TogetherPass::accelerations:
        return find_own_accelerations(io);
      case TogetherPass::finish:
        return finish(io);
      case TogetherPass::anchors:
        return renew_anchors<L, N>(io, derivatives_, reads_, s_, inverse_);
    }
  }

 private:
  // Places in Memory::work.
  static constexpr std::size_t kWeights = 0, kRelative = N, kRhs = N + 1, kInverse = 2 * N + 1;

  // The equations at the current posture.
  struct Here {
    Column x, phi;
    typename Equations::Values u;
  };
  template <bool kMeasure, class Io>
  HWY_INLINE void evaluate(const Io& io, Here& at) {
    s_.template set_inputs<kMeasure>(io);
    for (int j = 0; j < N; ++j) at.x[j] = io.load(Memory::unknowns, idx(j));
    s_.evaluate(io, at.x, at.u, at.phi);
  }
  template <class Io>
  static HWY_INLINE L figure(const Io& io, GroupFigure f) {
    return io.load(Memory::figures, static_cast<std::size_t>(f));
  }
  template <class Io>
  static HWY_INLINE void tell(Io& io, GroupFigure f, const L& value) {
    io.store(Memory::figures, static_cast<std::size_t>(f), value);
  }
  // failed: 0, or anything else, even NaN
  template <class Io>
  static HWY_INLINE void tell_failed(Io& io, const L& failed) {
    tell(io, GroupFigure::failed, if_at_most(failed, L::set(0), L::set(0), L::set(1)));
  }
  template <class Io>
  static HWY_INLINE void store(Io& io, Memory memory, const Column& from, std::size_t first = 0) {
    for (std::size_t j = 0; j < N; ++j) io.store(memory, first + j, from[j]);
  }
  template <class Io>
  static HWY_INLINE Column& load(const Io& io, Memory memory, Column& to, std::size_t first = 0) {
    for (std::size_t j = 0; j < N; ++j) to[j] = io.load(memory, first + j);
    return to;
  }
  template <class Io>
  HWY_INLINE void recall_inverse(const Io& io) {
    inverse_.recall([&](std::size_t k) HWY_ATTR { return io.load(Memory::work, kInverse + k); });
  }

  template <bool kBegin, class Io>
  HWY_INLINE void linearise(Io& io) {
    const L zero = L::set(0), one = L::set(1), converged = io.setting(GroupSetting::converged_at);
    Here at;
    evaluate<kBegin>(io, at);
    Column weight, ratio;
    if constexpr (kBegin) {
      Column scale;
      s_.scale(io, at.x, at.u, scale);
      for (int i = 0; i < N; ++i) weight[i] = one / if_at_most(scale[i], zero, one, scale[i]);
      store(io, Memory::work, weight, kWeights);
    } else {
      load(io, Memory::work, weight, kWeights);
    }
    Tests::multiply(at.phi, weight, ratio);
    const L relative = Tests::largest_of(ratio);
    L failed = relative - relative, open;
    if constexpr (kBegin) {
      open = Tests::is_open(ratio, converged);
    } else {
      failed = figure(io, GroupFigure::failed) + failed;
      const typename Tests::Progress progress =
          Tests::judge(ratio, converged, relative, io.load(Memory::work, kRelative),
                       io.setting(GroupSetting::corrections), s_.may_vanish(), failed);
      failed = progress.failed;
      open = progress.goes_on;
    }
    io.store(Memory::work, kRelative, relative);
    tell(io, GroupFigure::position, relative);
    tell(io, kOpen, open);

    Matrix jacobian;
    s_.differentiate(io, at.u, jacobian);
    const L poor = inverse_.invert(jacobian);
    tell_failed(io, failed + poor);
    inverse_.keep([&](std::size_t k, const L& value) HWY_ATTR { io.store(Memory::work, kInverse + k, value); });
    Column rhs, own;
    for (int i = 0; i < N; ++i) rhs[i] = zero - at.phi[i];
    inverse_.solve(rhs, own);
    store(io, Memory::own, own);
    for (std::size_t k = 0; k < slopes_.equations.size(); ++k) {
      inverse_.column(slopes_.equations[k], own);
      store(io, static_cast<Memory>(kColumns + k), own);
    }
    for (std::size_t e = 0; e < slopes_.entries.size(); ++e) io.store(Memory::slopes, e, slope(io, at, e));
  }
  template <class Io>
  HWY_INLINE L slope(const Io& io, const Here& at, std::size_t entry) const {
    const Slopes::Entry& e = slopes_.entries[entry];
    const std::int32_t i = slopes_.equations[idx(e.row)];
    L sum = L::set(0);
    for (std::size_t k = e.begin; k < e.end; ++k) {
      const Slopes::Term& t = slopes_.terms[k];
      L factor = io.coefficient(t.share);
      if (!Equations::kDistances) factor = factor * io.coefficient(t.coefficient);
      if (t.square >= 0) {
        factor = (factor + factor) * at.u[i][t.square];
      } else if (t.unknown >= 0) {
        factor = factor * io.coefficient(t.slope) * at.x[t.unknown];
      }
      sum = sum + factor;
    }
    return sum;
  }

  template <class Io>
  HWY_INLINE void approach(Io& io) {
    L largest = L::set(0), poison = largest;
    for (std::size_t j = 0; j < N; ++j) Tests::include(io.load(Memory::change, j), largest, poison);
    for (const Slopes::Entry& e : slopes_.entries) {
      Tests::include(io.load(Memory::sources, idx(e.input)), largest, poison);
    }
    const L used = Tests::times_omega(io, largest) + poison;
    const L limit = L::set(largest_first_correction(0)) * (L::set(1) - io.ball_used());
    tell_failed(io, figure(io, GroupFigure::failed) + if_at_most(used, limit, L::set(0), L::set(1)));
  }

  template <class Io>
  HWY_INLINE void find_own_rates(Io& io) {
    Here at;
    evaluate<false>(io, at);
    Column rhs, own;
    s_.set_rates(io);
    s_.velocity_rhs(io, at.x, at.u, rhs);
    recall_inverse(io);
    inverse_.solve(rhs, own);
    store(io, Memory::own, own);
  }

  template <class Io>
  HWY_INLINE void find_own_accelerations(Io& io) {
    Here at;
    evaluate<false>(io, at);
    Matrix jacobian;
    s_.differentiate(io, at.u, jacobian);
    Column rhs, rate, own;
    load(io, Memory::rates, rate);
    s_.set_rates(io);
    s_.velocity_rhs(io, at.x, at.u, rhs);
    const L residual = Tests::residual(jacobian, Tests::norm_of(jacobian), rate, rhs);
    tell(io, GroupFigure::velocity, residual);
    tell_failed(io, figure(io, GroupFigure::failed) + Tests::exceeds(residual, kPivotsGrew));
    if (derivatives_ < 2) return;
    s_.set_accelerations(io);
    s_.acceleration_rhs(io, at.x, at.u, rate, rhs);
    store(io, Memory::work, rhs, kRhs);
    recall_inverse(io);
    inverse_.solve(rhs, own);
    store(io, Memory::own, own);
  }

  template <class Io>
  HWY_INLINE void finish(Io& io) {
    Here at;
    evaluate<false>(io, at);
    if (derivatives_ > 1) {
      Matrix jacobian;
      s_.differentiate(io, at.u, jacobian);
      Column rhs, acceleration;
      load(io, Memory::work, rhs, kRhs);
      load(io, Memory::accelerations, acceleration);
      for (std::size_t k = 0; k < slopes_.equations.size(); ++k) {
        L& of_row = rhs[slopes_.equations[k]];
        of_row = of_row + io.load(Memory::loads, k);
      }
      const L residual = Tests::residual(jacobian, Tests::norm_of(jacobian), acceleration, rhs);
      tell(io, GroupFigure::acceleration, residual);
      tell_failed(io, figure(io, GroupFigure::failed) + Tests::exceeds(residual, kPivotsGrew));
    }
    const L used = Tests::ball_use(io, reads_.size(), [&](std::size_t k) HWY_ATTR {
      return reads_[k] < N ? at.x[reads_[k]] : s_.input(reads_[k] - N);
    });
    tell(io, GroupFigure::ball_used, used);
    tell(io, GroupFigure::needs_anchor, Tests::needs_anchor(used, io.ball_used()));
  }

  int derivatives_;
  std::span<const std::int32_t> reads_;  // coordinates of the branch test
  const Slopes& slopes_;
  Equations s_;
  SmallInverse<L, N> inverse_;
};

// Calls make(std::type_identity<TogetherGroup>(), group_class, separable) with the one that serves a class best.
template <class L, int N, class Make>
auto with_together_group(const GroupClass& group_class, const Make& make) {
  const std::optional<Separable> separable = separate(group_class);
  if (measures_distances(*separable, group_class)) {
    return make(std::type_identity<TogetherGroup<L, N, DistanceEquations<L, N>>>(), *separable);
  }
  return make(std::type_identity<TogetherGroup<L, N, SeparableEquations<L, N>>>(), *separable);
}

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
