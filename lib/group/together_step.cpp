// Compiled once for each SIMD target; make_together_step() chooses the target.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "group/together_step.cpp"
#include <hwy/foreach_target.h>  // must precede the code compiled for each target

#include "equations/lane_vector-inl.hpp"
#include "program/together_group-inl.hpp"

#include <array>
#include <utility>

#include "group/together_step.hpp"
#include "index.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {
namespace {

using L = Lanes<kTogetherLanes>;

// Groups side by side, from one on.
class LaneIo {
 public:
  LaneIo(const double* const* memory, std::size_t stride, std::size_t first)
      : memory_(memory), stride_(stride), first_(first) {}

  HWY_INLINE L load(Memory memory, std::size_t i) const { return L::load(at(memory, i)); }
  HWY_INLINE void store(Memory memory, std::size_t i, const L& value) const {
    value.store(const_cast<double*>(at(memory, i)));
  }
  HWY_INLINE L coefficient(std::int32_t k) const { return load(Memory::coefficients, idx(k)); }
  HWY_INLINE L input(int derivative, std::int32_t i) const {
    return load(static_cast<Memory>(static_cast<int>(Memory::inputs) + derivative), idx(i));
  }
  HWY_INLINE L anchor(std::size_t k) const { return load(Memory::anchor, k); }
  HWY_INLINE L omega() const { return load(Memory::omega, 0); }
  HWY_INLINE L ball_used() const { return load(Memory::ball_used, 0); }
  HWY_INLINE L setting(GroupSetting s) const {
    return L::set(memory_[static_cast<std::size_t>(Memory::settings)][static_cast<std::size_t>(s)]);
  }

 private:
  HWY_INLINE const double* at(Memory memory, std::size_t i) const {
    return memory_[static_cast<std::size_t>(memory)] + i * stride_ + first_;
  }

  const double* const* memory_;
  std::size_t stride_, first_;
};

template <class Group>
class TogetherKernel final : public TogetherStep {
 public:
  TogetherKernel(const TogetherClass& of, const TogetherShape& shape, const Separable& separable)
      : shape_(shape), group_(of.reads, of.slopes, of.group_class, separable) {}

  void run(TogetherPass pass, std::span<double* const> memory) override {
    for (std::size_t first = 0; first < idx(shape_.lanes_of(pass)); first += kTogetherLanes) {
      LaneIo io(memory.data(), shape_.stride, first);
      group_.run(pass, io);
    }
  }

 private:
  TogetherShape shape_;
  Group group_;
};

#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_EMU128
// why_not_together() refuses the strategy on processors without SIMD.
TogetherStep* make(const TogetherClass&, const TogetherShape&) { return nullptr; }
#else
TogetherStep* make(const TogetherClass& of, const TogetherShape& shape) {
  const auto make = [&]<class Group>(std::type_identity<Group>, const Separable& separable) -> TogetherStep* {
    return new TogetherKernel<Group>(of, shape, separable);
  };
  return of.group_class.n == 2 ? with_together_group<L, 2>(of.group_class, make)
                               : with_together_group<L, 3>(of.group_class, make);
}
#endif

}  // namespace
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace assur {

HWY_EXPORT(make);

namespace {

class CodedTogetherStep final : public TogetherStep {
 public:
  explicit CodedTogetherStep(std::array<std::shared_ptr<const Executor>, kTogetherPasses> passes)
      : passes_(std::move(passes)) {}

  void run(TogetherPass pass, std::span<double* const> memory) override {
    passes_[static_cast<std::size_t>(pass)]->run(memory);
  }

 private:
  std::array<std::shared_ptr<const Executor>, kTogetherPasses> passes_;
};

}  // namespace

std::unique_ptr<TogetherStep> make_together_step(const TogetherClass& of, const TogetherShape& shape) {
  return std::unique_ptr<TogetherStep>(HWY_DYNAMIC_DISPATCH(make)(of, shape));
}

std::unique_ptr<TogetherStep> make_coded_together_step(const TogetherClass& of, const TogetherShape& shape,
                                                       StepCode& code) {
  std::array<std::shared_ptr<const Executor>, kTogetherPasses> passes;
  for (std::size_t k = 0; k < kTogetherPasses; ++k) {
    const auto pass = static_cast<TogetherPass>(k);
    passes[k] = code.of(together_program(pass, of.group_class, of.reads, of.slopes, shape), shape.lanes_of(pass));
    if (!passes[k]) return nullptr;
  }
  return std::make_unique<CodedTogetherStep>(std::move(passes));
}

}  // namespace assur
#endif
