// Reads the numbers of a pack into vectors, for SmallGroup (program/small_group-inl.hpp). Included once for each
// target, inside its HWY_NAMESPACE (see Highway, "foreach_target.h").
#if defined(ASSUR_PACK_SOURCE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_PACK_SOURCE_INL
#undef ASSUR_PACK_SOURCE_INL
#else
#define ASSUR_PACK_SOURCE_INL
#endif

#include "evaluation/gather-inl.hpp"

#include <cstddef>
#include <cstdint>

#include "groups/pack.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

// The numbers of a pack in a state; inputs by the rows and addresses of the pack, or by others.
template <int W>
class PackSource {
  using L = Lanes<W>;

 public:
  PackSource(const Pack& pack, const double* const* state)
      : PackSource(pack, state, pack.input_rows.data(), pack.inputs.data()) {}
  PackSource(const Pack& pack, const double* const* state, const InputRow* rows, const std::int32_t* addresses)
      : pack_(pack), state_(state), rows_(rows), addresses_(addresses), coefficients_(pack.coefficients.data()) {}

  HWY_INLINE L coefficient(std::int32_t i) const { return L::load(coefficients_ + i * W); }
  HWY_INLINE L input(int derivative, std::int32_t i) const {
    return gather_input<W>(rows_[i], addresses_ + i * W, state_[derivative]);
  }
  HWY_INLINE L unknown(int j) const { return L::load(state_[0] + pack_.unknowns + j * W); }
  HWY_INLINE L anchor(std::size_t k) const { return L::load(pack_.anchor.data() + k * W); }
  HWY_INLINE L omega() const { return L::load(pack_.omega.data()); }

 private:
  const Pack& pack_;
  const double* const* state_;
  const InputRow* rows_;
  const std::int32_t* addresses_;
  const double* coefficients_;
};

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
