// Reads the inputs of a pack from the state arrays. Included once for each target, inside its
// HWY_NAMESPACE (see Highway, "foreach_target.h").
#if defined(ASSUR_GATHER_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_GATHER_INL
#undef ASSUR_GATHER_INL
#else
#define ASSUR_GATHER_INL
#endif

#include "equations/lane_vector-inl.hpp"
#include "group/pack_kernels.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

// One input; addresses: W.
template <int W>
HWY_INLINE Lanes<W> gather_input(const InputRow& row, const std::int32_t* addresses, const double* state) {
  if (W == 1 || row.kind == InputRow::Kind::same) return Lanes<W>::set(state[row.address]);
  if (row.kind == InputRow::Kind::consecutive) return Lanes<W>::load(state + row.address);
  double lanes[W];
  for (int w = 0; w < W; ++w) lanes[w] = state[addresses[w]];
  return Lanes<W>::load(lanes);
}

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
