// Compiled once for each SIMD target; coupling_kernels() chooses the target.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "groups/coupling.cpp"
#include <hwy/foreach_target.h>  // must precede the code compiled for each target

#include "evaluation/lane_vector-inl.hpp"

#include <algorithm>
#include <utility>

#include "groups/coupling.hpp"
#include "index.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {
namespace {

constexpr int kLanes = 8;  // doubles of the widest vector
using L = Lanes<kLanes>;

void copy(std::span<const Run> runs, const double* from, double* to) {
  for (const Run& r : runs) {
    const double* const begin = from + r.from;
    double* const out = to + r.to;
    std::int32_t i = 0;
    for (; r.step == 1 && i + kLanes <= r.count; i += kLanes) L::load(begin + i).store(out + i);
    for (; i < r.count; ++i) out[i] = begin[i * r.step];
  }
}

// Replaces the lanes whose input is computed.
HWY_INLINE void take(const InputSources& sources, std::size_t input, std::size_t lane, const double* numbers, L& to) {
  const std::size_t at = input * sources.lanes + lane;
  const InputSources::Eight& eight = sources.eights[at / kLanes];
  if (HWY_LIKELY(eight.kind == InputSources::Kind::neighbours)) {
    to = L::load(numbers + eight.first);
  } else if (eight.kind == InputSources::Kind::some_neighbours) {
    to = if_positive(L::load(sources.computed.data() + at), L::load(numbers + eight.first), to);
  } else if (eight.kind == InputSources::Kind::apart) {
    HWY_ALIGN double each[kLanes];
    to.store(each);
    for (std::size_t k = 0; k < kLanes; ++k) {
      if (const std::int32_t address = sources.addresses[at + k]; address >= 0) each[k] = numbers[address];
    }
    to = L::load(each);
  }
}
void gather(const InputSources& sources, const double* numbers, std::size_t stride, double* to) {
  const std::size_t inputs = sources.addresses.size() / sources.lanes;
  for (std::size_t i = 0; i < inputs; ++i, to += stride) {
    for (std::size_t l = 0; l < sources.lanes; l += kLanes) {
      if (sources.eights[(i * sources.lanes + l) / kLanes].kind == InputSources::Kind::none) continue;
      L row = L::load(to + l);
      take(sources, i, l, numbers, row);
      row.store(to + l);
    }
  }
}

void part(const double* from, std::size_t n, std::size_t count, std::size_t stride, double* to) {
  constexpr L::D d;
  std::size_t i = 0;
  for (; (n == 2 || n == 3) && i + L::kEach <= count; i += L::kEach, from += n * L::kEach) {
    L::V a, b, c;
    if (n == 2) {
      hn::LoadInterleaved2(d, from, a, b);
    } else {
      hn::LoadInterleaved3(d, from, a, b, c);
      hn::StoreU(c, d, to + 2 * stride + i);
    }
    hn::StoreU(a, d, to + i);
    hn::StoreU(b, d, to + stride + i);
  }
  for (; i < count; ++i, from += n) {
    for (std::size_t j = 0; j < n; ++j) to[j * stride + i] = from[j];
  }
}
void join(const double* from, std::size_t n, std::size_t count, std::size_t stride, double* to) {
  constexpr L::D d;
  std::size_t i = 0;
  for (; (n == 2 || n == 3) && i + L::kEach <= count; i += L::kEach, to += n * L::kEach) {
    const auto a = hn::LoadU(d, from + i), b = hn::LoadU(d, from + stride + i);
    if (n == 2) {
      hn::StoreInterleaved2(a, b, d, to);
    } else {
      hn::StoreInterleaved3(a, b, hn::LoadU(d, from + 2 * stride + i), d, to);
    }
  }
  for (; i < count; ++i, to += n) {
    for (std::size_t j = 0; j < n; ++j) to[j] = from[j * stride + i];
  }
}

void couple(const InputSources& sources, std::span<const Couplings::Coupling> entries, const double* couplings,
            std::size_t stride, const double* numbers, double* sums) {
  for (std::size_t l = 0; l < sources.lanes; l += kLanes) {
    L sum = L::set(0);
    const double* coupling = couplings + l;
    for (const Couplings::Coupling& e : entries) {
      L number = L::set(0);
      take(sources, idx(e.input), l, numbers, number);
      sum.add_product(L::load(coupling), number);
      coupling += stride;
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
  const L::D d;
  alignas(kLineBytes) std::int64_t end[L::kEach];
  std::fill_n(end, L::kEach, L::kEach - 1);
  const auto last = hn::SetTableIndices(d, end);
  auto carried = hn::Set(d, before);
  std::int32_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    L gain = L::load(gains + i), load = L::load(loads + i);
    combine<1>(gain, load);
    combine<2>(gain, load);
    combine<4>(gain, load);
    for (int k = 0; k < L::kVectors; ++k) load.v[k] = fused(d, gain.v[k], carried, load.v[k]);
    carried = hn::TableLookupLanes(load.v[L::kVectors - 1], last);
    load.store(loads + i);
  }
  before = hn::GetLane(carried);
  for (; i < count; ++i) {
    Lanes<1> next = Lanes<1>::load(loads + i);
    next.add_product(Lanes<1>::load(gains + i), Lanes<1>::set(before));
    next.store(loads + i);
    before = loads[i];
  }
}

const CouplingKernels* kernels() {
  static constexpr CouplingKernels kAll{copy, gather, part, join, couple, complete, add, largest, chain};
  return &kAll;
}

}  // namespace
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace assur {

HWY_EXPORT(kernels);

InputSources::InputSources(std::vector<std::int32_t> of, std::size_t in_lanes)
    : lanes(in_lanes), addresses(std::move(of)) {
  constexpr std::size_t kEight = 8;
  for (std::size_t at = 0; at < addresses.size(); at += kEight) {
    const std::span eight = std::span(addresses).subspan(at, kEight);
    const auto found = std::find_if(eight.begin(), eight.end(), [](std::int32_t a) { return a != kNone; });
    Eight& to = eights.emplace_back();
    for (const std::int32_t a : eight) computed.push_back(a != kNone ? 1 : 0);
    if (found == eight.end()) continue;
    to.first = *found - static_cast<std::int32_t>(found - eight.begin());
    bool all = true, follow = true;
    for (std::size_t k = 0; k < kEight; ++k) {
      all = all && eight[k] != kNone;
      follow = follow && (eight[k] == kNone || eight[k] == to.first + static_cast<std::int32_t>(k));
    }
    to.kind = !follow ? Kind::apart : all ? Kind::neighbours : Kind::some_neighbours;
  }
}

const CouplingKernels& coupling_kernels() { return *HWY_DYNAMIC_DISPATCH(kernels)(); }

}  // namespace assur
#endif
