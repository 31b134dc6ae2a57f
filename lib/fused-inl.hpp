// Products and sums that are rounded once on every processor, so that all of them give the same bits. Without such an
// instruction, each takes the time of forty. Included once for each target, inside its HWY_NAMESPACE (see Highway,
// "foreach_target.h").
#if defined(ASSUR_FUSED_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_FUSED_INL
#undef ASSUR_FUSED_INL
#else
#define ASSUR_FUSED_INL
#endif

#include <hwy/highway.h>

#include <cstddef>

#include "fused.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// c + a b
template <class D, class V>
HWY_INLINE V fused([[maybe_unused]] D d, V a, V b, V c) {
#if HWY_NATIVE_FMA
  return hn::MulAdd(a, b, c);
#else
  using T = hn::TFromD<D>;
  HWY_ALIGN T x[hn::MaxLanes(D())], y[hn::MaxLanes(D())], z[hn::MaxLanes(D())];
  hn::Store(a, d, x);
  hn::Store(b, d, y);
  hn::Store(c, d, z);
  for (std::size_t i = 0; i < hn::MaxLanes(D()); ++i) z[i] = fused_number(x[i], y[i], z[i]);
  return hn::Load(d, z);
#endif
}
// c - a b
template <class D, class V>
HWY_INLINE V fused_negated([[maybe_unused]] D d, V a, V b, V c) {
#if HWY_NATIVE_FMA
  return hn::NegMulAdd(a, b, c);
#else
  return fused(d, hn::Neg(a), b, c);
#endif
}

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
