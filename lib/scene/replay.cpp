// Compiled once for each SIMD target.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scene/replay.cpp"
#include <hwy/foreach_target.h>  // must precede the code compiled for each target
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <set>
#include <tuple>

#include "index.hpp"
#include "scene/replay.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {
namespace {

template <std::size_t kLanes>
void compute(std::span<const ReplayStep> steps, std::size_t from, std::size_t to,
             std::span<const double* const> parameters, double* numbers) {
  using Kind = Tape::Kind;
  for (std::size_t i = from; i < to; ++i) {
    const ReplayStep s = steps[i];
    double* const out = numbers + i * kLanes;
    if (s.kind == Kind::parameter) {
      for (std::size_t l = 0; l < kLanes; ++l) out[l] = parameters[l][s.a];
      continue;
    }
    const double *const a = numbers + s.a * kLanes, *const b = numbers + s.b * kLanes,
                        *const c = numbers + s.c * kLanes;
    switch (s.kind) {
      case Kind::add:
        for (std::size_t l = 0; l < kLanes; ++l) out[l] = a[l] + b[l];
        break;
      case Kind::subtract:
        for (std::size_t l = 0; l < kLanes; ++l) out[l] = a[l] - b[l];
        break;
      case Kind::multiply:
        for (std::size_t l = 0; l < kLanes; ++l) out[l] = a[l] * b[l];
        break;
      case Kind::divide:
        for (std::size_t l = 0; l < kLanes; ++l) out[l] = a[l] / b[l];
        break;
      case Kind::negate:
        for (std::size_t l = 0; l < kLanes; ++l) out[l] = -a[l];
        break;
      case Kind::fused:
        for (std::size_t l = 0; l < kLanes; ++l) out[l] = std::fma(a[l], b[l], c[l]);
        break;
      case Kind::root:
        for (std::size_t l = 0; l < kLanes; ++l) out[l] = std::sqrt(a[l]);
        break;
      case Kind::length:
        for (std::size_t l = 0; l < kLanes; ++l) out[l] = std::hypot(a[l], b[l], c[l]);
        break;
      case Kind::magnitude:
        for (std::size_t l = 0; l < kLanes; ++l) out[l] = std::abs(a[l]);
        break;
      case Kind::angle:
        for (std::size_t l = 0; l < kLanes; ++l) out[l] = std::atan2(a[l], b[l]);
        break;
      case Kind::parameter:
      case Kind::literal:
      case Kind::formula:
        break;
    }
  }
}

template <std::size_t kLanes>
void check(std::span<const Tape::Guard> guards, std::span<const std::uint32_t> wanted, const double* numbers,
           double* off) {
  for (std::size_t l = 0; l < kLanes; ++l) off[l] = 0;
  for (const Tape::Guard& g : guards) {
    const double *const a = numbers + idx(g.a) * kLanes, *const b = numbers + idx(g.b) * kLanes;
    for (std::size_t l = 0; l < kLanes; ++l) {
      const bool holds = g.is_less ? a[l] < b[l] : a[l] == b[l];
      off[l] += (holds == g.outcome ? 0 : 1) + 0 * a[l] + 0 * b[l];
    }
  }
  for (const std::uint32_t step : wanted) {
    for (std::size_t l = 0; l < kLanes; ++l) off[l] += 0 * numbers[step * kLanes + l];
  }
}

template <std::size_t kLanes>
constexpr ReplayKernels kKernels = {compute<kLanes>, check<kLanes>};

ReplayKernels kernels(std::size_t lanes) { return lanes == 4 ? kKernels<4> : lanes == 8 ? kKernels<8> : kKernels<16>; }

}  // namespace
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace assur {

HWY_EXPORT(kernels);

namespace {

using Kind = Tape::Kind;

// Calls use(node) for each number that an operation reads.
template <class Use>
void each_operand(const Tape& tape, const Tape::Operation& o, const Use& use) {
  if (o.kind == Kind::parameter || o.kind == Kind::literal) return;
  if (o.kind == Kind::formula) {
    for (const Tape::Node n : tape.formulas()[idx(o.b)].arguments) use(n);
    return;
  }
  for (const Tape::Node n : {o.a, o.b, o.c}) {
    if (n != Tape::kNone) use(n);
  }
}

}  // namespace

// Keeps what the wanted numbers and the guards need.
Replay::Replay(const Tape& tape, std::span<const Tape::Node> wanted, std::size_t lanes)
    : lanes_(std::clamp<std::size_t>(std::bit_ceil(lanes), 4, 16)),
      kernels_(HWY_DYNAMIC_DISPATCH(kernels)(lanes_)),
      parameters_(lanes_),
      off_(lanes_) {
  const auto operations = tape.operations();
  std::vector<std::uint8_t> needed(operations.size(), 0);
  for (const Tape::Node n : wanted) needed[idx(n)] = 1;
  for (const Tape::Guard& g : tape.guards()) needed[idx(g.a)] = needed[idx(g.b)] = 1;
  for (std::size_t i = operations.size(); i-- > 0;) {
    if (needed[i] != 0) each_operand(tape, operations[i], [&](Tape::Node n) { needed[idx(n)] = 1; });
  }
  std::vector<std::uint32_t> step_of(operations.size(), 0);
  const auto step = [&](Tape::Node n) { return n < 0 ? 0 : step_of[idx(n)]; };
  for (std::size_t i = 0; i < operations.size(); ++i) {
    if (needed[i] == 0) continue;
    const Tape::Operation& o = operations[i];
    step_of[i] = static_cast<std::uint32_t>(steps_.size());
    ReplayStep s{o.kind, 0, 0, 0};
    if (o.kind == Kind::parameter) {
      s.a = static_cast<std::uint32_t>(o.a);
    } else if (o.kind == Kind::formula) {
      const Tape::Formula& f = tape.formulas()[idx(o.b)];
      s.b = static_cast<std::uint32_t>(formulas_.size());
      formulas_.emplace_back(f.text, f.names);
      auto& arguments = arguments_.emplace_back();
      for (const Tape::Node n : f.arguments) arguments.push_back(step(n));
    } else if (o.kind != Kind::literal) {
      s = {o.kind, step(o.a), step(o.b), step(o.c)};
    }
    if (o.kind == Kind::formula || o.kind == Kind::literal) formula_steps_.push_back(steps_.size());
    steps_.push_back(s);
    numbers_.resize(steps_.size() * lanes_);
    if (o.kind == Kind::literal)
      std::fill(numbers_.end() - std::ssize(off_), numbers_.end(), tape.literals()[idx(o.a)]);
  }
  for (const Tape::Node n : wanted) wanted_.push_back(step(n));
  std::set<std::tuple<Tape::Node, Tape::Node, bool>> known;
  for (Tape::Guard g : tape.guards()) {
    if (!known.emplace(g.a, g.b, g.is_less).second) continue;
    g.a = static_cast<Tape::Node>(step(g.a));
    g.b = static_cast<Tape::Node>(step(g.b));
    guards_.push_back(g);
  }
}

void Replay::run(std::span<const double* const> parameters) {
  // Idle lanes repeat the first one.
  for (std::size_t l = 0; l < lanes_; ++l) parameters_[l] = parameters[l < parameters.size() ? l : 0];
  std::size_t next = 0;
  for (const std::size_t i : formula_steps_) {
    kernels_.compute(steps_, next, i, parameters_, numbers_.data());
    if (steps_[i].kind == Kind::formula) evaluate_formula(steps_[i], &numbers_[i * lanes_], parameters.size());
    next = i + 1;
  }
  kernels_.compute(steps_, next, steps_.size(), parameters_, numbers_.data());
  kernels_.check(guards_, wanted_, numbers_.data(), off_.data());
}

void Replay::evaluate_formula(const ReplayStep& s, double* out, std::size_t used) {
  for (std::size_t l = 0; l < used; ++l) {
    arguments_at_hand_.clear();
    for (const std::uint32_t step : arguments_[s.b]) arguments_at_hand_.push_back(numbers_[step * lanes_ + l]);
    out[l] = formulas_[s.b](arguments_at_hand_);
  }
}

}  // namespace assur
#endif
