// QuadraticEquations of a group of N unknowns, in arrays that stay in registers. Included once for each target, inside
// its HWY_NAMESPACE (see Highway, "foreach_target.h").
#if defined(ASSUR_SMALL_EQUATIONS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_SMALL_EQUATIONS_INL
#undef ASSUR_SMALL_EQUATIONS_INL
#else
#define ASSUR_SMALL_EQUATIONS_INL
#endif

#include "evaluation/quadratic_equations-inl.hpp"

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

#include "evaluation/coefficients.hpp"
#include "index.hpp"
#include "structure/grouped_system.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

// L, Source: see SmallGroup.
template <class L, int N>
class SmallEquations {
 public:
  using Column = L[N];
  using Matrix = L[N][N];

  explicit SmallEquations(const GroupClass& group_class)
      : class_(group_class), may_vanish_(terms_may_vanish(group_class)), equations_(group_class) {}

  template <class Source>
  HWY_INLINE void set_inputs(const Source& in) {
    equations_.set_inputs(coefficients(in), inputs(in, 0));
  }
  [[nodiscard]] HWY_INLINE bool has_gears() const { return !class_.gears.empty(); }
  [[nodiscard]] bool may_vanish() const { return may_vanish_; }

  template <class Source>
  HWY_INLINE void evaluate(const Source& in, const Column& x, Column& phi) {
    for (int j = 0; j < N; ++j) equations_.values().set(idx(j), x[j]);
    equations_.evaluate(coefficients(in), into(phi));
  }
  template <class Source>
  HWY_INLINE void differentiate(const Source& in, Matrix& jacobian) const {
    for (auto& row : jacobian) {
      for (L& entry : row) entry = L::set(0);
    }
    std::int32_t column = 0;
    equations_.differentiate(coefficients(in), [&](std::size_t k, const L& entry) HWY_ATTR {
      while (static_cast<std::int32_t>(k) >= class_.pattern.column_start[idx(column) + 1]) ++column;
      jacobian[class_.pattern.row[k]][column] = entry;
    });
  }
  template <class Source>
  HWY_INLINE void scale(const Source& in, Column& out) {
    equations_.scale(coefficients(in), into(out));
  }
  template <class Source>
  HWY_INLINE void velocity_rhs(const Source& in, Column& rhs) {
    equations_.velocity_rhs(coefficients(in), inputs(in, 1), into(rhs));
  }
  template <class Source>
  HWY_INLINE void acceleration_rhs(const Source& in, const Column& rate, Column& rhs) {
    for (int j = 0; j < N; ++j) equations_.rates().set(idx(j), rate[j]);
    equations_.acceleration_rhs(coefficients(in), inputs(in, 2), into(rhs));
  }

  // After set_inputs().
  HWY_INLINE L input(std::int32_t i) const { return equations_.value(N + i); }

 private:
  template <class Source>
  static HWY_INLINE auto coefficients(const Source& in) {
    return [&in](std::int32_t k) HWY_ATTR { return in.coefficient(k); };
  }
  // Derivatives of inputs that do not move are zero.
  template <class Source>
  HWY_INLINE auto inputs(const Source& in, int derivative) const {
    return [this, &in, derivative](std::int32_t i) HWY_ATTR {
      return derivative == 0 || class_.input_moves[idx(i)] != 0 ? in.input(derivative, i) : L::set(0);
    };
  }
  static HWY_INLINE auto into(Column& out) {
    return [&out](std::size_t i, const L& number) HWY_ATTR { out[i] = number; };
  }

  const GroupClass& class_;
  bool may_vanish_;
  QuadraticEquations<L> equations_;
};

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
