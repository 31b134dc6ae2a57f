// Compiled once for each instruction set: see hwy/foreach_target.h.
#include "backends/lanes_kernels.hpp"

#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "backends/lanes_kernels.cpp"
#include <hwy/foreach_target.h>

#include "fused-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::lanes {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using assur::HWY_NAMESPACE::fused;
using assur::HWY_NAMESPACE::fused_negated;
using Number = Elimination::Number;

// kVectors vectors: all lanes of a slot, or some of them if vectors are short.
template <class T, int kLanes>
struct SlotVectors {
  using D = hn::CappedTag<T, kLanes>;
  using V = hn::Vec<D>;
  static constexpr int kWidth = static_cast<int>(hn::MaxLanes(D()));
  static constexpr int kVectors = kLanes / kWidth < 4 ? kLanes / kWidth : 4;
  static constexpr int kPart = kVectors * kWidth;
  static constexpr std::size_t kStride = kLanes;

  V v[kVectors];

  static HWY_INLINE SlotVectors load(const T* from) {
    SlotVectors r;
    for (int i = 0; i < kVectors; ++i) r.v[i] = hn::Load(D(), from + i * kWidth);
    return r;
  }
  HWY_INLINE void store(T* to) const {
    for (int i = 0; i < kVectors; ++i) hn::Store(v[i], D(), to + i * kWidth);
  }
  static HWY_INLINE SlotVectors set(T value) {
    SlotVectors r;
    for (int i = 0; i < kVectors; ++i) r.v[i] = hn::Set(D(), value);
    return r;
  }
};

template <class D>
HWY_INLINE hn::Vec<D> take_vector(D d, const double* from) {
  if constexpr (sizeof(hn::TFromD<D>) == sizeof(double)) {
    return hn::LoadU(d, from);
  } else {
    constexpr std::size_t kWidth = hn::MaxLanes(D());
    const hn::CappedTag<double, kWidth> wide;
    if constexpr (hn::MaxLanes(decltype(wide)()) == kWidth) {
      return hn::DemoteTo(d, hn::LoadU(wide, from));
    } else {
      const hn::Half<D> half;
      return Combine(d, hn::DemoteTo(half, hn::LoadU(wide, from + kWidth / 2)),
                     hn::DemoteTo(half, hn::LoadU(wide, from)));
    }
  }
}

template <class D, class V>
HWY_INLINE void give_vector(D d, V v, double* to) {
  if constexpr (sizeof(hn::TFromD<D>) == sizeof(double)) {
    hn::StoreU(v, d, to);
  } else {
    constexpr std::size_t kWidth = hn::MaxLanes(D());
    const hn::CappedTag<double, kWidth> wide;
    if constexpr (hn::MaxLanes(decltype(wide)()) == kWidth) {
      hn::StoreU(hn::PromoteTo(wide, v), wide, to);
    } else {
      const hn::Half<D> half;
      hn::StoreU(hn::PromoteTo(wide, hn::LowerHalf(half, v)), wide, to);
      hn::StoreU(hn::PromoteTo(wide, UpperHalf(half, v)), wide, to + kWidth / 2);
    }
  }
}

// Loads and stores numbers of the caller, which may have any alignment.
template <class L>
HWY_INLINE L take(const double* from) {
  L r;
  for (int i = 0; i < L::kVectors; ++i) r.v[i] = take_vector(typename L::D(), from + i * L::kWidth);
  return r;
}
template <class L>
HWY_INLINE void give(const L& l, double* to) {
  for (int i = 0; i < L::kVectors; ++i) give_vector(typename L::D(), l.v[i], to + i * L::kWidth);
}

template <class L>
HWY_INLINE L times(const L& a, const L& b) {
  L r;
  for (int i = 0; i < L::kVectors; ++i) r.v[i] = hn::Mul(a.v[i], b.v[i]);
  return r;
}
// c - a b
template <class L>
HWY_INLINE L minus_product(const L& a, const L& b, const L& c) {
  L r;
  for (int i = 0; i < L::kVectors; ++i) r.v[i] = fused_negated(typename L::D(), a.v[i], b.v[i], c.v[i]);
  return r;
}
template <class L>
HWY_INLINE L reciprocal(const L& a) {
  L r;
  for (int i = 0; i < L::kVectors; ++i) {
    r.v[i] = hn::Div(hn::Set(typename L::D(), 1), a.v[i]);
  }
  return r;
}
template <class L>
HWY_INLINE L add_square(const L& sum, const L& a) {
  L r;
  for (int i = 0; i < L::kVectors; ++i) r.v[i] = fused(typename L::D(), a.v[i], a.v[i], sum.v[i]);
  return r;
}

// The next entry of a row: its value in A minus its products.
template <class L, class T>
HWY_INLINE L entry(const Number*& op, const double* values, const T* slots, L& square_of_a) {
  L a;
  if (*op != Elimination::kZero) {
    a = take<L>(values + *op * L::kStride);
    square_of_a = add_square(square_of_a, a);
  } else {
    a = L::set(0);
  }
  Number products = op[1];
  op += 2;
  for (; products != 0; --products, op += 2) {
    a = minus_product(L::load(slots + op[0] * L::kStride), L::load(slots + op[1] * L::kStride), a);
  }
  return a;
}

template <class L, class T>
HWY_INLINE Alarms factorize_part(const Elimination& p, const double* values, T* slots, const Limits& limits) {
  constexpr typename L::D d;
  const auto square = [](double x) { return static_cast<T>(x * x); };
  const auto shrink = hn::Set(d, square(1 / limits.growth)), pivot = hn::Set(d, square(limits.pivot)),
             smallest = hn::Set(d, square(limits.smallest));
  L largest_u = L::set(1);
  hn::Mask<typename L::D> grown[L::kVectors], small[L::kVectors];
  for (int i = 0; i < L::kVectors; ++i) grown[i] = small[i] = hn::FirstN(d, 0);

  const Number* op = p.factor.data();
  T *l = slots, *row_square = slots + p.square_slot * L::kStride;
  for (Number row = 0; row < p.n; ++row, row_square += L::kStride) {
    Number left = op[0], right = op[1];
    T* u = slots + op[2] * L::kStride;
    op += 3;
    L of_a = L::set(0), of_l = L::set(0), of_u = L::set(0);  // squares
    for (; left != 0; --left, l += L::kStride) {
      const L e = entry<L>(op, values, slots, of_a);
      e.store(l);
      of_l = add_square(of_l, e);
    }
    const L diagonal = entry<L>(op, values, slots, of_a), r = reciprocal(diagonal);
    r.store(l);
    l += L::kStride;
    for (; right != 0; --right, u += L::kStride) {
      const L e = entry<L>(op, values, slots, of_a);
      times(e, r).store(u);
      of_u = add_square(of_u, e);
    }
    of_a.store(row_square);
    for (int i = 0; i < L::kVectors; ++i) {
      const auto of_d = hn::Mul(diagonal.v[i], diagonal.v[i]), of_row = hn::Add(hn::Add(of_l.v[i], of_d), of_u.v[i]);
      // Strict comparisons are false for NaN, so infinities and zero rows raise alarms.
      grown[i] = hn::Or(grown[i], hn::Not(hn::Lt(hn::Mul(hn::Mul(of_row, shrink), largest_u.v[i]), of_a.v[i])));
      small[i] = hn::Or(small[i], hn::Not(hn::Ge(of_d, fused(typename L::D(), of_a.v[i], pivot, smallest))));
      largest_u.v[i] = hn::Max(largest_u.v[i], hn::Mul(hn::Mul(of_u.v[i], r.v[i]), r.v[i]));
    }
  }
  Alarms alarms;
  const auto bits = [&](const auto& mask) HWY_ATTR {
    std::uint8_t byte[8] = {};
    hn::StoreMaskBits(d, mask, byte);
    return static_cast<std::uint32_t>(byte[0] | byte[1] << 8) & ((1u << L::kWidth) - 1);
  };
  for (int i = 0; i < L::kVectors; ++i) {
    alarms.growth |= bits(grown[i]) << (i * L::kWidth);
    alarms.pivot |= bits(small[i]) << (i * L::kWidth);
  }
  return alarms;
}

template <class T, int kLanes>
HWY_ATTR Alarms factorize(const Elimination& p, const double* values, void* slots, const Limits& limits) {
  using L = SlotVectors<T, kLanes>;
  Alarms all;
  for (int part = 0; part < kLanes; part += L::kPart) {
    const Alarms some = factorize_part<L>(p, values + part, static_cast<T*>(slots) + part, limits);
    all.growth |= some.growth << part;
    all.pivot |= some.pivot << part;
  }
  return all;
}

template <class L, std::size_t kRhs, class T>
HWY_INLINE void solve_part(const Elimination& p, const T* slots, double* b_to_x, Number rows, T* work) {
  const std::size_t next_rhs = p.n * L::kStride;
  const T* factor = slots;
  {
    const Number* op = p.forward.data();
    T* y = work;
    for (Number row = 0; row < p.n; ++row, y += L::kStride) {
      L sum[kRhs];
      const double* b = b_to_x + op[0] * L::kStride;
      for (std::size_t r = 0; r < kRhs; ++r) sum[r] = take<L>(b + r * next_rhs);
      Number left = op[1];
      op += 2;
      for (; left != 0; --left, ++op, factor += L::kStride) {
        const L l = L::load(factor);
        for (std::size_t r = 0; r < kRhs; ++r) {
          sum[r] = minus_product(l, L::load(work + r * next_rhs + *op * L::kStride), sum[r]);
        }
      }
      const L pivot = L::load(factor);
      factor += L::kStride;
      for (std::size_t r = 0; r < kRhs; ++r) times(sum[r], pivot).store(y + r * next_rhs);
    }
  }
  const Number* op = p.backward.data();
  for (; rows != 0; --rows) {
    L sum[kRhs];
    T* y = work + op[0] * L::kStride;
    double* x = b_to_x + op[1] * L::kStride;
    for (std::size_t r = 0; r < kRhs; ++r) sum[r] = L::load(y + r * next_rhs);
    Number right = op[2];
    op += 3;
    for (; right != 0; --right, ++op, factor += L::kStride) {
      const L u = L::load(factor);
      for (std::size_t r = 0; r < kRhs; ++r) {
        sum[r] = minus_product(u, L::load(work + r * next_rhs + *op * L::kStride), sum[r]);
      }
    }
    for (std::size_t r = 0; r < kRhs; ++r) {
      sum[r].store(y + r * next_rhs);
      give(sum[r], x + r * next_rhs);
    }
  }
}

template <class T, int kLanes>
HWY_ATTR void solve(const Elimination& p, const void* slots, double* b_to_x, int rhs, int first_wanted, void* work) {
  using L = SlotVectors<T, kLanes>;
  const Number rows = p.wanted_rows[static_cast<std::size_t>(first_wanted)];
  for (; rhs > 0; rhs -= kRightSides, b_to_x += kRightSides * p.n * L::kStride) {
    for (int part = 0; part < kLanes; part += L::kPart) {
      const T* factors = static_cast<const T*>(slots) + part;
      T* own = static_cast<T*>(work) + part;
      switch (rhs) {
        case 1:
          solve_part<L, 1>(p, factors, b_to_x + part, rows, own);
          break;
        case 2:
          solve_part<L, 2>(p, factors, b_to_x + part, rows, own);
          break;
        case 3:
          solve_part<L, 3>(p, factors, b_to_x + part, rows, own);
          break;
        default:
          solve_part<L, kRightSides>(p, factors, b_to_x + part, rows, own);
          break;
      }
    }
  }
}

// A' = Q U' L' P. Both factors are used by columns, which are rows of U and of L.
template <class L, class T>
HWY_INLINE void solve_transposed_part(const Elimination& p, const T* slots, double* b_to_x, T* work) {
  const auto subtract = [&](const Number*& op, Number count, const L& x, const T*& factor) HWY_ATTR {
    for (; count != 0; --count, ++op, factor += L::kStride) {
      T* to = work + *op * L::kStride;
      minus_product(L::load(factor), x, L::load(to)).store(to);
    }
  };
  for (const Number* op = p.backward.data(); op != p.backward.data() + p.backward.size(); op += 3 + op[2]) {
    take<L>(b_to_x + op[1] * L::kStride).store(work + op[0] * L::kStride);
  }
  for (Number row = 0; row < p.n; ++row) {
    const Number* op = p.backward.data() + p.backward_row[row];
    const T* factor = slots + p.upper_slot[row] * L::kStride;
    const Number count = op[2];
    op += 3;
    subtract(op, count, L::load(work + row * L::kStride), factor);
  }
  for (Number row = p.n; row-- > 0;) {
    const Number* op = p.forward.data() + p.forward_row[row];
    const Number count = op[1];
    double* x = b_to_x + op[0] * L::kStride;
    const T* pivot = slots + p.pivot_slot[row] * L::kStride;
    const T* factor = pivot - count * L::kStride;
    op += 2;
    const L y = times(L::load(work + row * L::kStride), L::load(pivot));
    give(y, x);
    subtract(op, count, y, factor);
  }
}

template <class T, int kLanes>
HWY_ATTR void solve_transposed(const Elimination& p, const void* slots, double* b_to_x, int rhs, void* work) {
  using L = SlotVectors<T, kLanes>;
  for (; rhs > 0; --rhs, b_to_x += p.n * L::kStride) {
    for (int part = 0; part < kLanes; part += L::kPart) {
      solve_transposed_part<L>(p, static_cast<const T*>(slots) + part, b_to_x + part, static_cast<T*>(work) + part);
    }
  }
}

template <class T>
Kernels of_lanes(int lanes) {
  switch (lanes) {
    case 1:
      return {factorize<T, 1>, solve<T, 1>, solve_transposed<T, 1>};
    case 2:
      return {factorize<T, 2>, solve<T, 2>, solve_transposed<T, 2>};
    case 4:
      return {factorize<T, 4>, solve<T, 4>, solve_transposed<T, 4>};
    case 8:
      return {factorize<T, 8>, solve<T, 8>, solve_transposed<T, 8>};
    default:
      return {factorize<T, 16>, solve<T, 16>, solve_transposed<T, 16>};
  }
}

}  // namespace

Kernels select(int lanes, Precision precision) {
  return precision == Precision::binary64 ? of_lanes<double>(lanes) : of_lanes<float>(lanes);
}
const char* target_name() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace assur::lanes
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace assur::lanes {

HWY_EXPORT(select);
HWY_EXPORT(target_name);

Kernels kernels(int lanes, Precision precision) { return HWY_DYNAMIC_DISPATCH(select)(lanes, precision); }
const char* instruction_set() { return HWY_DYNAMIC_DISPATCH(target_name)(); }

}  // namespace assur::lanes
#endif
