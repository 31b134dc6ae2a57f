// Compiled once for each SIMD target; coupling_kernels() chooses the target.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "group/coupling.cpp"
#include <hwy/foreach_target.h>  // must precede the code compiled for each target

#include "equations/gather-inl.hpp"

#include <algorithm>

#include "group/coupling.hpp"
#include "index.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {
namespace {

constexpr int kLanes = 8;
using L = Lanes<kLanes>;

void gather(std::span<const Run> runs, const double* from, double* to) {
  for (const Run& r : runs) {
    const double* const begin = from + r.from;
    double* const out = to + r.to;
    std::int32_t i = 0;
    if (r.step == 1) {
      for (; i + kLanes <= r.count; i += kLanes) L::load(begin + i).store(out + i);
    } else if (r.step == 2) {
      for (; i + kLanes < r.count; i += kLanes) load_every_second<kLanes>(begin + 2 * i).store(out + i);
    } else if (r.step == 3) {
      for (; i + kLanes < r.count; i += kLanes) load_every_third<kLanes>(begin + 3 * i).store(out + i);
    }
    for (; i < r.count; ++i) out[i] = begin[i * r.step];
  }
}
void scatter(std::span<const Run> runs, double* from, const double* to) {
  for (const Run& r : runs) {
    double* const begin = from + r.from;
    const double* const out = to + r.to;
    for (std::int32_t i = 0; i < r.count; ++i) begin[i * r.step] = out[i];
  }
}

void couple(std::span<const Slopes::Entry> entries, std::size_t first_entry, const double* slopes,
            const double* sources, std::size_t stride, std::size_t lanes, double* sums) {
  slopes += first_entry * stride;
  for (std::size_t l = 0; l < lanes; l += kLanes) {
    L sum = L::set(0);
    const double* slope = slopes + l;
    for (const Slopes::Entry& e : entries) {
      sum.subtract_product(L::load(slope), L::load(sources + idx(e.input) * stride + l));
      slope += stride;
    }
    sum.store(sums + l);
  }
}
void complete(const double* own, const double* const* columns, const double* loads, std::size_t n, std::size_t rows,
              std::size_t stride, std::size_t lanes, double* to) {
  for (std::size_t l = 0; l < lanes; l += kLanes) {
    for (std::size_t j = 0; j < n; ++j) {
      L sum = L::load(own + j * stride + l);
      for (std::size_t k = 0; k < rows; ++k) {
        sum.add_product(L::load(columns[k] + j * stride + l), L::load(loads + k * stride + l));
      }
      sum.store(to + j * stride + l);
    }
  }
}
void add(const double* by, std::size_t n, std::size_t stride, std::size_t lanes, double* to) {
  for (std::size_t j = 0; j < n; ++j, by += stride, to += stride) {
    for (std::size_t l = 0; l < lanes; l += kLanes) (L::load(to + l) + L::load(by + l)).store(to + l);
  }
}
double largest(const double* of, std::size_t lanes) {
  L all = L::load(of);
  for (std::size_t l = kLanes; l < lanes; l += kLanes) all = max(all, L::load(of + l));
  return all.largest();
}

// The number `by` lanes before each lane; fill: before the first lanes.
template <int by>
HWY_INLINE L before_lanes(const L& a, double fill) {
  const L::D d;
  const auto none = hn::Set(d, fill);
  L out;
  if constexpr (by >= L::kEach) {
    for (int i = 0; i < L::kVectors; ++i) out.v[i] = i * L::kEach >= by ? a.v[i - by / L::kEach] : none;
  } else {
    alignas(kLineBytes) std::int64_t turned[L::kEach];
    for (int l = 0; l < L::kEach; ++l) turned[l] = (l + L::kEach - by) % L::kEach;
    const auto from = hn::SetTableIndices(d, turned);
    const auto first = hn::FirstN(d, by);
    auto last = none;
    for (int i = 0; i < L::kVectors; ++i) {
      const auto here = hn::TableLookupLanes(a.v[i], from);
      out.v[i] = hn::IfThenElse(first, last, here);
      last = here;
    }
  }
  return out;
}
template <int by>
HWY_INLINE void combine(L& gain, L& load) {
  load.add_product(gain, before_lanes<by>(load, 0));
  gain = gain * before_lanes<by>(gain, 1);
}
// Eight loads at a time: each is combined with the loads 1, 2 and 4 rows before it, so that gains are multiplied over
// eight rows only. The last load is carried to the next eight.
void chain(const double* gains, double before, std::int32_t count, double* loads) {
  std::int32_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    L gain = L::load(gains + i), load = L::load(loads + i);
    combine<1>(gain, load);
    combine<2>(gain, load);
    combine<4>(gain, load);
    load.add_product(gain, L::set(before));
    load.store(loads + i);
    before = loads[i + kLanes - 1];
  }
  for (; i < count; ++i) {
    Lanes<1> next = Lanes<1>::load(loads + i);
    next.add_product(Lanes<1>::load(gains + i), Lanes<1>::set(before));
    next.store(loads + i);
    before = loads[i];
  }
}

const CouplingKernels* kernels() {
  static constexpr CouplingKernels kAll{gather, scatter, couple, complete, add, largest, chain};
  return &kAll;
}

}  // namespace
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace assur {

HWY_EXPORT(kernels);

const CouplingKernels& coupling_kernels() { return *HWY_DYNAMIC_DISPATCH(kernels)(); }

}  // namespace assur
#endif
