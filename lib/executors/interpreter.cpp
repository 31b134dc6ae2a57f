// Compiled once for each SIMD target; make_interpreter() chooses the target.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "executors/interpreter.cpp"
#include <hwy/foreach_target.h>  // must precede the code compiled for each target

#include "fused-inl.hpp"

#include "executors/executor.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "evaluation/lane_array.hpp"
#include "executors/places.hpp"
#include "index.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {
namespace {

template <int W>
class Interpreter final : public Executor {
  using D = hn::CappedTag<double, W>;
  using V = hn::Vec<D>;

 public:
  // lanes: a multiple of W
  Interpreter(const StepProgram& program, std::size_t lanes) : addresses_(program.addresses), lanes_(lanes) {
    std::size_t places = 0;
    for (const Phase& p : program.phases) {
      phases_.push_back(translate(p));
      places = std::max(places, phases_.back().places);
    }
    values_.assign(places * W, 0.0);
  }

  void run(std::span<double* const> memory) const override {
    for (Listing& p : phases_) {
      for (std::size_t first = 0; first < lanes_; first += W) {
        const From from{memory, values_.data(), p.constants.data(), first};
        if (!p.repeat_while) {
          run(p, from);
          continue;
        }
        while (is_positive(from.at(*p.repeat_while))) run(p, from);
      }
    }
  }

 private:
  // Where operands are: memories, values of the phase, and constants.
  enum : std::uint32_t { kConstants = UINT32_MAX - 1, kValues };
  struct Operand {
    std::uint32_t source = kValues;
    std::uint32_t offset = 0;
  };
  struct From {
    std::span<double* const> memory;
    double *values, *constants;
    std::size_t first;  // lane

    [[nodiscard]] double* at(const Operand& o) const {
      return (o.source == kValues ? values : o.source == kConstants ? constants : memory[o.source] + first) + o.offset;
    }
    [[nodiscard]] double* one(const Operand& o) const { return memory[o.source] + o.offset; }
  };
  // Loads and stores: reach of the source or the destination that is no row.
  struct Operation {
    Op op;
    Operand operand[4];
    Operand to;
    Reach reach = Reach::row;
  };
  // A phase whose constants, and loads of neighbours, are operands.
  struct Listing {
    std::vector<Operation> operations;
    std::size_t stores_begin = 0;  // among the operations
    LaneArray constants;
    std::size_t places = 0;
    std::optional<Operand> repeat_while;
  };

  // of a scattered slot: where its addresses begin
  [[nodiscard]] Operand of(Slot s) const {
    const auto lanes = static_cast<std::uint32_t>(lanes_);
    return {static_cast<std::uint32_t>(memory_of(s)), s.reach == Reach::row ? s.index * lanes : s.index};
  }
  static bool are_neighbours(Slot s) { return s.reach == Reach::row || s.reach == Reach::from; }

  [[nodiscard]] Listing translate(const Phase& phase) const {
    const Places places = places_of(phase);
    Listing out{{}, 0, LaneArray(phase.constants.size() * W), places.count, {}};
    for (std::size_t i = 0; i < phase.constants.size(); ++i)
      std::fill_n(out.constants.data() + i * W, W, phase.constants[i]);
    if (phase.repeat_while) out.repeat_while = of(*phase.repeat_while);
    std::vector<Operand> value;
    for (std::size_t i = 0; i < phase.code.size(); ++i) {
      const Instruction& n = phase.code[i];
      const auto place = static_cast<std::uint32_t>(places.of[i] * W);
      if (n.op == Op::load && are_neighbours(n.slot)) {
        value.push_back(of(n.slot));
      } else if (n.op == Op::constant) {
        value.push_back({kConstants, n.operand[0] * W});
      } else {
        value.push_back({kValues, place});
        Operation& to = out.operations.emplace_back(Operation{n.op, {}, value.back()});
        if (n.op == Op::load) {
          to.operand[0] = of(n.slot);
          to.reach = n.slot.reach;
        }
        if (n.op == Op::pick) to.operand[1] = of(n.slot);
        for (std::size_t k = 0; k < static_cast<std::size_t>(operands_of(n.op)); ++k)
          to.operand[k] = value[n.operand[k]];
      }
    }
    // A number that is stored as it was loaded is read before the first store.
    std::vector<Operation> stores;
    for (const Phase::Store& s : phase.stores) {
      const Instruction& n = phase.code[s.value];
      const bool is_loaded = n.op == Op::load && are_neighbours(n.slot);
      const Operand kept{kValues, static_cast<std::uint32_t>(places.of[s.value] * W)};
      if (is_loaded) out.operations.push_back({Op::load, {value[s.value]}, kept});
      const Reach reach = s.to.reach == Reach::from ? Reach::row : s.to.reach;
      stores.push_back({Op::load, {is_loaded ? kept : value[s.value]}, of(s.to), reach});
    }
    out.stores_begin = out.operations.size();
    out.operations.insert(out.operations.end(), stores.begin(), stores.end());
    return out;
  }

  static bool is_positive(const double* slot) {
    return std::any_of(slot, slot + W, [](double x) { return x > 0; });
  }

  // A number for all lanes, or one for each.
  void load(const Operation& n, const From& from) const {
    double* const to = from.at(n.to);
    if (n.reach == Reach::one) {
      std::fill_n(to, W, *from.one(n.operand[0]));
      return;
    }
    const std::int32_t* const address = addresses_.data() + n.operand[0].offset + from.first;
    for (int l = 0; l < W; ++l) to[l] = from.memory[n.operand[0].source][address[l]];
  }
  void run(const Listing& listing, const From& from) const {
    const D d;
    for (const Operation& n : listing.operations) {
      if (n.reach != Reach::row) {
        if (&n < listing.operations.data() + listing.stores_begin) {
          load(n, from);
        } else if (from.first == 0) {  // of the first lane
          *from.one(n.to) = *from.at(n.operand[0]);
        }
        continue;
      }
      const auto at = [&](const Operand& o) { return from.at(o); };
      double* const to = at(n.to);
      const double *const a = at(n.operand[0]), *const b = at(n.operand[1]);
      const auto each = [&](const auto& result) HWY_ATTR {
        for (std::size_t l = 0; l < W; l += hn::MaxLanes(D())) hn::StoreU(result(l), d, to + l);
      };
      const auto v = [&](const double* x, std::size_t l) HWY_ATTR { return hn::LoadU(d, x + l); };
      switch (n.op) {
        case Op::load:
        case Op::constant:
          each([&](std::size_t l) HWY_ATTR { return v(a, l); });
          break;
        case Op::pick:
          for (int l = 0; l < W; ++l) to[l] = from.one(n.operand[1])[static_cast<std::ptrdiff_t>(a[l])];
          break;
        case Op::add:
          each([&](std::size_t l) HWY_ATTR { return hn::Add(v(a, l), v(b, l)); });
          break;
        case Op::subtract:
          each([&](std::size_t l) HWY_ATTR { return hn::Sub(v(a, l), v(b, l)); });
          break;
        case Op::multiply:
          each([&](std::size_t l) HWY_ATTR { return hn::Mul(v(a, l), v(b, l)); });
          break;
        case Op::divide:
          each([&](std::size_t l) HWY_ATTR { return hn::Div(v(a, l), v(b, l)); });
          break;
        case Op::fma: {
          const double* const c = at(n.operand[2]);
          each([&](std::size_t l) HWY_ATTR { return fused(d, v(a, l), v(b, l), v(c, l)); });
          break;
        }
        case Op::fnma: {
          const double* const c = at(n.operand[2]);
          each([&](std::size_t l) HWY_ATTR { return fused_negated(d, v(a, l), v(b, l), v(c, l)); });
          break;
        }
        case Op::square_root:
          each([&](std::size_t l) HWY_ATTR { return hn::Sqrt(v(a, l)); });
          break;
        case Op::absolute:
          each([&](std::size_t l) HWY_ATTR { return hn::Abs(v(a, l)); });
          break;
        case Op::copy_sign:
          each([&](std::size_t l) HWY_ATTR { return hn::CopySign(v(a, l), v(b, l)); });
          break;
        case Op::round:
          // Without vectors, Highway rounds -0.25 to 0.
          each([&](std::size_t l) HWY_ATTR { return hn::CopySign(hn::Round(v(a, l)), v(a, l)); });
          break;
        case Op::larger:
          each([&](std::size_t l) HWY_ATTR { return hn::IfThenElse(hn::Gt(v(a, l), v(b, l)), v(a, l), v(b, l)); });
          break;
        case Op::select: {
          const double *const yes = at(n.operand[2]), *const no = at(n.operand[3]);
          each([&](std::size_t l) HWY_ATTR { return hn::IfThenElse(hn::Le(v(a, l), v(b, l)), v(yes, l), v(no, l)); });
          break;
        }
      }
    }
  }

  std::vector<std::int32_t> addresses_;
  std::size_t lanes_;
  mutable std::vector<Listing> phases_;
  mutable LaneArray values_;  // of the run at hand
};

Executor* make(const StepProgram& program, int lanes) {
  const auto all = static_cast<std::size_t>(lanes);
  switch (lanes) {
    case 1:
      return new Interpreter<1>(program, all);
    case 2:
      return new Interpreter<2>(program, all);
    case 4:
      return new Interpreter<4>(program, all);
    case 16:
      return new Interpreter<16>(program, all);
    default:
      return lanes > 0 && lanes % 8 == 0 ? new Interpreter<8>(program, all) : nullptr;
  }
}

}  // namespace
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace assur {

HWY_EXPORT(make);

namespace {

// Phases of different widths.
class Interpreters final : public Executor {
 public:
  explicit Interpreters(std::vector<std::unique_ptr<Executor>> parts) : parts_(std::move(parts)) {}
  void run(std::span<double* const> memory) const override {
    for (const auto& part : parts_) part->run(memory);
  }

 private:
  std::vector<std::unique_ptr<Executor>> parts_;
};

}  // namespace

std::unique_ptr<Executor> make_interpreter(const StepProgram& program, int lanes) {
  std::vector<std::unique_ptr<Executor>> parts;
  const auto width = [&](const Phase& p) { return p.lanes > 0 ? p.lanes : lanes; };
  for (auto begin = program.phases.begin(), end = begin; begin != program.phases.end(); begin = end) {
    end = std::find_if(begin, program.phases.end(), [&](const Phase& p) { return width(p) != width(*begin); });
    const bool is_known = std::all_of(begin, end, [](const Phase& p) {
      return std::none_of(p.code.begin(), p.code.end(), [](const Instruction& n) { return n.op > kLastOp; });
    });
    if (!is_known) return nullptr;
    const StepProgram part{{begin, end}, program.addresses};
    parts.emplace_back(HWY_DYNAMIC_DISPATCH(make)(part, width(*begin)));
    if (!parts.back()) throw std::invalid_argument("lanes must be 1, 2, 4, or a multiple of 8");
  }
  return std::make_unique<Interpreters>(std::move(parts));
}

}  // namespace assur
#endif
