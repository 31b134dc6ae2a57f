// Reads the inputs of a pack from the state arrays. Included once for each target, inside its
// HWY_NAMESPACE (see Highway, "foreach_target.h").
#if defined(ASSUR_GATHER_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_GATHER_INL
#undef ASSUR_GATHER_INL
#else
#define ASSUR_GATHER_INL
#endif

#include "evaluation/input_row.hpp"
#include "evaluation/lane_vector-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

// Every second or third number, from the first one on.
template <int W>
HWY_INLINE Lanes<W> load_every_second(const double* from) {
  using L = Lanes<W>;
  L out;
  typename L::V next;
  for (int i = 0; i < L::kVectors; ++i, from += 2 * L::kEach)
    hn::LoadInterleaved2(typename L::D(), from, out.v[i], next);
  return out;
}
template <int W>
HWY_INLINE Lanes<W> load_every_third(const double* from) {
  using L = Lanes<W>;
  L out;
  typename L::V next, last;
  for (int i = 0; i < L::kVectors; ++i, from += 3 * L::kEach) {
    hn::LoadInterleaved3(typename L::D(), from, out.v[i], next, last);
  }
  return out;
}

// One input; addresses: W.
template <int W>
HWY_INLINE Lanes<W> gather_input(const InputRow& row, const std::int32_t* addresses, const double* state) {
  if (W == 1 || row.kind == InputRow::Kind::same) return Lanes<W>::set(state[row.address]);
  if (row.kind == InputRow::Kind::consecutive) return Lanes<W>::load(state + row.address);
  if (row.kind == InputRow::Kind::every_second) return load_every_second<W>(state + row.address);
  if (row.kind == InputRow::Kind::every_third) return load_every_third<W>(state + row.address);
  double lanes[W];
  for (int w = 0; w < W; ++w) lanes[w] = state[addresses[w]];
  return Lanes<W>::load(lanes);
}

// The same for a row that is not scattered. One body for both costs a step of small groups 2 % of its instructions.
template <int W>
HWY_INLINE Lanes<W> load_input(const InputRow& row, const double* state) {
  if (W == 1 || row.kind == InputRow::Kind::same) return Lanes<W>::set(state[row.address]);
  if (row.kind == InputRow::Kind::consecutive) return Lanes<W>::load(state + row.address);
  if (row.kind == InputRow::Kind::every_second) return load_every_second<W>(state + row.address);
  return load_every_third<W>(state + row.address);
}

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
