// Compiled once for each SIMD target; make_small_step() chooses the target.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "groups/step_kernel.cpp"
#include <hwy/foreach_target.h>  // must precede the code compiled for each target

#include "groups/pack_source-inl.hpp"
#include "program/small_group-inl.hpp"

#include <algorithm>

#include "groups/pack_memory.hpp"
#include "groups/small_step.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {
namespace {

template <int W>
class StepSource : public PackSource<W> {
  using L = Lanes<W>;

 public:
  StepSource(const Pack& pack, const double* const* state, double most_iterations, double converged)
      : PackSource<W>(pack, state),
        ball_used_(pack.ball_used.data()),
        converged_(converged),
        most_iterations_(most_iterations) {}

  HWY_INLINE L ball_used() const { return L::load(ball_used_); }
  HWY_INLINE L setting(GroupSetting s) const {
    return L::set(s == GroupSetting::converged_at ? converged_ : most_iterations_);
  }

 private:
  const double* ball_used_;
  double converged_, most_iterations_;
};

// Also reads and writes rows of memories.
template <int W>
class AnchorSource : public StepSource<W> {
  using L = Lanes<W>;

 public:
  AnchorSource(const Pack& pack, const double* const* state, double* const* memory, double time)
      : StepSource<W>(pack, state, 0, 0), memory_(memory), time_(time) {}

  HWY_INLINE L load(Memory memory, std::size_t i) const { return L::load(at(memory, i)); }
  HWY_INLINE void store(Memory memory, std::size_t i, const L& value) { value.store(at(memory, i)); }
  HWY_INLINE L setting(GroupSetting) const { return L::set(time_); }

 private:
  HWY_INLINE double* at(Memory memory, std::size_t i) const {
    return memory_[static_cast<std::size_t>(memory)] + i * W;
  }

  double* const* memory_;
  double time_;
};

template <int W, int N>
class StepKernel final : public SmallStep {
  using L = Lanes<W>;
  using Group = SmallGroup<L, N>;

 public:
  StepKernel(const GroupClass& group_class, std::span<const std::int32_t> reads)
      : derivatives_(group_class.derivatives), reads_(reads), group_(group_class) {}

  bool run(const Pack& pack, double* const (&state)[3], int most_iterations, double converged,
           SmallStepFigures& figures) override {
    const StepSource<W> in(pack, state, most_iterations, converged);
    typename Group::State s;
    group_.begin(in, s);
    while (!less_equal(s.active, L::set(0)).all()) group_.iterate(in, s);
    typename Group::Figures of_step;
    L rate[N] = {}, acceleration[N] = {};
    group_.template finish<true>(in, derivatives_, reads_, s, rate, acceleration, of_step);
    if (derivatives_ > 0) store(rate, state[1] + pack.unknowns);
    if (derivatives_ > 1) store(acceleration, state[2] + pack.unknowns);
    store(s.x, state[0] + pack.unknowns);
    figures.failed = store_figure(GroupFigure::failed, s.failed);
    if (!less_equal(s.failed, L::set(0)).all()) return false;
    figures.iterations = store_figure(GroupFigure::iterations, s.iterations);
    figures.ball_used = store_figure(GroupFigure::ball_used, of_step.ball_used);
    figures.needs_anchor = store_figure(GroupFigure::needs_anchor, of_step.needs_anchor);
    figures.balls_last = less_equal(of_step.needs_anchor, L::set(0)).all();
    raise(figures.position, s.relative);
    if (derivatives_ > 0) raise(figures.velocity, of_step.velocity);
    if (derivatives_ > 1) raise(figures.acceleration, of_step.acceleration);
    return true;
  }

  const double* renew_anchors(Pack& pack, double* const (&state)[3], double time) override {
    double* memory[kMemories];
    point_to(pack, memory);
    point_to_unknowns(pack, state, memory);
    memory[static_cast<std::size_t>(Memory::figures)] = figures_;
    AnchorSource<W> io(pack, state, memory, time);
    group_.renew_anchors(derivatives_, reads_, io);
    return figures_ + static_cast<std::size_t>(GroupFigure::failed) * W;
  }

 private:
  HWY_INLINE const double* store_figure(GroupFigure f, const L& of) {
    double* const to = figures_ + static_cast<std::size_t>(f) * W;
    of.store(to);
    return to;
  }
  static HWY_INLINE void store(const L (&from)[N], double* to) {
    for (int j = 0; j < N; ++j) from[j].store(to + j * W);
  }
  static HWY_INLINE void raise(double& most, const L& by) {
    if (HWY_UNLIKELY(!less_equal(by, L::set(most)).all())) most = std::max(most, by.largest());
  }

  int derivatives_;
  std::span<const std::int32_t> reads_;  // coordinates that the branch test examines
  Group group_;
  alignas(kLineBytes) double figures_[kGroupFigures * W] = {};
};

template <int W>
SmallStep* of_lanes(const GroupClass& group_class, std::span<const std::int32_t> reads) {
  if (group_class.n == 2) return new StepKernel<W, 2>(group_class, reads);
  return new StepKernel<W, 3>(group_class, reads);
}

#if !HWY_NATIVE_FMA && !defined(HWY_COMPILE_ONLY_SCALAR)
// Without products and sums that are rounded once, kernels are slow, and take most of the compile time of this file:
// see make_small_step().
SmallStep* make(const GroupClass&, std::span<const std::int32_t>, int) { return nullptr; }
#else
SmallStep* make(const GroupClass& group_class, std::span<const std::int32_t> reads, int lanes) {
  switch (lanes) {
    case 1:
      return of_lanes<1>(group_class, reads);
    case 2:
      return of_lanes<2>(group_class, reads);
    case 4:
      return of_lanes<4>(group_class, reads);
    case 8:
      return of_lanes<8>(group_class, reads);
    default:
      return of_lanes<16>(group_class, reads);
  }
}
#endif

}  // namespace
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace assur {

HWY_EXPORT(make);

std::unique_ptr<SmallStep> make_small_step(const Workspace& work, const BlockConditions& blocks) {
  if (!has_group_step(work.group_class)) return nullptr;
  std::unique_ptr<SmallStep> kernel(HWY_DYNAMIC_DISPATCH(make)(work.group_class, blocks.reads(0), work.lanes));
  return kernel != nullptr ? std::move(kernel) : make_interpreted_step(work, blocks);
}

}  // namespace assur
#endif
